//! Prints one sample of each layout under every fault and severity, for `scripts/pictures/faults.py`.
//!
//! A line holds layout, fault, severity and the readings; severity 0 is the clean sample.

use ndarray::{ArrayD, Axis};
use taxel_scenes::faults::{Fault, Layout, Sensor};
use taxel_scenes::{Fingertip, Imprint, Result};

/// A single image that swells and fades over `frames`, as an object pressed and let go.
fn squeeze(image: &ArrayD<f32>, frames: usize) -> ArrayD<f32> {
    let force = |t: usize| (std::f32::consts::PI * (t as f32 + 0.5) / frames as f32).sin();
    let frame = |t: usize| image.mapv(|v| (v + force(t) - 1.0).max(0.0));
    let mut sequence = ArrayD::zeros([&[frames], image.shape()].concat());
    sequence.axis_iter_mut(Axis(0)).enumerate().for_each(|(t, mut at)| at.assign(&frame(t)));
    sequence
}

/// Two fingers of six channels from two grasps.
fn fingers(grasps: &ArrayD<f32>) -> ArrayD<f32> {
    ArrayD::from_shape_fn(vec![2, 6, 50], |at| grasps[[at[0], at[1] % 5, at[2]]] * (1.0 - 0.1 * at[1] as f32))
}

fn main() -> Result<()> {
    let grasps = Fingertip::default().simulate(3, 1, &[])?.x;
    let imprints = Imprint { elements: 32, ..Imprint::default() }.simulate(8, 4, &[])?.x;
    let image = imprints.index_axis(Axis(0), 2).to_owned();
    for (layout, full_scale, clean) in [
        (Layout::Series, 1023.0, grasps.index_axis(Axis(0), 2).to_owned()),
        (Layout::Image, 1.0, image.clone()),
        (Layout::Sequence, 1.0, squeeze(&image, 8)),
        (Layout::Fingers, 1023.0, fingers(&grasps)),
    ] {
        let sensor = Sensor::new(layout, full_scale);
        let print = |fault: &str, level: String, severity: u8, x: &ArrayD<f32>| {
            let readings: Vec<String> = x.iter().map(f32::to_string).collect();
            println!("{layout:?}\t{fault}\t{level}\t{severity}\t{:?}\t{}", x.shape(), readings.join(" "));
        };
        for fault in Fault::ALL.into_iter().filter(|fault| fault.applicable(layout)) {
            print(fault.name(), "clean".into(), 0, &clean);
            for severity in 1..=5 {
                let mut broken = clean.clone();
                fault.apply(broken.view_mut(), &sensor, severity, 0, 3)?;
                print(
                    fault.name(),
                    format!("{} {}", fault.level(severity)?, fault.unit()),
                    severity,
                    &broken,
                );
            }
        }
    }
    Ok(())
}
