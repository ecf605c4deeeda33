//! Answers of a shipped model, reading by reading.
//!
//! `cargo run --release --example predict -- model.safetensors recordings.npz`; without files it makes both.

use taxel::{Baseline, Candidate, Encoding, Model, ReadOptions};

fn main() -> taxel::Result<()> {
    let mut files = std::env::args().skip(1);
    let (model, recordings) = match (files.next(), files.next()) {
        (Some(model), Some(recordings)) => {
            (Model::open(model.as_ref())?, taxel::load(recordings.as_ref(), &ReadOptions::default())?)
        }
        _ => {
            let grasps = taxel::simulate("fingertip", 60, 0, &[])?;
            let nearest = Candidate::baseline(Baseline::NearestNeighbours { k: 3 });
            (taxel::fit(&nearest, &grasps, &Encoding::default())?, grasps)
        }
    };
    print!("{}", model.card());

    // One predictor answers many: it keeps its buffers.
    let predictor = model.predictor(1, 1)?;
    for i in 0..recordings.len().min(5) {
        let reading = recordings.select(&[i]).x;
        for answer in predictor.predict(&reading)?.predicted(0) {
            let percent = 100.0 * answer.probability;
            println!("{}: {} {} ({percent:.0} %)", recordings.origins[i], answer.attribute, answer.class);
        }
    }
    Ok(())
}
