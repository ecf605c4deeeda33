//! Reading configs: defaults, merging, overrides, paths, round trips.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod base;

use base::{BASE, parse, parse_with, quick, set};
use taxel_learn::encoding::{GramianSettings, Image, Range};
use taxel_learn::{Decay, Optimizer, Protocol, Schedule};
use taxel_trainer::{Experiment, Origin, Overrides};
use taxel_zoo::Registry;

/// The gramian field of a config.
fn field(experiment: &Experiment) -> GramianSettings {
    match experiment.config().encoding.image {
        Some(Image::Gadf(field) | Image::Gasf(field)) => field,
        ref other => panic!("{other:?}"),
    }
}

#[test]
fn defaults_are_the_papers_recipe() {
    let experiment = parse(BASE).unwrap();
    let config = experiment.config();
    let train = &config.networks[0].train;
    assert_eq!((train.epochs, train.batch_size), (7, 64));
    let sgdm = |lr| Optimizer::Sgdm { lr, momentum: 0.9, weight_decay: 0.0, decay: Decay::All };
    assert_eq!(train.optimizer, sgdm(0.01));
    assert_eq!(train.schedule.rate(0.01, 6, 7), 0.01);
    let recipe = &config.networks[1].train;
    assert_eq!((recipe.epochs, recipe.batch_size), (7, 8));
    assert_eq!(recipe.optimizer, sgdm(1e-4));
    let field = field(&experiment);
    assert_eq!((field.size, field.range), (50, Range::PerSample));
    assert_eq!(config.protocol, Protocol::k_fold(5));
    let Origin::Scene(scene) = &config.data.origin else { panic!("a scene") };
    assert_eq!((scene.scene.as_str(), scene.samples), ("fingertip", 60));
}

#[test]
fn options_of_a_command_line_replace_those_of_a_config() {
    use taxel_data::{Limits, ReadOptions, TableForm, TableOptions};
    let text = r#"
        name = "tiny"
        networks = []
        [data]
        path = "a.csv"
        table = { form = "long", recording = "grasp" }
        limits = { max-values = 10 }
    "#;
    let options = ReadOptions {
        table: TableOptions { form: Some(TableForm::Wide), ..TableOptions::default() },
        limits: Limits { max_values: 20, ..Limits::default() },
        ..ReadOptions::default()
    };
    let sets = taxel_trainer::settings(&options);
    let read = parse_with(text, &Overrides { set: sets, ..Overrides::default() }).unwrap();
    let Origin::Recordings(recordings) = &read.config().data.origin else { panic!("recordings") };
    assert_eq!(recordings.options, options);
}

/// One optimiser, schedule or protocol takes nothing from another kind but what all optimisers have.
#[test]
fn a_table_of_another_kind_replaces_the_one_below() {
    let with = |train: &str, lr: &str| {
        let text = BASE.replace("epochs = 7", train).replace("lr = 1e-4", lr);
        parse(&text).unwrap_or_else(|e| panic!("{e}")).config().networks[1].train.clone()
    };
    let adam = "optimizer = { name = \"adam\", lr = 0.5, weight_decay = 0.25, betas = [0.5, 0.6] }";
    let moments = |optimizer: Optimizer| match optimizer {
        Optimizer::Adam(adam) | Optimizer::Adamw(adam) => (adam.lr, adam.weight_decay, adam.betas),
        other => panic!("{other:?}"),
    };
    assert_eq!(moments(with(adam, "lr = 1e-4").optimizer), (1e-4, 0.25, [0.5, 0.6]));
    assert_eq!(moments(with(adam, "name = \"adamw\"").optimizer), (0.5, 0.25, [0.9, 0.999]));
    let sgdm = Optimizer::Sgdm { lr: 0.5, momentum: 0.9, weight_decay: 0.25, decay: Decay::All };
    assert_eq!(with(adam, "name = \"sgdm\"").optimizer, sgdm);
    let steps = "schedule = { kind = \"steps\", at = [0.5], factor = 0.5 }";
    let text =
        BASE.replace("epochs = 7", steps).replace("batch_size = 8", "schedule = { kind = \"cosine\" }");
    assert_eq!(parse(&text).unwrap().config().networks[1].train.schedule, Schedule::Cosine { floor: 0.0 });
    for (kind, expected) in [
        ("official", "Official { split: Stratified, repetitions: 1 }"),
        ("chronological", "Chronological { test: 0.2, repetitions: 1 }"),
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
fn a_second_copy_of_a_network_needs_a_label() {
    let text = BASE.replace("\"vgg6-lite-2d\"", "\"mlp\"\nlabel = \"mlp-slow\"");
    assert_eq!(parse(&text).unwrap().config().networks[1].label, "mlp-slow");
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
        "published = { table = \"Kaewrakmuk and Srinonchat 2026, Table 5\", accuracy = [83.13] }",
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

#[test]
fn a_length_rule_is_read_and_stored() {
    let set = vec!["data.length={ kind = \"pad\", to = 300, value = \"edge\" }".into()];
    let overrides = Overrides { data: Some("my.npz".into()), set, ..Overrides::default() };
    let experiment = parse_with(BASE, &overrides).unwrap();
    let rule = |experiment: &Experiment| match &experiment.config().data.origin {
        Origin::Recordings(recordings) => recordings.options.length,
        Origin::Scene(_) => None,
    };
    assert_eq!(rule(&experiment), Some("pad:300,edge".parse().unwrap()));
    assert_eq!(rule(&parse(&experiment.to_toml()).unwrap()), rule(&experiment));
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
    // However the folder is spelled, the run is the same.
    let spelled = load(&elsewhere.join("../../tiny.toml"));
    assert_eq!(spelled.to_toml(), load(&file).to_toml());
    // A path of the command line does not move with the config.
    let overrides = Overrides { data: Some("mine.npz".into()), ..Overrides::default() };
    let experiment = Experiment::load(&file, &overrides, &Registry::built_in()).unwrap();
    assert_eq!(experiment.data_path().unwrap(), Some(std::env::current_dir().unwrap().join("mine.npz")));
}

#[test]
fn meshes_start_at_the_configs_folder_and_may_hold_a_variable() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("tiny.toml");
    let load = |meshes: &str| {
        let scene = format!("scene = \"imprint\"\nsamples = 60\nset.meshes = \"{meshes}\"");
        std::fs::write(&file, BASE.replace("scene = \"fingertip\"\nsamples = 60", &scene)).unwrap();
        Experiment::load(&file, &Overrides::default(), &Registry::built_in()).unwrap()
    };
    let folder = dir.path().canonicalize().unwrap();
    let experiment = load("my/meshes");
    assert!(
        experiment.to_toml().contains(&format!("meshes = {:?}", folder.join("my/meshes"))),
        "{}",
        experiment.to_toml()
    );
    let error = experiment.dataset().unwrap_err().to_string();
    assert!(error.contains(&folder.join("my/meshes").display().to_string()), "{error}");
    let variable = load("${CARGO_MANIFEST_DIR}/none");
    assert!(variable.to_toml().contains("meshes = \"${CARGO_MANIFEST_DIR}/none\""));
    let error = variable.dataset().unwrap_err().to_string();
    assert!(error.contains(&format!("{}/none", env!("CARGO_MANIFEST_DIR"))), "{error}");
    let unset = load("${TAXEL_NO_SUCH}/none").dataset().unwrap_err().to_string();
    assert!(unset.contains("data.set.meshes = ") && unset.contains("TAXEL_NO_SUCH is not set"), "{unset}");
}

#[test]
fn a_resolved_config_reads_back_as_itself() {
    let full = "encoding.image={ kind = \"gadf\", range = { low = 0.1, high = 1023 }, constant = \"zero\" }";
    let published = "networks.0.published={ table = \"Kaewrakmuk and Srinonchat 2026, Table 5\", accuracy = [83.13, 2.39] }";
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
        set(&[&format!(
            "networks.0.published={{ table = \"Rouhafzay et al. 2021, Table 6\", accuracy = {accuracy} }}"
        )])
    };
    let published = with("[78.57]").unwrap().config().networks[0].published.clone().unwrap();
    assert_eq!(published.accuracy, [78.57]);
    for bad in ["[]", "[1.0, 2.0, 3.0]", "[101.0]", "[50.0, nan]"] {
        let error = with(bad).unwrap_err().to_string();
        assert!(error.contains("must be [mean, SD] or [mean] in %"), "{error}");
    }
}
