//! Reading configs: messages with places, overrides, round trips.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use taxel_trainer::{Error, Experiment, Overrides, Range, Samples};

const BASE: &str = r#"name = "tiny"

[data]
scene = "fingertip"
samples = 60

[encoding]
image = { kind = "gadf" }

[train]
epochs = 7

[[networks]]
name = "mlp"
set = { hidden = 16 }

[[networks]]
name = "vgg6-lite-2d"
train = { batch_size = 8, optimizer = { lr = 1e-4 } }

[quick]
data.samples = 12
train.epochs = 2
train.schedule = { kind = "steps", at = [0.5] }
"#;

fn parse(text: &str) -> Result<Experiment, Error> {
    Experiment::parse(text, "tiny.toml", &Overrides::default())
}

fn set(sets: &[&str]) -> Result<Experiment, Error> {
    let set = sets.iter().map(ToString::to_string).collect();
    Experiment::parse(BASE, "tiny.toml", &Overrides { set, ..Overrides::default() })
}

/// The message for `BASE` with `from` replaced by `to`.
fn message(from: &str, to: &str) -> String {
    assert!(BASE.contains(from), "{from}");
    parse(&BASE.replace(from, to)).unwrap_err().to_string()
}

#[test]
fn defaults_are_the_papers_recipe() {
    let experiment = parse(BASE).unwrap();
    let config = experiment.config();
    let train = config.networks[0].train(&config.train);
    assert_eq!((train.epochs, train.batch_size), (7, 64));
    assert_eq!((train.optimizer.lr, train.optimizer.momentum), (0.01, 0.9));
    assert_eq!(train.schedule.rate(0.01, 6, 7), 0.01);
    let own = config.networks[1].train(&config.train);
    assert_eq!((own.epochs, own.batch_size, own.optimizer.lr), (7, 8, 1e-4));
    assert_eq!(own.optimizer.momentum, 0.9);
    let image = config.encoding.image.clone().unwrap();
    assert_eq!((image.size, image.range), (Some(50), Some(Range::PerSample)));
    assert_eq!(config.protocol.folds, Some(5));
}

#[test]
fn unknown_keys_and_wrong_types_name_file_line_and_column() {
    let text = message("epochs = 7", "epoch = 7");
    assert!(text.starts_with("tiny.toml:11:1: unknown field `epoch`, expected one of `epochs`"), "{text}");
    assert!(text.ends_with("\n  11 | epoch = 7"), "{text}");
    let text = message("epochs = 7", "epochs = \"seven\"");
    assert!(text.starts_with("tiny.toml:11:10: invalid type: string \"seven\""), "{text}");
    let text = message("kind = \"gadf\"", "kind = \"gadf\", range = { low = 1, hihg = 2 }");
    assert!(text.starts_with("tiny.toml:8:"), "{text}");
    assert!(text.contains("unknown field `hihg`, expected `low` or `high`"), "{text}");
    let text = message("kind = \"gadf\"", "kind = \"gadf\", range = \"sample\"");
    assert!(text.starts_with("tiny.toml:8:") && text.contains("per-sample"), "{text}");
    let text = message("epochs = 7", "epochs = ");
    assert!(text.starts_with("tiny.toml:11:"), "{text}");
    // A mistake in [quick] must not wait for --quick's full run to be noticed there.
    let quick = Overrides { quick: true, ..Overrides::default() };
    let text = BASE.replace("data.samples = 12", "data.sample = 12");
    let text = Experiment::parse(&text, "tiny.toml", &quick).unwrap_err().to_string();
    assert!(text.starts_with("tiny.toml:22: unknown field `sample`"), "{text}");
}

#[test]
fn values_out_of_range_name_the_line_and_the_range() {
    assert_eq!(message("epochs = 7", "epochs = 0"), "tiny.toml:11: train.epochs = 0: must be in 1..=100000");
    let cases = [
        ("epochs = 7", "optimizer = { lr = nan }", "tiny.toml:11: train.optimizer.lr = NaN: "),
        ("epochs = 7", "optimizer = { lr = 1e-60 }", "tiny.toml:11: train.optimizer.lr = "),
        ("epochs = 7", "optimizer = { momentum = 1.0 }", "tiny.toml:11: train.optimizer.momentum = 1: "),
        ("epochs = 7", "optimizer = { weight_decay = nan }", "tiny.toml:11: train.optimizer.weight_decay"),
        ("epochs = 7", "schedule = { kind = \"steps\", at = [0.5, nan] }", "tiny.toml:11: train.schedule.at"),
        ("epochs = 7", "schedule = { kind = \"steps\" }", "tiny.toml:11: train.schedule.at"),
        ("epochs = 7", "schedule = { kind = \"constant\", factor = 0.1 }", "tiny.toml:11: train.schedule"),
        ("lr = 1e-4", "lr = -1.0", "tiny.toml:19: networks.1.train.optimizer.lr = -1: "),
        ("samples = 60", "samples = 0", "tiny.toml:5: data.samples = 0: "),
        ("samples = 60", "full_scale = inf", "tiny.toml:5: data.full_scale = inf: "),
        ("samples = 60", "channels = [0]", "tiny.toml:5: data.channels = ..: works with data.path only"),
        ("samples = 60", "path = \"x.npz\"", "tiny.toml:5: data.path = \"x.npz\": give either"),
        ("\"fingertip\"", "\"fist\"", "tiny.toml:4: data.scene = \"fist\": no scene has this name"),
        ("kind = \"gadf\"", "kind = \"gadf\", size = 1", "tiny.toml:8: encoding.image.size = 1: "),
        ("kind = \"gadf\"", "kind = \"raw\", size = 9", "tiny.toml:8: encoding.image.size = ..: belongs"),
        (
            "kind = \"gadf\"",
            "kind = \"gadf\", range = { low = 1, high = nan }",
            "tiny.toml:8: encoding.image.",
        ),
        ("name = \"tiny\"", "name = \"../tiny\"", "tiny.toml:1: name = \"../tiny\": "),
        (
            "\"mlp\"",
            "\"mpl\"",
            "tiny.toml:14: networks.0.name = \"mpl\": no network is called `mpl`; did you mean `mlp`?",
        ),
        ("hidden = 16", "hiden = 16", "tiny.toml:15: networks.0.set = "),
        ("hidden = 16", "classes = 16", "tiny.toml:15: networks.0.set.classes = 16: comes from the data"),
        ("\"vgg6-lite-2d\"", "\"mlp\"", "tiny.toml:17: networks.1.label = \"mlp\": two networks"),
    ];
    for (from, to, expected) in cases {
        let text = message(from, to);
        assert!(text.starts_with(expected), "{to}\n  got  {text}\n  want {expected}");
    }
}

#[test]
fn a_second_copy_of_a_network_needs_a_label() {
    let text = BASE.replace("\"vgg6-lite-2d\"", "\"mlp\"\nlabel = \"mlp-slow\"");
    assert_eq!(parse(&text).unwrap().config().networks[1].label(), "mlp-slow");
}

#[test]
fn an_unset_variable_is_named_with_the_line_that_uses_it() {
    let path = "path = \"${TAXEL_NO_SUCH_VARIABLE}/set\"";
    let text = BASE.replace("scene = \"fingertip\"\nsamples = 60", path).replace("data.samples = 12\n", "");
    let error = Samples::load(&parse(&text).unwrap()).unwrap_err().to_string();
    assert!(error.starts_with("tiny.toml:4: data.path = "), "{error}");
    assert!(error.contains("environment variable TAXEL_NO_SUCH_VARIABLE is not set"), "{error}");
    assert!(error.contains("--data PATH"), "{error}");
    let text = text.replace("TAXEL_NO_SUCH_VARIABLE", "CARGO_MANIFEST_DIR");
    let path = parse(&text).unwrap().data_path().unwrap().unwrap();
    assert_eq!(path, std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("set"));
}

#[test]
fn quick_values_replace_full_ones() {
    let quick = Overrides { quick: true, ..Overrides::default() };
    let experiment = Experiment::parse(BASE, "tiny.toml", &quick).unwrap();
    let config = experiment.config();
    assert_eq!((config.data.samples, config.train.epochs), (Some(12), 2));
    assert_eq!(config.train.schedule.rate(1.0, 1, 2), 0.1);
    assert!(config.quick.is_empty());
    assert_ne!(experiment.default_out(), parse(BASE).unwrap().default_out());
    let without = BASE.split("[quick]").next().unwrap();
    let error = Experiment::parse(without, "tiny.toml", &quick).unwrap_err().to_string();
    assert_eq!(error, "tiny.toml: has no [quick] table; leave --quick out");

    // A grid's keys are dotted themselves: it is replaced whole.
    let chosen = BASE.replace(
        "[quick]",
        "[choose]\ngrid = { \"optimizer.lr\" = [0.1, 0.01], \"batch_size\" = [8, 16] }\n\n[quick]\nchoose.grid = { \"optimizer.lr\" = [0.1] }",
    );
    let experiment = Experiment::parse(&chosen, "tiny.toml", &quick).unwrap();
    let grid = &experiment.config().choose.as_ref().unwrap().grid;
    assert_eq!(grid.keys().collect::<Vec<_>>(), ["optimizer.lr"]);
    assert_eq!(grid["optimizer.lr"].len(), 1);
}

#[test]
fn set_values_come_last() {
    let set_over_quick =
        Overrides { quick: true, set: vec!["train.epochs=3".into()], ..Overrides::default() };
    let experiment = Experiment::parse(BASE, "tiny.toml", &set_over_quick).unwrap();
    assert_eq!(experiment.config().train.epochs, 3);
    let experiment = set(&[
        "name=other",
        "train.optimizer.lr=1e-3",
        "networks.1.train.epochs=4",
        "encoding.image={ kind = \"gasf\", range = { low = 0, high = 1023 } }",
        "data.without=[\"noise\"]",
    ])
    .unwrap();
    let config = experiment.config();
    assert_eq!((config.name.as_str(), config.train.optimizer.lr), ("other", 1e-3));
    assert_eq!(config.networks[1].train(&config.train).epochs, 4);
    assert_eq!(config.encoding.image.clone().unwrap().range, Some(Range::Fixed { low: 0.0, high: 1023.0 }));
    assert_eq!(config.data.without, ["noise"]);
    for (bad, expected) in [
        ("train.epochs", "--set train.epochs: must be key=value"),
        ("train.epoch=3", "--set train.epoch=3: unknown field `epoch`"),
        ("train.epochs=0", "--set train.epochs=0: train.epochs = 0: must be in"),
        ("train.epochs=many", "--set train.epochs=many: invalid type"),
        ("train.epochs.x=1", "--set train.epochs.x=1: `x` lies in 7, which is no table"),
        ("networks.7.name=mlp", "--set networks.7.name=mlp: `7` is not a position in an array of 2"),
        ("=1", "--set =1: `` is not a key"),
    ] {
        let text = set(&[bad]).unwrap_err().to_string();
        assert!(text.starts_with(expected), "{text}");
    }
}

#[test]
fn data_on_the_command_line_replaces_the_scene() {
    let overrides =
        Overrides { data: Some("my.npz".into()), seed: Some(9), quick: true, ..Overrides::default() };
    let experiment = Experiment::parse(BASE, "tiny.toml", &overrides).unwrap();
    let data = &experiment.config().data;
    assert_eq!((data.path.as_deref(), data.scene.as_deref(), data.samples), (Some("my.npz"), None, None));
    assert_eq!(experiment.config().seed, 9);
}

#[test]
fn a_resolved_config_reads_back_as_itself() {
    let full = "encoding.image={ kind = \"gadf\", range = { low = 0.1, high = 1023 }, constant = \"zero\" }";
    let published = "networks.0.published={ table = \"paper 000, Table 5\", accuracy = [83.13, 2.39] }";
    for sets in [
        vec![],
        vec![
            full,
            published,
            "encoding.baseline=2",
            "train.schedule={ kind = \"steps\", at = [0.6] }",
            "data.without=[\"noise\"]",
            "networks.0.label=twin",
        ],
    ] {
        let experiment = set(&sets).unwrap();
        let text = experiment.to_toml().unwrap();
        let again = Experiment::parse(&text, "config.toml", &Overrides::default()).unwrap();
        assert_eq!(again.config(), experiment.config());
        assert_eq!(again.to_toml().unwrap(), text);
        assert!(!text.contains("quick"), "{text}");
    }
}

#[test]
fn every_shipped_config_is_valid_in_full_and_quick() {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../configs");
    let (mut open, mut names) = (vec![root], std::collections::BTreeSet::new());
    while let Some(at) = open.pop() {
        for entry in std::fs::read_dir(at).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                open.push(path);
                continue;
            }
            if path.extension().is_none_or(|e| e != "toml") {
                continue;
            }
            for quick in [false, true] {
                let overrides = Overrides { quick, ..Overrides::default() };
                let experiment = Experiment::load(&path, &overrides).unwrap_or_else(|e| panic!("{e}"));
                assert_eq!(experiment.config().name, path.file_stem().unwrap().to_str().unwrap());
            }
            let text = std::fs::read_to_string(&path).unwrap();
            assert!(text.contains("\n# Takes "), "{}: says no time", path.display());
            // Run folders go by the name alone.
            assert!(names.insert(path.file_stem().unwrap().to_owned()), "{} is there twice", path.display());
        }
    }
    assert!(names.len() >= 19, "{names:?}");
}

#[test]
fn a_published_score_may_have_no_spread() {
    let with = |accuracy: &str| {
        set(&[&format!("networks.0.published={{ table = \"paper 001, Table 6\", accuracy = {accuracy} }}")])
    };
    let published = with("[78.57]").unwrap().config().networks[0].published.clone().unwrap();
    assert_eq!(published.accuracy, [78.57]);
    for bad in ["[]", "[1.0, 2.0, 3.0]", "[101.0]", "[50.0, nan]"] {
        let error = with(bad).unwrap_err().to_string();
        assert!(error.contains("must be [mean, SD] or [mean] in %"), "{error}");
    }
}

#[test]
fn settings_that_belong_elsewhere_are_refused() {
    let refused = |value: &str, part: &str| {
        let error = set(&[value]).unwrap_err().to_string();
        assert!(error.contains(part), "{value}: {error}");
    };
    refused("encoding.signal.scale=imagenet", "belongs to encoding.image of three channels");
    refused("encoding.image={ kind = \"rows\", scale = \"imagenet\" }", "three channels");
    refused("encoding.image={ kind = \"rows\", red = true }", "does not apply to kind = \"rows\"");
    refused("encoding.baseline=0", "must be in 1..=1000000");
    refused("data.test_above=15", "works with data.path only");
    let overrides = Overrides {
        data: Some("my.npz".into()),
        set: vec!["data.test_above=15".into()],
        ..Overrides::default()
    };
    let error = Experiment::parse(BASE, "tiny.toml", &overrides).unwrap_err().to_string();
    assert!(error.contains("needs the name of an array in data.test"), "{error}");
}
