//! A stream that is answered allocates nothing.

#![allow(clippy::unwrap_used)]

mod support;

use allocation_counter::measure;
use support::{model, reading};
use taxel_stream::{Condition, Decider, StreamOptions};

#[test]
fn a_stream_that_is_answered_allocates_nothing() {
    let model = model();
    let plain = StreamOptions { hop: Some(1), ..StreamOptions::default() };
    let contact = StreamOptions { contact: true, early: Some(0.6), ..plain };
    for options in [plain, contact] {
        let mut decider = Decider::new(model.predictor(1, 1).unwrap(), &options).unwrap();
        let (mut decided, mut stuck) = (0, 0);
        let mut go = |from: usize, to: usize| {
            for t in from..to {
                if let Some(decision) = decider.push(&reading(t)) {
                    decided += usize::from(decision.probabilities().is_ok());
                    stuck += decision.health.in_condition(Condition::Stuck).count();
                }
            }
        };
        // What is looked up once per process is looked up here.
        go(0, 100);
        assert_eq!(measure(|| go(100, 1000)).count_total, 0, "{options:?}");
        assert!(decided > 100 && stuck == 0, "{decided} decisions");
    }
}
