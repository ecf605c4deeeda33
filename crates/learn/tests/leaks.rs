//! Leaks stand in the results and in their table.

#![allow(clippy::unwrap_used, clippy::panic)]

mod support;

use ndarray::{ArrayD, Axis};
use support::three_folds;
use taxel_baselines::Method;
use taxel_data::{Dataset, Layout};
use taxel_learn::{Candidate, CrossValidation, Leak, Protocol, Results, ResultsTable};

/// Recordings of noise of `classes` in turn.
fn noise(samples: usize, classes: usize) -> Dataset {
    let value = |at: ndarray::IxDyn| ((at[0] * 7919 + at[2] * 104_729) % 1009) as f32;
    let names = ["soft", "hard", "wet"];
    let labels: Vec<&str> = (0..samples).map(|i| names[i % classes]).collect();
    Dataset::new("noise", Layout::Series, ArrayD::from_shape_fn(vec![samples, 1, 9], value), &labels).unwrap()
}

fn nearest() -> Vec<Candidate> {
    vec![Candidate::baseline(Method::NearestNeighbours { k: 1 })]
}

fn table(results: &Results) -> String {
    ResultsTable::new(results, |_| None).to_string()
}

#[test]
fn copies_across_an_official_split_are_a_headline() {
    let dataset = noise(60, 2);
    let both = ndarray::concatenate(Axis(0), &[dataset.x.view(), dataset.x.view()]).unwrap();
    let labels: Vec<&str> = (0..120).map(|i| ["soft", "hard"][i % 60 % 2]).collect();
    let twice = Dataset::new("noise", Layout::Series, both, &labels).unwrap();
    let twice = twice.with_official((0..120).map(|i| i >= 60).collect()).unwrap();
    let run = |dataset: &Dataset| {
        let official: Protocol = serde_json::from_str(r#"{ "kind": "official" }"#).unwrap();
        let mut validation = CrossValidation::new(dataset).protocol(official);
        for candidate in nearest() {
            validation = validation.candidate(candidate);
        }
        validation.run().unwrap()
    };
    let results = run(&twice);
    assert_eq!(results.networks[0].score("accuracy"), Some(100.0), "which is what makes it dangerous");
    let example = ["x[60]", "x[0]"].map(String::from);
    assert!(results.leaks.contains(&Leak::Copies { copied: 60, tested: 60, example }), "{:?}", results.leaks);
    assert!(table(&results).contains("mind: 60 of 60 test samples are copies of training samples"));
    let once = dataset.with_official((0..60).map(|i| i >= 30).collect()).unwrap();
    assert_eq!(run(&once).leaks, []);
}

#[test]
fn a_class_that_no_training_part_has_is_named() {
    let dataset = noise(60, 3);
    // All wet recordings are of one session.
    let groups: Vec<usize> = (0..60).map(|i| if i % 3 == 2 { 9 } else { i / 6 % 5 }).collect();
    let dataset = dataset.with_groups(&groups).unwrap();
    let by_group: Protocol = serde_json::from_str(r#"{ "kind": "leave-group-out" }"#).unwrap();
    let results = CrossValidation::new(&dataset).protocol(by_group).candidate(nearest().remove(0)).run();
    let Ok(results) = results else { panic!("{:?}", results.unwrap_err()) };
    assert!(
        table(&results).contains("mind: wet is tested but not trained in 1 of 6 folds"),
        "{}",
        table(&results)
    );
}

#[test]
fn blocks_of_one_class_are_said() {
    let dataset = noise(60, 2);
    let order: Vec<usize> = (0..60).map(|i| if i < 30 { 2 * i } else { 2 * (i - 30) + 1 }).collect();
    let results = three_folds(&dataset.select(&order), nearest()).run().unwrap();
    let blocks = |leak: &&Leak| matches!(leak, Leak::Blocks { runs: 2, .. });
    assert_eq!(results.leaks.iter().filter(blocks).count(), 1, "{:?}", results.leaks);
    assert_eq!(three_folds(&dataset, nearest()).run().unwrap().leaks, []);
}

#[test]
fn a_first_time_step_that_tells_the_class_is_said() {
    let dataset = noise(60, 2);
    let warmer = |at: &ndarray::IxDyn| if at[0] % 2 == 1 { 5000.0 } else { 0.0 };
    let x = ArrayD::from_shape_fn(dataset.x.raw_dim(), |at| dataset.x[&at] + warmer(&at));
    let labels: Vec<&str> = (0..60).map(|i| ["soft", "hard"][i % 2]).collect();
    let warm = Dataset::new("noise", Layout::Series, x, &labels).unwrap();
    let results = three_folds(&warm, nearest()).run().unwrap();
    let [Leak::Beginning(early)] = results.leaks.as_slice() else { panic!("{:?}", results.leaks) };
    assert_eq!((early.accuracy, early.channel.clone()), (1.0, Some(("0".into(), 1.0))));
    let said = "mind: the first time step alone tells the class of 100.0 % (chance 50.0 %";
    assert!(table(&results).contains(said), "{}", table(&results));
}
