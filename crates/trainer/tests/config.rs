//! Reading configs: messages with places, overrides, round trips.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use taxel_learn::encoding::{Field, Image, Range};
use taxel_learn::{Optimizer, Protocol, Schedule};
use taxel_trainer::{Error, Experiment, Origin, Overrides};
use taxel_zoo::Registry;

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

fn parse_with(text: &str, overrides: &Overrides) -> Result<Experiment, Error> {
    Experiment::parse(text, "tiny.toml", overrides, &Registry::built_in())
}

fn parse(text: &str) -> Result<Experiment, Error> {
    parse_with(text, &Overrides::default())
}

fn set(sets: &[&str]) -> Result<Experiment, Error> {
    let set = sets.iter().map(ToString::to_string).collect();
    parse_with(BASE, &Overrides { set, ..Overrides::default() })
}

fn quick() -> Overrides {
    Overrides { quick: true, ..Overrides::default() }
}

/// The gramian field of a config.
fn field(experiment: &Experiment) -> Field {
    match experiment.config().encoding.image {
        Some(Image::Gadf(field) | Image::Gasf(field)) => field,
        ref other => panic!("{other:?}"),
    }
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
    let train = &config.networks[0].train;
    assert_eq!((train.epochs, train.batch_size), (7, 64));
    let sgdm = |lr| Optimizer::Sgdm { lr, momentum: 0.9, weight_decay: 0.0 };
    assert_eq!(train.optimizer, sgdm(0.01));
    assert_eq!(train.schedule.rate(0.01, 6, 7), 0.01);
    let own = &config.networks[1].train;
    assert_eq!((own.epochs, own.batch_size), (7, 8));
    assert_eq!(own.optimizer, sgdm(1e-4));
    let field = field(&experiment);
    assert_eq!((field.size, field.range), (50, Range::PerSample));
    assert_eq!(config.protocol, Protocol::k_fold(5));
    let Origin::Scene(scene) = &config.data.origin else { panic!("a scene") };
    assert_eq!((scene.scene.as_str(), scene.samples), ("fingertip", 60));
}

/// One optimiser, schedule or protocol takes nothing from another kind but what all optimisers have.
#[test]
fn a_table_of_another_kind_replaces_the_one_below() {
    let with = |train: &str, own: &str| {
        let text = BASE.replace("epochs = 7", train).replace("lr = 1e-4", own);
        parse(&text).unwrap_or_else(|e| panic!("{e}")).config().networks[1].train.clone()
    };
    let adam = "optimizer = { name = \"adam\", lr = 0.5, weight_decay = 0.25, betas = [0.5, 0.6] }";
    let moments = |optimizer: Optimizer| match optimizer {
        Optimizer::Adam(own) | Optimizer::Adamw(own) => (own.lr, own.weight_decay, own.betas),
        other => panic!("{other:?}"),
    };
    assert_eq!(moments(with(adam, "lr = 1e-4").optimizer), (1e-4, 0.25, [0.5, 0.6]));
    assert_eq!(moments(with(adam, "name = \"adamw\"").optimizer), (0.5, 0.25, [0.9, 0.999]));
    let sgdm = Optimizer::Sgdm { lr: 0.5, momentum: 0.9, weight_decay: 0.25 };
    assert_eq!(with(adam, "name = \"sgdm\"").optimizer, sgdm);
    let steps = "schedule = { kind = \"steps\", at = [0.5], factor = 0.5 }";
    let own = BASE.replace("epochs = 7", steps).replace("batch_size = 8", "schedule = { kind = \"cosine\" }");
    assert_eq!(parse(&own).unwrap().config().networks[1].train.schedule, Schedule::Cosine { floor: 0.0 });
    for (kind, expected) in [
        ("official", "Official { split: Stratified, repetitions: 1 }"),
        ("leave-group-out", "LeaveGroupOut { split: Stratified, repetitions: 1 }"),
        ("random-splits", "RandomSplits { split: Stratified, repetitions: 1, test: 0.2, validation: 0.0 }"),
        (
            "few-samples",
            "FewSamples { split: Stratified, repetitions: 1, test: 0.2, per_class: [1, 2, 5, 10, 20] }",
        ),
        ("k-fold", "KFold { folds: 5, split: Stratified, repetitions: 1 }"),
    ] {
        let text = BASE.replace("[train]", &format!("[protocol]\nkind = \"{kind}\"\n\n[train]"));
        assert_eq!(format!("{:?}", parse(&text).unwrap().config().protocol), expected);
    }
    let grouped = BASE.replace("[train]", "[protocol]\nsplit = \"group\"\n\n[train]");
    assert_eq!(parse(&grouped).unwrap().config().protocol, Protocol::group_k_fold(5));
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
    let text = BASE.replace("data.samples = 12", "data.sample = 12");
    let text = parse_with(&text, &quick()).unwrap_err().to_string();
    assert!(text.starts_with("tiny.toml:22:6: unknown field `sample`, expected one of `scene`"), "{text}");
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
        ("epochs = 7", "schedule = { kind = \"steps\" }", "tiny.toml:11:12: missing field `at`\n  11 | "),
        (
            "epochs = 7",
            "schedule = { kind = \"constant\", factor = 0.1 }",
            "tiny.toml:11:33: unknown field `factor`, there are no fields\n  11 | schedule",
        ),
        ("lr = 1e-4", "lr = -1.0", "tiny.toml:19: networks.1.train.optimizer.lr = -1: "),
        ("samples = 60", "samples = 0", "tiny.toml:5: data.samples = 0: "),
        ("samples = 60", "full_scale = inf", "tiny.toml:5: data.full_scale = inf: "),
        (
            "samples = 60",
            "channels = [0]",
            "tiny.toml:5:1: unknown field `channels`, expected one of `scene`, `samples`, `set`, `without`, \
             `full_scale`, `layout`, `rate`, `attributes`, `classes`, `look_alikes`\n  5 | channels = [0]",
        ),
        (
            "samples = 60",
            "path = \"x.npz\"",
            "tiny.toml:5:8: give either scene or path, not both\n  5 | path = \"x.npz\"",
        ),
        ("\"fingertip\"", "\"fist\"", "tiny.toml:4: data.scene = \"fist\": no scene has this name"),
        ("kind = \"gadf\"", "kind = \"gadf\", size = 1", "tiny.toml:8: encoding.image.size = 1: "),
        (
            "kind = \"gadf\"",
            "kind = \"raw\", size = 9",
            "tiny.toml:8:25: unknown field `size`, expected one of `scale`, `resize`, `red`\n  8 | image = ",
        ),
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
        (
            "hidden = 16",
            "hiden = 16",
            "tiny.toml:15: networks.0.set = { hiden = 16 }: mlp: unknown field `hiden`",
        ),
        (
            "samples = 60",
            "set = { shore = 1 }",
            "tiny.toml:5: data.set = { shore = 1 }: settings of scene fingertip: invalid type: integer `1`, expected \
             a sequence in `shore`",
        ),
        (
            "samples = 60",
            "attributes = [\"a\", 3]",
            "tiny.toml:5:20: invalid type: integer `3`, expected a string\n  5 | attributes",
        ),
        (
            "epochs = 7",
            "optimizer = \"adam\"",
            "tiny.toml:11:13: invalid type: string \"adam\", expected a table\n  11 | optimizer = \"adam\"",
        ),
        (
            "epochs = 7",
            "optimizer = { name = \"adam\", momentum = 0.9 }",
            "tiny.toml:11:30: unknown field `momentum`, expected one of `lr`, `weight_decay`, `betas`, `eps`\n  11 | ",
        ),
        (
            "epochs = 7",
            "optimizer = { name = \"adam\", betas = [0.9] }",
            "tiny.toml:11:38: invalid length 1, expected an array of length 2\n  11 | optimizer",
        ),
        (
            "lr = 1e-4",
            "name = \"adam\", momentum = 0.9",
            "tiny.toml:19:56: unknown field `momentum`, expected one of `lr`, `weight_decay`, `betas`, `eps`\n  19 | ",
        ),
        (
            "epochs = 7",
            "[protocol]\nkind = \"official\"\nfolds = 3",
            "tiny.toml:13:1: unknown field `folds`, expected `split` or `repetitions`\n  13 | folds = 3",
        ),
        ("epochs = 7", "[protocol]\nfolds = 1", "tiny.toml:12: protocol.folds = 1: must be in 2..=1000"),
        (
            "epochs = 7",
            "[choose]\ngrid = { \"optimizer.rate\" = [0.1] }",
            "tiny.toml:12: choose.grid.optimizer.rate = 0.1: unknown field `rate`, expected one of `lr`",
        ),
        (
            "epochs = 7",
            "[choose]\ngrid = { \"optimizer.lr\" = [0.1, -1] }",
            "tiny.toml:12: choose.grid.optimizer.lr = -1: must be positive",
        ),
        ("epochs = 7", "[choose]\ngrid = {}", "tiny.toml:12: choose.grid = {}: name what is chosen"),
        (
            "name = \"tiny\"",
            "name = \"tiny\"\nbaselines = [\n  \"majority\",\n  { name = \"k-nn\", k = 0.5 },\n]",
            "tiny.toml:4:24: invalid type: floating point `0.5`, expected usize\n  4 |   { name = \"k-nn\", k = 0.5 },",
        ),
        ("name = \"mlp\"\n", "", "tiny.toml:13:1: missing field `name`\n  13 | [[networks]]"),
        ("name = \"tiny\"\n", "", "tiny.toml: missing field `name`"),
        ("hidden = 16", "classes = 16", "tiny.toml:15: networks.0.set.classes = 16: comes from the data"),
        ("\"vgg6-lite-2d\"", "\"mlp\"", "tiny.toml:17: networks.1.label = \"mlp\": two networks"),
    ];
    for (from, to, expected) in cases {
        let text = message(from, to);
        assert!(text.starts_with(expected), "{to}\n  got  {text}\n  want {expected}");
    }
}

/// What a network takes over from `[train]` is wrong where `[train]` says it.
#[test]
fn a_value_that_a_network_takes_over_is_named_where_it_was_written() {
    let smooth = |train: &str, own: &str| {
        let text = BASE.replace("epochs = 7", train).replace("batch_size = 8", own);
        parse(&text).unwrap_err().to_string()
    };
    let text = smooth("label_smoothing = 0.1", "loss = \"mean-squared-error\"");
    let want = "tiny.toml:11: networks.1.train.label_smoothing = 0.1: works with loss = ";
    assert!(text.starts_with(want), "{text}");
    let text = smooth("loss = \"mean-squared-error\"", "label_smoothing = 0.1");
    assert!(text.starts_with("tiny.toml:19: networks.1.train.label_smoothing = 0.1: works with"), "{text}");
    let text = smooth("optimizer = { betas = [0.5, 0.6] }", "epochs = 1");
    assert!(
        text.starts_with("tiny.toml:11:15: unknown field `betas`, expected one of `lr`, `momentum`"),
        "{text}"
    );
    // The network's own kind, with a setting of its own that this kind does not have.
    let text = smooth("optimizer = { name = \"adam\", betas = [0.5, 0.6] }", "loss = \"entropy\"");
    assert!(text.starts_with("tiny.toml:19:18: unknown variant `entropy`"), "{text}");
}

#[test]
fn a_second_copy_of_a_network_needs_a_label() {
    let text = BASE.replace("\"vgg6-lite-2d\"", "\"mlp\"\nlabel = \"mlp-slow\"");
    assert_eq!(parse(&text).unwrap().config().networks[1].label, "mlp-slow");
}

#[test]
fn an_unset_variable_is_named_with_the_line_that_uses_it() {
    let path = "path = \"${TAXEL_NO_SUCH_VARIABLE}/set\"";
    let text = BASE.replace("scene = \"fingertip\"\nsamples = 60", path).replace("data.samples = 12\n", "");
    let error = parse(&text).unwrap().dataset().unwrap_err().to_string();
    assert!(error.starts_with("tiny.toml:4: data.path = "), "{error}");
    assert!(error.contains("environment variable TAXEL_NO_SUCH_VARIABLE is not set"), "{error}");
    assert!(error.contains("--data PATH"), "{error}");
    let text = text.replace("TAXEL_NO_SUCH_VARIABLE", "CARGO_MANIFEST_DIR");
    let path = parse(&text).unwrap().data_path().unwrap().unwrap();
    assert_eq!(path, std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("set"));
}

#[test]
fn quick_values_replace_full_ones() {
    let experiment = parse_with(BASE, &quick()).unwrap();
    let config = experiment.config();
    let Origin::Scene(scene) = &config.data.origin else { panic!("a scene") };
    assert_eq!((scene.samples, config.train.epochs), (12, 2));
    assert_eq!(config.train.schedule.rate(1.0, 1, 2), 0.1);
    assert!(!experiment.to_toml().contains("quick"));
    assert_ne!(experiment.default_out(), parse(BASE).unwrap().default_out());
    let without = BASE.split("[quick]").next().unwrap();
    let error = parse_with(without, &quick()).unwrap_err().to_string();
    assert_eq!(error, "tiny.toml: has no [quick] table; leave --quick out");

    // A grid's keys are dotted themselves: it is replaced whole.
    let chosen = BASE.replace(
        "[quick]",
        "[choose]\ngrid = { \"optimizer.lr\" = [0.1, 0.01], \"batch_size\" = [8, 16] }\n\n[quick]\nchoose.grid = { \"optimizer.lr\" = [0.1] }",
    );
    let experiment = parse_with(&chosen, &quick()).unwrap();
    let grid = &experiment.config().choose.as_ref().unwrap().grid;
    assert_eq!(grid.keys().collect::<Vec<_>>(), ["optimizer.lr"]);
    assert_eq!(grid["optimizer.lr"].len(), 1);
}

#[test]
fn set_values_come_last() {
    let experiment = parse_with(BASE, &Overrides { set: vec!["train.epochs=3".into()], ..quick() }).unwrap();
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
    assert_eq!((config.name.as_str(), config.train.optimizer.lr()), ("other", 1e-3));
    assert_eq!(config.networks[1].train.epochs, 4);
    assert_eq!(field(&experiment).range, Range::Fixed { low: 0.0, high: 1023.0 });
    let Origin::Scene(scene) = &config.data.origin else { panic!("a scene") };
    assert_eq!(scene.without, ["noise"]);
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

/// A path of the command line starts at the working folder, and the experiment is another one.
#[test]
fn data_on_the_command_line_replaces_the_scene_and_what_was_said_of_it() {
    let text = BASE.replace("\n[data]", "title = \"presses\"\nexpect = \"90 %\"\n\n[data]").replace(
        "set = { hidden = 16 }",
        "published = { table = \"paper 000, Table 5\", accuracy = [83.13] }",
    );
    let before = parse(&text).unwrap();
    assert!(before.config().title.is_some() && before.config().networks[0].published.is_some());
    let overrides = Overrides { data: Some("sets/my glove.npz".into()), seed: Some(9), ..quick() };
    let experiment = parse_with(&text, &overrides).unwrap();
    let config = experiment.config();
    let Origin::Recordings(recordings) = &config.data.origin else { panic!("recordings") };
    let want = std::env::current_dir().unwrap().join("sets/my glove.npz");
    assert_eq!(recordings.path, want.to_str().unwrap());
    assert_eq!(experiment.data_path().unwrap(), Some(want));
    assert_eq!((config.seed, config.name.as_str()), (9, "my-glove"));
    assert_eq!((&config.title, &config.expect), (&None, &None));
    assert!(config.networks.iter().all(|network| network.published.is_none()));
    assert_eq!(experiment.default_out(), std::path::Path::new("runs/my-glove-quick"));
    let stored = experiment.to_toml();
    for word in ["published", "title", "expect", "scene", "samples", "fingertip"] {
        assert!(!stored.contains(word), "{word}: {stored}");
    }
    // A name given by hand is kept only if it is of these recordings: --data comes after --set.
    for (path, name) in
        [("a.b/Ω.npz", "-"), ("..npz", "data"), ("folder/", "folder"), (".hidden.npz", "hidden")]
    {
        let overrides = Overrides { data: Some(path.into()), ..Overrides::default() };
        assert_eq!(parse_with(BASE, &overrides).unwrap().config().name, name, "{path}");
    }
}

/// A path of the config starts at the config's folder, and is stored so that the run opens from anywhere.
#[test]
fn paths_of_a_config_start_at_its_folder() {
    let dir = tempfile::tempdir().unwrap();
    let text = BASE
        .replace("scene = \"fingertip\"\nsamples = 60", "path = \"sets/glove.npz\"")
        .replace("data.samples = 12\n", "")
        .replace("set = { hidden = 16 }", "weights = \"first.safetensors\"");
    let file = dir.path().join("tiny.toml");
    std::fs::write(&file, &text).unwrap();
    let load = |file: &std::path::Path| {
        Experiment::load(file, &Overrides::default(), &Registry::built_in()).unwrap()
    };
    let experiment = load(&file);
    let folder = std::path::absolute(dir.path()).unwrap();
    assert_eq!(experiment.data_path().unwrap(), Some(folder.join("sets/glove.npz")));
    assert_eq!(experiment.weights_path(0).unwrap(), Some(folder.join("first.safetensors")));
    let stored = experiment.to_toml();
    assert!(stored.contains(&format!("path = {:?}", folder.join("sets/glove.npz"))), "{stored}");
    // Read back from elsewhere, it means the same files.
    let elsewhere = dir.path().join("runs/tiny");
    std::fs::create_dir_all(&elsewhere).unwrap();
    std::fs::write(elsewhere.join("config.toml"), &stored).unwrap();
    let again = load(&elsewhere.join("config.toml"));
    assert_eq!(again.config(), experiment.config());
    assert_eq!(again.to_toml(), stored);
    // A variable says where its folder is, on every machine its own.
    std::fs::write(&file, text.replace("sets/glove.npz", "${CARGO_MANIFEST_DIR}/glove.npz")).unwrap();
    let variable = load(&file);
    assert!(variable.to_toml().contains("path = \"${CARGO_MANIFEST_DIR}/glove.npz\""));
    let want = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("glove.npz");
    assert_eq!(variable.data_path().unwrap(), Some(want));
    // A path of the command line does not move with the config.
    let overrides = Overrides { data: Some("mine.npz".into()), ..Overrides::default() };
    let own = Experiment::load(&file, &overrides, &Registry::built_in()).unwrap();
    assert_eq!(own.data_path().unwrap(), Some(std::env::current_dir().unwrap().join("mine.npz")));
}

/// What was called rivals once.
#[test]
fn rivals_are_called_baselines_now() {
    let list =
        BASE.replace("[encoding]", "[encoding]\n").replacen("\n[data]", "rivals = [\"k-nn\"]\n\n[data]", 1);
    let text = parse(&list).unwrap_err().to_string();
    assert!(
        text.starts_with("tiny.toml:2:1: unknown field `rivals`: it is called `baselines` now"),
        "{text}"
    );
    assert!(text.ends_with("\n  2 | rivals = [\"k-nn\"]"), "{text}");
    let tables = BASE.replace("[quick]", "[[rivals]]\nname = \"k-nn\"\n\n[quick]");
    let text = parse(&tables).unwrap_err().to_string();
    assert!(text.starts_with("tiny.toml:21:"), "{text}");
    assert!(text.contains("it is called `baselines` now") && text.ends_with("\n  21 | [[rivals]]"), "{text}");
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
        let text = experiment.to_toml();
        let again =
            Experiment::parse(&text, "config.toml", &Overrides::default(), &Registry::built_in()).unwrap();
        assert_eq!(again.config(), experiment.config());
        assert_eq!(again.to_toml(), text);
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
                let experiment = Experiment::load(&path, &overrides, &Registry::built_in());
                let experiment = experiment.unwrap_or_else(|e| panic!("{e}"));
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
        assert!(error.starts_with(&format!("--set {value}: ")) && error.contains(part), "{value}: {error}");
    };
    refused("encoding.signal.scale=imagenet", "belongs to encoding.image of three channels");
    refused("encoding.image={ kind = \"rows\", scale = \"imagenet\" }", "three channels");
    refused(
        "encoding.image={ kind = \"rows\", red = true }",
        "encoding.image.red: unknown field `red`, expected `scale`",
    );
    refused("encoding.baseline=0", "must be in 1..=1000000");
    refused("data.test_above=15", "unknown field `test_above`, expected one of `scene`, `samples`");
    let overrides = Overrides {
        data: Some("my.npz".into()),
        set: vec!["data.test_above=15".into()],
        ..Overrides::default()
    };
    let error = parse_with(BASE, &overrides).unwrap_err().to_string();
    assert!(error.contains("needs the name of an array in data.test"), "{error}");
}
