//! The page of a sweep.

#![allow(clippy::unwrap_used, clippy::panic)]

use taxel_judge::{Contest, Primary, rank};
use taxel_sweep::{KeyEffect, OpenTrial, ScoreSpread, Setting, Sweep, SweepProgress, sweep_page};

fn spread(mean: f64) -> ScoreSpread {
    ScoreSpread { count: 3, mean, sd: Some(1.5), least: mean - 2.0, most: mean + 2.0 }
}

#[test]
fn a_page_says_how_far_it_is_what_keys_do_and_what_is_missing() {
    let contest = |set: usize| Contest {
        name: format!("set{set}"),
        primary: Primary::default(),
        scores: [("good", 90.0), ("fair", 80.0), ("poor", 60.0)]
            .map(|(name, accuracy)| (name.to_string(), accuracy + set as f64))
            .into(),
    };
    let row = |value: &str, mean| ("mlp".to_string(), value.to_string(), spread(mean));
    let sweep = Sweep {
        name: "rates".into(),
        progress: SweepProgress {
            planned: 7,
            finished: 4,
            failed: 1,
            begun: 0,
            missing: 2,
            ..Default::default()
        },
        settings: vec![Setting {
            source: "simulated: <b>fingertip</b>".into(),
            network: "mlp".into(),
            set: "train.epochs=3".into(),
            primary: Primary::default(),
            score: spread(91.25),
        }],
        axes: vec![KeyEffect {
            key: "train.epochs".into(),
            primary: Primary::default(),
            rows: vec![row("3", 91.25), row("1", 70.0)],
        }],
        open: vec![OpenTrial {
            number: 6,
            trial: "tiny seed=6".into(),
            state: "failed".into(),
            reason: "the loss is NaN".into(),
        }],
        across: rank(&(0..5).map(contest).collect::<Vec<_>>(), 0.05).unwrap(),
        notes: vec!["One line.".into()],
    };
    let dir = tempfile::tempdir().unwrap();
    let page = sweep_page(&sweep, dir.path()).unwrap();
    let html = std::fs::read_to_string(&page).unwrap();
    for part in [
        "rates: 4 of 7 trials",
        "4 finished, 1 failed, 0 begun, 2 missing",
        "One line.",
        "simulated: &lt;b&gt;fingertip&lt;/b&gt;",
        "the loss is NaN",
        "The first 1 of 3, failed ones before others; all are in trials.csv.",
        "good ranks better than poor",
        "critical difference",
    ] {
        assert!(html.contains(part), "{part}");
    }
    let table = std::fs::read_to_string(dir.path().join("tables/axis-train-epochs.csv")).unwrap();
    assert_eq!(table.lines().nth(1), Some("mlp,3,3,91.25,1.5,89.25,93.25"));
    let chart = std::fs::read_to_string(dir.path().join("charts/axis-train-epochs.svg")).unwrap();
    roxmltree::Document::parse(&chart).unwrap();
    assert!(chart.contains("mlp, train.epochs = 3: 91.2 %, 3 trials"), "{chart}");
    assert!(dir.path().join("charts/critical-difference.png").is_file());
}
