//! Arrays in memory: which of three methods tells presses of soft from presses of hard things?
//!
//! `cargo run --release --example own_dataset`

use taxel::ndarray::ArrayD;
use taxel::{
    Baseline, Candidate, CrossValidation, Dataset, Encoding, Layout, Model, Protocol, Recipe, Registry,
};

fn main() -> taxel::Result<()> {
    // 40 presses [N, channels, time]: two sensors, 30 readings each. Hard things push back at once. Ten days.
    let reading = |press: usize, sensor: usize, time: usize| {
        let stiffness = [0.4, 0.6][press % 2];
        let noise = 20.0 * ((press * 97 + sensor * 31 + time * 13) as f32).sin();
        600.0 * stiffness * (time as f32 / 30.0).powf(1.0 - 0.2 * stiffness) + noise
    };
    let x = ArrayD::from_shape_fn(vec![40, 2, 30], |at| reading(at[0], at[1], at[2]));
    let labels: Vec<&str> = (0..40).map(|i| ["soft", "hard"][i % 2]).collect();
    let days: Vec<usize> = (0..40).map(|i| i / 4).collect();
    let presses = Dataset::new("presses", Layout::Series, x, &labels)?
        .with_groups(&days)?
        .with_unit("counts")
        .with_rate(100.0)?
        .with_full_scale(1023.0)?;

    // A network of the zoo, sized by the data, beside two baselines; no day is both trained and tested on.
    let registry = Registry::built_in();
    let entry = registry.find("resnet8-lite-1d")?;
    let settings = entry.fit(2, |_| Some(presses.sample_shape().to_vec()))?;
    let network = Candidate::network(entry.graph(&settings)?, Recipe { epochs: 20, ..Recipe::default() });
    let results = CrossValidation::new(&presses)
        .protocol(Protocol::group_k_fold(5))
        .candidate(network)
        .candidate(Candidate::baseline(Baseline::NearestNeighbours { k: 1 }))
        .candidate(Candidate::baseline(Baseline::MiniRocket { features: 1000 }))
        .run()?;
    println!("{}", taxel::ResultsTable::new(&results, |_| None));

    // Baselines ship like networks.
    let rocket = Candidate::baseline(Baseline::MiniRocket { features: 1000 });
    let path = std::env::temp_dir().join("presses.safetensors");
    taxel::fit(&rocket, &presses, &Encoding::default())?
        .with_score(results.score("mini-rocket"))
        .save(&path)?;
    print!("{}", Model::open(&path)?.card());
    Ok(())
}
