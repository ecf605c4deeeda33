//! Checks that configs and pages say what follows from the papers' printed numbers.

#![allow(clippy::unwrap_used)]

use std::fs;
use std::path::{Path, PathBuf};

use taxel::{Experiment, Overrides, Registry};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn text(path: &str) -> String {
    fs::read_to_string(root().join(path)).unwrap()
}

fn table(path: &str) -> toml::Table {
    text(path).parse().unwrap()
}

/// Returns the rows of a printed table: the row's name here, and what is printed.
fn printed(paper: &str, name: &str) -> Vec<(String, String)> {
    let papers = table("docs/results/papers.toml");
    let is_it = |t: &&toml::Value| t["paper"].as_str() == Some(paper) && t["table"].as_str() == Some(name);
    let found = papers["tables"].as_array().unwrap().iter().find(is_it).unwrap();
    let of = |row: &toml::Value, key: &str| row[key].as_str().unwrap().to_string();
    found["rows"].as_array().unwrap().iter().map(|row| (of(row, "row"), of(row, "published"))).collect()
}

fn mean_of(published: &str) -> f64 {
    published.split(' ').next().unwrap().parse().unwrap()
}

/// Checks whether a percentage of two decimals is a whole number of so many.
fn fits(percent: f64, of: f64) -> bool {
    (100.0 * (percent * of / 100.0).round() / of - percent).abs() <= 0.0051
}

#[test]
fn gandarias_2019b_tests_108_squeezes() {
    // Fig. 7: all of seven objects, 75 % and 91.67 % of two more, 96.30 % of all.
    for (of_each, is_it) in [(12.0, true), (6.0, false)] {
        let two = fits(75.0, of_each) && fits(91.67, of_each);
        let right = 7.0 * of_each
            + [75.0, 91.67].map(|percent: f64| (percent * of_each / 100.0).round()).iter().sum::<f64>();
        assert_eq!(
            two && fits(96.30, 9.0 * of_each) && (100.0 * right / (9.0 * of_each) - 96.30).abs() < 0.01,
            is_it
        );
    }
    let means: Vec<f64> = printed("002", "Table I").iter().map(|(_, published)| mean_of(published)).collect();
    let fitting = |tests: f64| means.iter().filter(|mean| fits(**mean, 20.0 * tests)).count();
    assert_eq!((fitting(108.0), fitting(54.0)), (4, 2));
    let config = table("configs/palpation/palpation-002-table-1.toml");
    let samples = config["data"]["samples"].as_integer().unwrap() as f64;
    assert_eq!((samples * config["protocol"]["test"].as_float().unwrap()).round(), 108.0);
    assert_eq!(
        table("configs/palpation/palpation-002-fresh.toml")["protocol"]["train"].as_integer(),
        Some(540 - 108)
    );
}

#[test]
fn gandarias_2019b_has_no_placement_in_any_config_of_its_tables() {
    for name in ["palpation-002-table-1", "palpation-002-fresh"] {
        let config = table(&format!("configs/palpation/{name}.toml"));
        assert_eq!(config["data"]["set"]["factors"]["placement"].as_float(), Some(0.0), "{name}");
    }
    let study = table("crates/reproduction/studies/palpation-002-placement.toml");
    let factors = study["grid"]["data"]["set"]["factors"]["placement"].as_array().unwrap();
    assert_eq!(
        (factors.first().unwrap().as_float(), factors.last().unwrap().as_float()),
        (Some(0.0), Some(1.0))
    );
    let config = root().join("crates/reproduction/studies").join(study["config"].as_str().unwrap());
    assert!(config.exists(), "{}", config.display());
    // Each factor of the study is one that the scene takes, and each gives another accuracy to read off.
    for factor in factors {
        let set = vec![
            format!("data.set.factors.placement={factor}"),
            "protocol.train=9".into(),
            "protocol.test=9".into(),
        ];
        let overrides = Overrides { set, quick: true, ..Overrides::default() };
        let experiment = Experiment::load(&config, &overrides, &Registry::built_in()).unwrap();
        let source = experiment.dataset().unwrap().source.to_string();
        assert!(source.ends_with(&format!("with {} of placement", factor.as_float().unwrap())), "{source}");
    }
}

/// Eq. 4 as printed counts the samples of all other classes that are not taken for a class as right.
#[test]
fn kaewrakmuk_2026_prints_plain_accuracies() {
    let config = table("configs/hardness/hardness.toml");
    let mut rows = 0;
    for network in config["networks"].as_array().unwrap() {
        let Some(published) = network.get("published") else { continue };
        let of = |key: &str| published.get(key).map(|pair| pair[0].as_float().unwrap());
        let (Some(accuracy), Some(recall)) = (of("accuracy"), of("recall")) else { continue };
        // Three classes of equal size: of each mistake two of three one-against-rest counts are wrong.
        let one_against_rest = 100.0 - 2.0 * (100.0 - recall) / 3.0;
        assert!((accuracy - recall).abs() < 0.011 && (accuracy - one_against_rest).abs() > 3.0, "{network}");
        rows += 1;
    }
    assert!(rows >= 10, "{rows}");
    assert!(text("docs/papers.md").contains("**000, Eq. 4**"));
}

/// ViTac's 12 classes and VT-60's 10: the tables' columns "above random guess" say which has which.
#[test]
fn rouhafzay_2021_swaps_two_chances_in_its_text() {
    for (name, tuned, above, classes) in [("Table 1", 92.29, 82.29, 10.0), ("Table 2", 98.97, 90.64, 12.0)] {
        let rows = printed("001", name);
        let (_, published) = rows.iter().find(|(row, _)| row == "resnet50-tuned").unwrap();
        assert!((mean_of(published) - tuned).abs() < 1e-9, "{name}");
        assert!((tuned - above - 100.0f64 / classes).abs() < 0.011, "{name}");
    }
}

/// Epochs of Tables 1 to 5 as the paper prints them; a config that has others says what the paper has, and so do its remarks.
#[test]
fn other_epochs_than_the_paper_s_are_said() {
    for (table_number, paper) in [(1, 20), (2, 10), (3, 10), (4, 10), (5, 10)] {
        let name = format!("visuotactile-001-eyes-table-{table_number}");
        let config = text(&format!("configs/visuotactile/{name}.toml"));
        let line = config.lines().find(|line| line.starts_with("epochs = ")).unwrap();
        let ours: u32 = line["epochs = ".len()..].split(' ').next().unwrap().parse().unwrap();
        let remarks = text(&format!("docs/results/remarks/{name}.md"));
        if ours == paper {
            assert!(line.ends_with("# as the paper"), "{name}: {line}");
        } else {
            assert!(line.ends_with(&format!("# {paper} in the paper")), "{name}: {line}");
            assert!(
                remarks.contains(&format!("{ours} epochs"))
                    && remarks.contains(&format!("paper has {paper}")),
                "{name}"
            );
        }
    }
}

#[test]
fn statistics_of_frozen_layers_are_said() {
    let of = |name: &str| {
        table(&format!("configs/visuotactile/{name}.toml"))["train"]["frozen_statistics"]
            .as_str()
            .map(String::from)
    };
    assert_eq!(of("visuotactile-001-section-7").as_deref(), Some("kept"));
    assert_eq!(of("visuotactile-001-table-6").as_deref(), Some("renewed"));
    for page in ["docs/results/visuotactile-001-section-7.md", "scripts/stitch_experiment.py"] {
        assert!(text(page).contains("layers 18 to 139 keep ImageNet's statistics"), "{page}");
    }
}

/// Computes how much of the statistics at the start is left after the steps of the run, with torchvision's momentum of MnasNet.
#[test]
fn mnasnet_s_averages_have_moved_by_two_thirds() {
    let config = table("configs/strength/strength-004-table-2.toml");
    let number = |section: &str, key: &str| config[section][key].as_integer().unwrap() as f64;
    let trained =
        (number("data", "samples") * (1.0 - config["protocol"]["test"].as_float().unwrap())).round();
    let steps = number("train", "epochs") * (trained / number("train", "batch_size")).ceil();
    let left = (1.0f64 - 0.0003).powf(steps);
    let remarks = text("docs/results/remarks/strength-004-table-2.md");
    assert!(remarks.contains("3,800 steps") && steps == 3800.0, "{steps}");
    assert!(remarks.contains(&format!("= {left:.2})")), "{left}");
}

/// The defaults of MATLAB's trainingOptions, which two papers do not say that they changed, are settings that a run takes.
#[test]
fn matlab_s_defaults_can_be_tried() {
    let page = text("docs/papers.md");
    let command = page.split("To try MATLAB's:\n  `").nth(1).unwrap().split('`').next().unwrap();
    let set: Vec<String> = command.split("--set ").skip(1).map(|setting| setting.trim().into()).collect();
    assert_eq!(set.len(), 2, "{command}");
    let load = |set: Vec<String>| {
        let path = root().join("configs/palpation/palpation-003-fresh.toml");
        Experiment::load(&path, &Overrides { set, ..Overrides::default() }, &Registry::built_in()).unwrap()
    };
    let [plain, matlab] = [load(vec![]), load(set)].map(|experiment| experiment.to_toml());
    assert!(matlab.contains("init = \"glorot\"") && matlab.contains("weight_decay = 0.0001"), "{matlab}");
    assert!(!plain.contains("glorot") && plain != matlab);
}
