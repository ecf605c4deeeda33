//! Delay and false alarms against a count step by step; `scripts/fixtures/detections.py` writes its numbers.

#![allow(clippy::unwrap_used)]

use serde_json::Value;
use taxel_data::{Labels, TargetSteps, Targets, Task};
use taxel_learn::metrics::{Metric, Outcome, Scores, scores, shown};

const NAMES: [&str; 5] =
    ["missed_events", "delay", "delay_steps", "false_alarms_per_minute", "false_alarms_per_1000_steps"];

fn whole(value: &Value) -> Vec<u32> {
    value.as_array().unwrap().iter().map(|v| v.as_u64().unwrap() as u32).collect()
}

/// Returns classes of time steps.
fn targets(case: &Value) -> Targets {
    let classes = ["rest", "speed > 1"].map(String::from);
    let labels = Labels::of_classes(&classes, &whole(&case["event"]));
    let steps = TargetSteps {
        recordings: whole(&case["recordings"]),
        steps: whole(&case["steps"]),
        hop: case["hop"].as_u64().unwrap() as u32,
        rate: case["rate"].as_f64(),
    };
    Targets::Classes { labels, columns: None, steps: Some(steps) }
}

fn outcome(targets: &Targets, called: &[u32]) -> Outcome {
    let rows: Vec<usize> = (0..targets.len()).collect();
    let said = |called: &u32| if *called == 1 { [0.2, 0.8] } else { [0.9, 0.1] };
    Outcome::new(targets, &rows, called.iter().flat_map(said).collect())
}

#[test]
fn delays_and_false_alarms_are_those_of_a_count_step_by_step() {
    let fixture: Value = serde_json::from_str(include_str!("data/detections.json")).unwrap();
    let cases = fixture["cases"].as_array().unwrap();
    assert_eq!(cases.len(), 5);
    for case in cases {
        let targets = targets(case);
        let all = scores(&targets.task(), &outcome(&targets, &whole(&case["called"]))).unwrap();
        for name in NAMES {
            let (got, want) = (all.get(name), case[name].as_f64());
            let is_same = match (got, want) {
                (Some(got), Some(want)) => (got - want).abs() < 1e-9,
                (got, want) => got.is_none() && want.is_none(),
            };
            assert!(is_same, "{}: {name} is {got:?}, want {want:?}", case["name"]);
        }
    }
}

#[test]
fn recordings_with_one_class_each_have_no_events() {
    let classes = ["rest", "slip"].map(String::from);
    let targets = Targets::classes(&classes, &[0, 1, 1, 0]);
    let task = targets.task();
    let all = scores(&task, &outcome(&targets, &[0, 1, 0, 0])).unwrap();
    assert!(NAMES.iter().all(|name| all.get(name).is_none()));
    assert!(all.get("auroc").is_some());
    let titles = |each: &[&Scores]| {
        shown(&task, each.iter().copied()).iter().map(|metric| metric.with_unit(&task)).collect::<Vec<_>>()
    };
    assert_eq!(titles(&[&all]), ["accuracy %", "precision %", "recall %", "F1 %"]);
    let fixture: Value = serde_json::from_str(include_str!("data/detections.json")).unwrap();
    let case = &fixture["cases"][0];
    let timed = self::targets(case);
    let of_steps = scores(&task, &outcome(&timed, &whole(&case["called"]))).unwrap();
    let events = ["AUROC %", "average precision %", "missed events %", "delay s", "false alarms per minute"];
    assert_eq!(titles(&[&all, &of_steps])[4..], events);
    assert_eq!(Metric::named(&task, "delay_steps").unwrap().with_unit(&task), "delay steps");
    let three = Task::Classes(["a", "b", "c"].map(String::from).to_vec());
    assert!(Metric::named(&three, "delay").is_none());
}

#[test]
fn an_outcome_keeps_its_time_steps() {
    let fixture: Value = serde_json::from_str(include_str!("data/detections.json")).unwrap();
    let case = &fixture["cases"][1];
    let targets = targets(case);
    let kept = outcome(&targets, &whole(&case["called"]));
    assert!(kept.fits(&targets.task(), targets.len()));
    let text = serde_json::to_string(&kept).unwrap();
    assert_eq!(serde_json::from_str::<Outcome>(&text).unwrap(), kept);
    let Outcome::Labels { truth, predicted, probabilities, untrained, steps } = kept else { return };
    let steps = steps.map(|steps| steps.of(&[0, 1]));
    let torn = Outcome::Labels { truth, predicted, probabilities, untrained, steps };
    assert!(!torn.fits(&targets.task(), targets.len()));
}
