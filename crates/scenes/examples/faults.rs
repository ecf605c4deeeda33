//! Prints one sample of each layout under every fault and severity, for `scripts/pictures/faults.py`.
//!
//! A line holds layout, fault, level, shape and readings; the first of each fault is the clean sample.

use ndarray::{ArrayD, Axis};
use taxel_faults::Fault;
use taxel_scenes::{Fingertip, Gripper, Imprint, Palpation, Result, Scene};

/// Selects the shown part of a sample: some frames of a sequence, DC and one AC channel of each finger.
fn shown(name: &str, sample: &ArrayD<f32>) -> ArrayD<f32> {
    match name {
        "palpation" => sample.select(Axis(0), &[12, 22, 32, 42]),
        "gripper" => sample.select(Axis(1), &[0, 5]),
        _ => sample.clone(),
    }
}

fn show(name: &str, clean: &Scene) -> Result<()> {
    let print = |fault: Fault, level: &str, scene: &Scene| {
        let x = shown(name, &scene.x.index_axis(Axis(0), 2).to_owned());
        let readings: Vec<String> = x.iter().map(f32::to_string).collect();
        println!("{:?}\t{fault}\t{level}\t{:?}\t{}", scene.layout, x.shape(), readings.join(" "));
    };
    for fault in Fault::ALL.into_iter().filter(|fault| fault.applicable(clean.layout)) {
        print(fault, "clean", clean);
        for severity in 1..=5 {
            let mut broken = clean.clone();
            broken.corrupt(fault, severity, 3)?;
            print(fault, &format!("{} {}", fault.level(severity)?, fault.unit()), &broken);
        }
    }
    Ok(())
}

fn main() -> Result<()> {
    show("fingertip", &Fingertip::default().simulate(3, 1, &[])?)?;
    show("imprint", &Imprint { elements: 32, ..Imprint::default() }.simulate(3, 1, &[])?)?;
    show("palpation", &Palpation::default().simulate(3, 1, &[])?)?;
    show("gripper", &Gripper::default().simulate(3, 1, &[])?)
}
