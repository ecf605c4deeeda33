//! Parameters, batch-norm statistics and MACs of every network, and what the papers print of them.

#![allow(clippy::unwrap_used, clippy::panic)]

mod published;

use published::{
    AGREEMENT, COMPRESSION, Convention, TABLE_1, TABLE_5, graph, matlab_blocks, ratios, table_1_shape,
};
use taxel_graph::NetworkCounts;
use taxel_zoo::{Settings, built_in, find, matlab};

/// Every listed network's own counts, which stand beside it in its file.
#[test]
fn counts_are_those_that_the_file_states() {
    for entry in built_in().entries() {
        let cost = graph(&entry.name).cost();
        let counted =
            NetworkCounts { parameters: cost.parameters, statistics: cost.buffers, macs: cost.macs };
        assert_eq!(Some(counted), entry.counts, "{}", entry.name);
    }
}

/// Sizes of other papers than the one whose values are the default, and options.
#[test]
fn counts_of_other_sizes() {
    let fingers = "in_channels=2 height=23 width=300 classes=20";
    for (name, settings, parameters, macs) in [
        ("vgg16", "classes=6", 134_285_126, None),
        ("resnet18", fingers, 11_183_636, Some(301_001_728)),
        ("mobilenet-v2", fingers, 2_249_204, Some(52_487_552)),
        // torchvision's, with its own 1000 classes.
        ("mobilenet-v2", "classes=1000", 3_504_872, None),
        ("resnet50", "classes=1000", 25_557_032, None),
        ("shufflenet-v2", "in_channels=3 height=224 width=224 classes=1000", 2_278_604, None),
        ("mnasnet1-0", "in_channels=3 height=224 width=224 classes=1000", 4_383_312, None),
        ("densenet201", "classes=1000", 20_013_928, None),
        ("alexnet", "classes=1000", 61_100_840, None),
        ("googlenet", "classes=1000", 6_624_904, None),
        ("googlenet", "classes=1000 aux=true", 13_004_888, None),
        // The question of costs that a pool of 2 in place of none raises.
        ("tactnet3d", "pool=2", 48_041, Some(7_276_096)),
        ("tactnet3d-51", "pool=2", 695_912, Some(260_154_880)),
    ] {
        let settings = settings.split(' ').map(|pair| pair.split_once('=').unwrap());
        let settings = settings.map(|(k, v)| (k.to_string(), serde_json::from_str(v).unwrap())).collect();
        let cost = find(name).unwrap().graph(&settings).unwrap().cost();
        assert_eq!(cost.parameters, parameters, "{name} {settings:?}");
        assert_eq!(cost.macs, macs.unwrap_or(cost.macs), "{name} {settings:?}");
    }
}

#[test]
fn paper_000_table_5_sizes_and_gflops() {
    for row in &TABLE_5 {
        let (ours, agrees) = row.size();
        assert!(agrees, "{}: {ours} MiB, printed {}", row.network, row.megabytes);
        if let Some((ours, agrees)) = row.operations() {
            assert!(agrees, "{}: {ours} GFLOPs, {:?}, printed {}", row.network, row.convention, row.gflops);
        }
    }
    let unexplained: Vec<&str> =
        TABLE_5.iter().filter(|row| row.convention == Convention::None).map(|row| row.network).collect();
    assert_eq!(unexplained, ["resnet18", "densenet201", "tactresnet"]);
}

#[test]
fn rows_that_no_convention_explains_fit_no_image_size_either() {
    for row in TABLE_5.iter().filter(|row| row.convention == Convention::None) {
        let sizes = if row.network == "tactresnet" { 44..=60 } else { 200..=231 };
        for size in sizes {
            let settings: Settings =
                ["height", "width"].map(|key| (key.into(), size.into())).into_iter().collect();
            let graph = find(row.network).unwrap().graph(&settings).unwrap();
            for convention in [Convention::Mac, Convention::TwoMac, Convention::TwoMacBias] {
                let (ours, agrees) = row.counted(convention, &graph).unwrap();
                assert!(!agrees, "{} of {size}: {ours} is explained by {convention:?}", row.network);
            }
        }
    }
}

#[test]
fn paper_001_compression_ratio() {
    for (counted, ratio) in ratios() {
        assert!(AGREEMENT.contains(&ratio), "{counted}: {ratio}");
    }
    let [parameters, statistics, biases] = ratios().map(|(_, ratio)| format!("{ratio:.4}"));
    assert_eq!([parameters, statistics, biases], ["1.4249", "1.4276", "1.4290"]);
    assert!(AGREEMENT.contains(&(COMPRESSION[0] / COMPRESSION[1])));
}

#[test]
fn paper_001_layer_numbers() {
    let blocks = matlab_blocks();
    let range = |block: &str| blocks.iter().find(|b| b.0 == block).map(|b| (b.1, b.2)).unwrap();
    for (block, first, last) in [
        ("image", 1, 1),
        ("features.0", 2, 4),
        ("features.1", 5, 9),
        ("features.2", 10, 17),
        ("features.3", 18, 26),
        ("features.16", 131, 139),
        ("features.17", 140, 147),
        ("features.18", 148, 150),
        ("global average pool", 151, 151),
        ("classifier.1", 152, 152),
    ] {
        assert_eq!(range(block), (first, last), "{block}");
    }
    let graph = graph("mobilenet-v2");
    let named = |number| matlab::layers(&graph).find(|l| l.0 == Some(number)).unwrap().1;
    assert_eq!((named(17).name.as_str(), &named(17).shape[..]), ("features.2.conv.3", &[24, 56, 56][..]));
    assert_eq!(named(139).op.kind(), "add");
}

#[test]
fn paper_004_table_1_shapes() {
    let graph = graph("multiscale-cnn");
    for (layer, printed, node) in TABLE_1 {
        assert_eq!(table_1_shape(&graph, node).as_deref(), Some(printed), "{layer}");
    }
    let fc1 = graph.params().find(|p| p.name == "fc1.weight").unwrap();
    assert_eq!(fc1.shape, [512, 4218]);
}

#[test]
fn the_page_is_what_the_graphs_say() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/costs.md");
    let page = std::fs::read_to_string(path).unwrap_or_default();
    assert!(page == published::page(), "run: cargo run -p taxel-zoo --example costs_page > docs/costs.md");
}

/// Floating point operations as the paper counts them: 2·MAC, and in an LSTM both biases per gate and step.
#[test]
fn an_lstm_adds_two_biases_per_gate_and_step() {
    let cost = find("lstm").unwrap().graph(&Settings::new()).unwrap().cost();
    assert_eq!(cost.flops, 2 * 3_405_184 + 50 * 2 * 512 + 3);
}

#[test]
fn names_are_those_of_the_checkpoints() {
    let graph = find("hybrid-resvgg").unwrap().graph(&Settings::new()).unwrap();
    let names: Vec<&str> = graph.params().map(|p| p.name.as_str()).collect();
    for name in ["temporal.downsample.shortcut.bn.running_var", "spatial.convs.4.conv.weight", "fuse.bias"] {
        assert!(names.contains(&name), "{name}");
    }
}

#[test]
fn too_small_inputs_and_too_few_classes_are_refused_by_name() {
    let refuse = |name: &str, key: &str, value: u64| {
        let settings = Settings::from_iter([(key.to_string(), value.into())]);
        find(name).unwrap().graph(&settings).unwrap_err().to_string()
    };
    assert_eq!(refuse("vgg6-lite-2d", "classes", 0), "vgg6-lite-2d: classes = 0: must be in 1..=65536");
    assert_eq!(refuse("lstm", "hidden", 0), "lstm: hidden = 0: must be in 1..=65536");
    assert_eq!(refuse("tactresnet", "height", 20), "tactresnet: height = 20: must be in 21..=65536");
    assert_eq!(refuse("mlp", "in_features", 0), "mlp: in_features = 0: must be in 1..=16777216");
    assert!(
        refuse("densenet6-lite-1d", "length", 1).contains("kernel 2 along length"),
        "{}",
        refuse("densenet6-lite-1d", "length", 1)
    );
}
