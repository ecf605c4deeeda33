//! A custom network, from recordings to a model that answers.
//!
//! `cargo run --release --example own_network -- recordings.npz`; without a file, on simulated grasps.

use taxel::{Candidate, Conv, CrossValidation, Encoding, Model, Network, Recipe, ResultsTable};

fn main() -> taxel::Result<()> {
    let recordings = match std::env::args().nth(1) {
        Some(path) => taxel::load(path.as_ref(), &taxel::ReadOptions::default())?,
        None => taxel::simulate("fingertip", 300, 0, &[])?,
    };
    let net = Network::new("own");
    let signal = net.input("signal", recordings.sample_shape());
    let x =
        signal.conv_bn_relu("stem", Conv::new(32, 5).same()).conv_bn_relu("deep", Conv::new(32, 3).same());
    let logits = x.global_average_pool().linear("fc", recordings.output_names().len());
    let graph = net.finish(&[("logits", logits)])?;

    let candidate = Candidate::network(graph, Recipe { epochs: 20, ..Recipe::default() });
    let results = CrossValidation::new(&recordings).candidate(candidate.clone()).run()?;
    println!("{}", ResultsTable::new(&results, |_| None));

    let model = taxel::fit(&candidate, &recordings, &Encoding::default())?.with_score(results.score("own"));
    let path = std::env::temp_dir().join("own.safetensors");
    model.save(&path)?;

    let answers = Model::open(&path)?.predict(&recordings.select(&[0]).x)?;
    println!("{}: {}", recordings.origins[0], answers.class(0));
    Ok(())
}
