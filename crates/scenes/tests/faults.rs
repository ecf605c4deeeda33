//! Every scene can be broken, and knows what its sensors read at rest.

#![allow(clippy::unwrap_used)]

use ndarray::Axis;
use taxel_faults::Fault;

#[test]
fn every_scene_can_be_broken_and_knows_its_rest() {
    for name in taxel_scenes::names() {
        let clean = taxel_scenes::simulate(name, 2, 0, &[]).unwrap();
        assert!(clean.layout.fits(&clean.x.shape()[1..]), "{name}");
        for fault in Fault::ALL.into_iter().filter(|fault| fault.applicable(clean.layout)) {
            let mut broken = clean.clone();
            broken.corrupt(fault, 5, 0).unwrap();
            assert_eq!(broken.x.shape(), clean.x.shape());
            assert!(broken.x.iter().all(|v| (0.0..=clean.full_scale).contains(v)), "{name} {fault}");
        }
        let mut dead = clean.clone();
        dead.corrupt(Fault::DeadLine, 1, 0).unwrap();
        // What dies reads as it did before contact, give or take noise and a session's offset.
        let changed = dead.x.iter().zip(&clean.x).filter(|(dead, clean)| dead != clean);
        let rests = dead.sensor().rest;
        assert!(
            changed.clone().count() > 0 && changed.clone().all(|(dead, _)| rests.contains(dead)),
            "{name}"
        );
    }
    let gripper = taxel_scenes::simulate("gripper", 3, 0, &[]).unwrap();
    let first = gripper.x.index_axis(Axis(0), 0);
    let gaps = first
        .index_axis(Axis(2), 0)
        .iter()
        .zip(&gripper.rest)
        .map(|(v, rest)| (v - rest).abs())
        .collect::<Vec<_>>();
    assert!(gaps.iter().all(|&gap| gap < 60.0), "rest is what a finger reads before contact: {gaps:?}");
}
