//! The registry: names, custom networks, and how a network is sized by data.

#![allow(clippy::unwrap_used, clippy::panic)]

use std::path::Path;

use serde_json::Value;
use taxel_graph::Network;
use taxel_zoo::{BuildError, Entry, Input, Registry, Settings, built_in, find, matlab};

fn entry(name: &str) -> Entry {
    let called = name.to_string();
    Entry::new(name, "own", "unpublished", [Input::flat()], move |settings| {
        let classes = settings.get("classes").and_then(|v| v.as_u64()).unwrap_or(2) as usize;
        let net = Network::new(&called);
        let x = net.input("signal", &[1, 4]).flatten().linear("fc", classes);
        Ok::<_, BuildError>(net.finish(&[("logits", x)])?)
    })
}

#[test]
fn a_network_is_registered_once() {
    let mut registry = Registry::empty();
    assert_eq!(
        registry.find("mlp").unwrap_err().to_string(),
        "no network is called `mlp`; none is registered"
    );
    registry.add(entry("mine")).unwrap();
    let refusal = registry.add(entry("mine")).unwrap_err().to_string();
    assert_eq!(refusal, "a network is called `mine` already; give the other one another name");
    assert_eq!(registry.entries().count(), 1);
    assert_eq!(registry.find("mine").unwrap().graph(&Settings::new()).unwrap().name(), "mine");
    let mut registry = Registry::built_in();
    assert!(registry.add(entry("mlp")).is_err());
    registry.add(entry("mine")).unwrap();
    assert_eq!(registry.clone().entries().count(), built_in().entries().count() + 1);
    assert!(find("mine").is_err(), "the built-in ones stay as they are");
}

/// Fixtures hold the shapes of a PyTorch twin's tensors, and only a network with a twin has one.
#[test]
fn every_network_has_a_twin_that_counts_as_many_values() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/fixtures");
    let json = |path: &Path| serde_json::from_slice::<Value>(&std::fs::read(path).unwrap()).unwrap();
    let paths = std::fs::read_dir(format!("{folder}/networks")).unwrap().map(|file| file.unwrap().path());
    let mut twins: Vec<Value> = paths.map(|path| json(&path)).collect();
    // Those with several outputs.
    twins.extend(json(format!("{folder}/outputs.json").as_ref()).as_array().unwrap().iter().cloned());
    for entry in built_in().entries() {
        let is_of_entry = |twin: &&Value| twin["network"] == entry.name.as_str();
        assert!(
            twins.iter().any(|twin| is_of_entry(&twin)),
            "{}: no fixture; add its twin to scripts/twin and run scripts/fixtures/network_twins.py {0}",
            entry.name
        );
        for twin in twins.iter().filter(is_of_entry) {
            let settings = twin["settings"].as_object().unwrap().clone();
            let count = |tensor: &Value| {
                tensor[1].as_array().unwrap().iter().map(|n| n.as_u64().unwrap()).product::<u64>()
            };
            let values: u64 = twin["tensors"].as_array().unwrap().iter().map(count).sum();
            let cost = entry.graph(&settings).unwrap().cost();
            assert_eq!(cost.parameters + cost.buffers, values, "{} {settings:?}", entry.name);
        }
    }
    let known = |twin: &Value| built_in().entries().any(|entry| twin["network"] == entry.name.as_str());
    assert!(twins.iter().all(known), "a fixture of a network that is not listed");
}

#[test]
fn an_unknown_name_meets_the_nearest() {
    for (name, hint) in [
        ("resnet8-lite1d", "did you mean `resnet8-lite-1d`?"),
        ("mpl", "did you mean `mlp`?"),
        ("MobileNet_V2", "did you mean `mobilenet-v2`?"),
        ("vgg6-lite", "did you mean `vgg6-lite-1d` or `vgg6-lite-2d`?"),
        ("tactnet5", "did you mean `tactnet4` or `tactnet6`?"),
    ] {
        assert_eq!(find(name).unwrap_err().to_string(), format!("no network is called `{name}`; {hint}"));
    }
    let far = find("transformer-of-mine-and-yours").unwrap_err().to_string();
    assert!(far.contains("; known: mlp, deep-mlp, layer-norm-mlp, lstm, "), "{far}");
}

#[test]
fn a_network_of_ones_own_says_what_is_wrong_with_it() {
    let entry = entry("mine");
    let settings = Settings::from_iter([("classes".to_string(), 0.into())]);
    let refusal = entry.graph(&settings).unwrap_err().to_string();
    assert_eq!(refusal, "mine: fc: must have at least one output");
    assert_eq!(entry.fit(3, |_| Some(vec![5, 50])).unwrap()["in_features"], 250);
    let refusal = entry.fit(3, |_| None).unwrap_err().to_string();
    assert_eq!(
        refusal,
        "mine reads `signal` with 1 axes; the experiment encodes no `signal` (encoding.signal)"
    );
}

/// Sisters share their settings, not their layers and not the papers' values.
#[test]
fn settings_leave_alone_what_sets_a_network_apart() {
    let classes = Settings::from_iter([("classes".to_string(), 7.into())]);
    for entry in built_in().entries() {
        let (published, seven) = (entry.graph(&Settings::new()).unwrap(), entry.graph(&classes).unwrap());
        assert_eq!((published.name(), seven.name()), (entry.name.as_str(), entry.name.as_str()));
        let kinds = |graph: &taxel_graph::Graph| {
            graph.nodes().iter().map(|n| (n.name.clone(), n.op.kind())).collect::<Vec<_>>()
        };
        assert_eq!(kinds(&published), kinds(&seven), "{}", entry.name);
    }
    // What is no setting cannot be set.
    for (name, key) in [("resnet50", "depth"), ("tactnet3d", "layers"), ("hybrid-vgg", "branches")] {
        let settings = Settings::from_iter([(key.to_string(), "Fifty".into())]);
        let refusal = find(name).unwrap().graph(&settings).unwrap_err().to_string();
        assert!(refusal.starts_with(&format!("{name}: unknown field `{key}`")), "{refusal}");
    }
}

/// A range is resolved to names, and a name also covers what lies below it: they must mean the same nodes.
#[test]
fn a_range_of_one_layer_covers_that_node_alone() {
    for entry in built_in().entries() {
        let graph = entry.graph(&Settings::new()).unwrap();
        for (number, node) in matlab::layers(&graph) {
            let Some(number) = number.filter(|_| !node.params.is_empty()) else { continue };
            let names = matlab::range(&graph, &format!("{number}:{number}")).unwrap();
            let covered = graph.covered(&names).unwrap();
            let covered: Vec<_> = graph.nodes().iter().zip(covered).filter(|(_, c)| *c).collect();
            assert_eq!(covered.len(), 1, "{}: {}", entry.name, node.name);
            assert_eq!(covered[0].0.name, node.name);
        }
    }
}

/// Half the channels everywhere but in the outputs; where a paper or a setting has that network too, it is the same one.
#[test]
fn every_network_has_a_width_and_residual_ones_a_depth() {
    let of = |name: &str, settings: &[(&str, Value)]| {
        let settings = settings.iter().map(|(key, value)| (key.to_string(), value.clone()));
        find(name).unwrap().graph(&Settings::from_iter(settings))
    };
    for entry in built_in().entries() {
        let whole = of(&entry.name, &[]).unwrap();
        for (width_mult, most) in [(0.5, 0.7), (0.25, 0.4), (0.0625, 0.2)] {
            let narrow = of(&entry.name, &[("width_mult", width_mult.into())]).unwrap();
            let outputs = |graph: &taxel_graph::Graph| {
                let shape = |(name, id): &(String, usize)| (name.clone(), graph.nodes()[*id].shape.clone());
                graph.outputs().iter().map(shape).collect::<Vec<_>>()
            };
            assert_eq!(outputs(&narrow), outputs(&whole), "{}", entry.name);
            let share = narrow.cost().macs as f64 / whole.cost().macs as f64;
            assert!(share < most, "{} × {width_mult}: {share:.2} of the MACs", entry.name);
            assert_eq!(of(&entry.name, &[("width_mult", 1.0.into())]).unwrap(), whole);
        }
    }
    let nodes = |graph: taxel_graph::Graph| graph.nodes().to_vec();
    let half = |name: &str, settings: &[(&str, Value)]| {
        nodes(of(name, &[settings, &[("width_mult", 0.5.into())]].concat()).unwrap())
    };
    // Gandarias et al. 2019b have TactNet3D with half its filters, and all of its hidden units.
    assert_eq!(half("tactnet3d", &[("hidden", 128.into())]), nodes(of("tactnet3d-4-8", &[]).unwrap()));
    assert_eq!(
        half("dilated-resnet-1d", &[]),
        nodes(of("dilated-resnet-1d", &[("width", 32.into())]).unwrap())
    );
    // torchvision rounds MobileNetV2's channels to eights and leaves the last layer: 1,968,680 parameters for 1000 classes.
    let classes = ("classes", Value::from(1000));
    let mobilenet = of("mobilenet-v2", &[classes.clone(), ("width_mult", 0.5.into())]).unwrap();
    assert_eq!(mobilenet.parameter_count(), 1_968_680);
    // torchvision's ResNet(BasicBlock, [2, 2, 2, 1]) has 6,968,872 parameters for 1000 classes.
    let resnet = of("resnet18", &[("classes", 1000.into()), ("without_blocks", 1.into())]).unwrap();
    assert_eq!(resnet.parameter_count(), 6_968_872);
    let blocks = |name: &str| of(name, &[]).unwrap().identity_blocks();
    let found =
        ["resnet8-lite-1d", "hybrid-resnet", "resnet50", "mobilenet-v2", "vgg16", "tactnet3d"].map(blocks);
    assert_eq!(found, [2, 4, 12, 10, 0, 0]);
    let params = |graph: taxel_graph::Graph| graph.params().cloned().collect::<Vec<_>>();
    assert_eq!(
        params(of("dilated-resnet-1d", &[("without_blocks", 1.into())]).unwrap()),
        params(of("dilated-resnet-1d", &[("blocks", 1.into())]).unwrap())
    );
    // TactNet4 is TactNet6 without its last two convolutions.
    let made = |graph: taxel_graph::Graph| {
        let one = |node: &taxel_graph::Node| (node.op.clone(), node.shape.clone(), node.params.clone());
        graph.nodes().iter().map(one).collect::<Vec<_>>()
    };
    let four = of("tactnet6", &[("without_layers", 2.into())]).unwrap();
    assert_eq!(made(four), made(of("tactnet4", &[]).unwrap()));
    // torchvision's AlexNet has 61,100,840 parameters for 1000 classes, classifier.4 4096 × 4096 weights and 4096 biases of them.
    let alexnet = of("alexnet", &[classes.clone(), ("without_layers", 1.into())]).unwrap();
    assert_eq!(alexnet.parameter_count(), 61_100_840 - 4096 * 4097);
    let layers = |name: &str| of(name, &[]).unwrap().plain_layers();
    let found = ["vgg6-lite-1d", "hybrid-vgg", "tactnet4", "vgg16", "tactnet3d", "mlp", "lstm"].map(layers);
    assert_eq!(found, [4, 9, 2, 14, 2, 0, 0]);
    assert_eq!(["densenet6-lite-1d", "densenet201"].map(blocks), [2, 98]);
    let refusal = of("resnet8-lite-1d", &[("without_blocks", (-1).into())]).unwrap_err().to_string();
    assert_eq!(refusal, "resnet8-lite-1d: without_blocks = -1: must be a whole number");
    let refusal = of("tactnet6", &[("width_mult", "half".into())]).unwrap_err().to_string();
    assert_eq!(refusal, "tactnet6: width_mult = \"half\": must be a number");
    let refusal = of("tactnet6", &[("width_mult", 0.into())]).unwrap_err().to_string();
    assert_eq!(refusal, "tactnet6: width_mult = 0: must be above 0 and at most 4");
}
