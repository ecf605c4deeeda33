//! Errors of configs: the place, the mistake, how to fix it.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod base;

use base::{BASE, parse, parse_with, quick, set};
use taxel_trainer::Overrides;

/// The message for `BASE` with `from` replaced by `to`.
fn message(from: &str, to: &str) -> String {
    assert!(BASE.contains(from), "{from}");
    parse(&BASE.replace(from, to)).unwrap_err().to_string()
}

#[test]
fn unknown_keys_and_wrong_types_name_file_line_and_column() {
    let text = message("epochs = 7", "epoch = 7");
    assert!(
        text.starts_with(
            "tiny.toml:11:1: unknown field `epoch`: did you mean `epochs`? expected one of `epochs`"
        ),
        "{text}"
    );
    assert!(text.ends_with("\n  11 | epoch = 7"), "{text}");
    let text = message("epochs = 7", "epochs = \"seven\"");
    assert!(text.starts_with("tiny.toml:11:10: invalid type: string \"seven\""), "{text}");
    let text = message("kind = \"gadf\"", "kind = \"gadf\", range = { low = 1, hihg = 2 }");
    assert!(text.starts_with("tiny.toml:8:"), "{text}");
    assert!(text.contains("unknown field `hihg`: did you mean `high`? expected `low` or `high`"), "{text}");
    let text = message("kind = \"gadf\"", "kind = \"gadf\", range = \"sample\"");
    assert!(text.starts_with("tiny.toml:8:") && text.contains("per-sample"), "{text}");
    let text = message("epochs = 7", "epochs = ");
    assert!(text.starts_with("tiny.toml:11:"), "{text}");
    // A mistake in [quick] must not wait for --quick's full run to be noticed there.
    let text = BASE.replace("data.samples = 12", "data.sample = 12");
    let text = parse_with(&text, &quick()).unwrap_err().to_string();
    assert!(
        text.starts_with(
            "tiny.toml:22:6: unknown field `sample`: did you mean `samples`? expected one of `scene`"
        ),
        "{text}"
    );
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
            "tiny.toml:5:1: unknown field `channels`: did you mean `classes`? expected one of `scene`, `samples`, `y`, `set`, \
             `without`, `full_scale`, `layout`, `rate`, `each_frame`, `attributes`, `classes`, `look_alikes`\n  5 | channels = [0]",
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
            "tiny.toml:8:25: unknown field `size`: did you mean `resize`? expected one of `scale`, `resize`, `red`\n  8 | image = ",
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
            "y = \"shore\"\nclasses = [\"shore-00\"]",
            "tiny.toml:6: data.classes = [..]: is for classes, and data.y learns true values of the scene",
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
            "tiny.toml:11:30: unknown field `momentum`, expected one of `lr`, `weight_decay`, `decay`, `betas`, `eps`\n  11 | ",
        ),
        (
            "epochs = 7",
            "optimizer = { name = \"adam\", betas = [0.9] }",
            "tiny.toml:11:38: invalid length 1, expected an array of length 2\n  11 | optimizer",
        ),
        (
            "lr = 1e-4",
            "name = \"adam\", momentum = 0.9",
            "tiny.toml:19:56: unknown field `momentum`, expected one of `lr`, `weight_decay`, `decay`, `betas`, `eps`\n  19 | ",
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
        (
            "name = \"mlp\"\n",
            "",
            "tiny.toml:13:1: needs `name`, a network of the zoo, or `onnx` or `file`, a network of your own\n  13 | [[",
        ),
        ("name = \"tiny\"\n", "", "tiny.toml: missing field `name`"),
        ("hidden = 16", "classes = 16", "tiny.toml:15: networks.0.set.classes = 16: comes from the data"),
        ("\"vgg6-lite-2d\"", "\"mlp\"", "tiny.toml:17: networks.1.label = \"mlp\": two networks"),
    ];
    for (from, to, expected) in cases {
        let text = message(from, to);
        assert!(text.starts_with(expected), "{to}\n  got  {text}\n  want {expected}");
    }
}

/// A value that a network takes over from `[train]` is refused at its place in `[train]`.
#[test]
fn a_value_that_a_network_takes_over_is_named_where_it_was_written() {
    let smooth = |train: &str, network: &str| {
        let text = BASE.replace("epochs = 7", train).replace("batch_size = 8", network);
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

/// The old name of the baselines.
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
fn an_experiment_without_networks_and_baselines_is_refused() {
    let text = set(&["networks=[]", "baselines=[]"]).unwrap_err().to_string();
    assert!(text.ends_with("networks = []: name at least one network or baseline"), "{text}");
    assert!(set(&["networks=[]"]).is_ok() && set(&["baselines=[]"]).is_ok());
}

#[test]
fn settings_that_belong_elsewhere_are_refused() {
    let refused = |value: &str, part: &str| {
        let error = set(&[value]).unwrap_err().to_string();
        assert!(error.starts_with(&format!("--set {value}: ")) && error.contains(part), "{value}: {error}");
    };
    refused("encoding.signal.scale=imagenet", "belongs to encoding.image of three channels");
    refused("encoding.signal.steps=9", "`steps` is no key of a signal of kind \"scaled\"");
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
    let ruled = |rule: &str| {
        let set = vec![format!("data.length={rule}")];
        let overrides = Overrides { data: Some("my.npz".into()), set, ..Overrides::default() };
        parse_with(BASE, &overrides).unwrap_err().to_string()
    };
    for (rule, part) in [
        ("{ kind = \"resample\", to = 1 }", "data.length.to = 1: is the number of readings, from 2"),
        ("{ kind = \"window\", to = 5, hop = 0 }", "data.length.hop = 0: is the number of readings from one"),
        ("{ kind = \"fold\", to = 5 }", "expected one of `resample`, `pad`, `crop`, `window`"),
        ("{ kind = \"crop\", to = 5, hop = 2 }", "unknown field `hop`, expected `to` or `from`"),
        ("{ kind = \"crop\" }", "missing field `to`"),
    ] {
        let error = ruled(rule);
        assert!(error.contains(part), "{rule}: {error}");
    }
}

/// A sweep's settings were written in its own file.
#[test]
fn settings_from_a_file_are_refused_by_its_name() {
    let overrides = Overrides {
        set: vec!["train.epoch=3".into()],
        place: Some("study.toml".into()),
        ..Overrides::default()
    };
    let error = parse_with(BASE, &overrides).unwrap_err().to_string();
    assert!(error.starts_with("study.toml train.epoch=3: ") && error.contains("unknown field"), "{error}");
}

#[test]
fn a_table_of_unknown_networks_names_the_nearest() {
    let tables = |names: &str| format!("{BASE}\n[[tables]]\ntitle = \"Table 2\"\nnetworks = [{names}]\n");
    let text = parse(&tables("\"majorty\"")).unwrap_err().to_string();
    assert!(text.contains("tables.0.networks.0 = \"majorty\": is no network or baseline"), "{text}");
    assert!(text.contains("majority"), "{text}");
    let text = parse(&tables("")).unwrap_err().to_string();
    assert!(text.contains("tables.0.networks = []: name the networks of the table"), "{text}");
    assert!(parse(&tables("\"majority\"")).is_ok());
}
