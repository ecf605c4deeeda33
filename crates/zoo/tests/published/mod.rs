//! The costs that the papers print, beside those of the graphs: `docs/costs.md`, and the rows that
//! `tests/costs.rs` holds.

use std::fmt::Write;

use taxel_graph::{Cost, Graph, Node, Op};
use taxel_zoo::{Settings, find, matlab};

/// How a paper seems to have counted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Convention {
    /// A multiply–accumulate is one operation.
    Mac,
    /// It is two.
    TwoMac,
    /// It is two, and a bias one.
    TwoMacBias,
    /// The last for the branch that reads images, the first for the branch that reads signals.
    Branches,
    /// None that was tried: shown, and held against nothing.
    None,
}

impl Convention {
    fn text(self) -> &'static str {
        match self {
            Convention::Mac => "1·MAC",
            Convention::TwoMac => "2·MAC",
            Convention::TwoMacBias => "2·MAC + bias",
            Convention::Branches => "2·MAC + bias of the 2D branch, 1·MAC of the 1D branch",
            Convention::None => "none",
        }
    }

    /// Operations of a sample in units of 1e9.
    fn giga(self, graph: &Graph) -> Option<f64> {
        let Cost { macs, flops, .. } = graph.cost();
        let operations = match self {
            Convention::Mac => macs,
            Convention::TwoMac => 2 * macs,
            Convention::TwoMacBias => flops,
            Convention::Branches => {
                let of = |node: &Node| {
                    let cost = node.cost();
                    if node.name.starts_with("temporal.") { cost.macs } else { cost.flops }
                };
                graph.nodes().iter().map(of).sum()
            }
            Convention::None => return None,
        };
        Some(operations as f64 / 1e9)
    }
}

/// A row of Kaewrakmuk and Srinonchat 2026, Table 5.
pub struct Row {
    pub network: &'static str,
    /// As printed, in "MB".
    pub megabytes: &'static str,
    /// As printed.
    pub gflops: &'static str,
    pub convention: Convention,
}

const fn row(
    network: &'static str,
    megabytes: &'static str,
    gflops: &'static str,
    convention: Convention,
) -> Row {
    Row { network, megabytes, gflops, convention }
}

/// Kaewrakmuk and Srinonchat 2026, Table 5: model size and GFLOPs.
pub const TABLE_5: [Row; 11] = [
    row("mlp", "0.12", "0.00006", Convention::TwoMac),
    row("lstm", "0.27", "0.0068", Convention::TwoMac),
    row("vgg16", "512.2", "30.9459", Convention::TwoMacBias),
    row("resnet18", "42.7", "1.7965", Convention::None),
    row("densenet201", "70", "3.5720", Convention::None),
    row("tactnet4", "0.04", "0.0060", Convention::TwoMacBias),
    row("tactnet6", "0.40", "0.0102", Convention::TwoMacBias),
    row("tactresnet", "2.9", "0.2398", Convention::None),
    row("resnet8-lite-1d", "0.06", "0.0002", Convention::Mac),
    row("vgg6-lite-2d", "0.39", "0.0392", Convention::TwoMacBias),
    row("hybrid-resvgg", "0.46", "0.0394", Convention::Branches),
];

impl Row {
    /// Megabytes of 2²⁰ bytes, parameters and batch-norm statistics in f32: computed, and whether the printed
    /// size is within 0.02 or 2 % of that.
    pub fn size(&self) -> (f64, bool) {
        let (ours, printed) = (mib(graph(self.network).cost()), number(self.megabytes));
        (ours, (ours - printed).abs() <= f64::max(0.02, 0.02 * printed))
    }

    /// GFLOPs in the row's convention, and whether they are the printed ones in all their digits.
    pub fn operations(&self) -> Option<(f64, bool)> {
        self.counted(self.convention, &graph(self.network))
    }

    /// The same in another convention and for another graph.
    pub fn counted(&self, convention: Convention, graph: &Graph) -> Option<(f64, bool)> {
        let ours = convention.giga(graph)?;
        let digits = self.gflops.split('.').nth(1).map_or(0, str::len) as i32;
        Some((ours, (ours - number(self.gflops)).abs() <= 0.5 * 10f64.powi(-digits) + 1e-12))
    }
}

/// Rouhafzay et al. 2021, section 7: kilobytes of two networks, and of the two-stream one in their place.
pub const COMPRESSION: [f64; 2] = [16_644.0, 11_652.0];
/// The ratio that counts as agreement: files are compressed, and hold what a network's tensors do not.
pub const AGREEMENT: std::ops::Range<f64> = 1.42..1.43;

/// How much smaller than two of mobilenet-v2 the two-stream network is, by what is counted.
pub fn ratios() -> [(&'static str, f64); 3] {
    let (single, split) = (graph("mobilenet-v2"), graph("mobilenet-v2-split"));
    let ratio = |count: &dyn Fn(&Graph) -> u64| 2.0 * count(&single) as f64 / count(&split) as f64;
    // MATLAB stores a bias of zero per filter where there is none.
    let biases = |graph: &Graph| {
        let filters = graph.nodes().iter().filter(|n| matches!(n.op, Op::Conv { bias: false, .. }));
        filters.map(|node| node.shape[0] as u64).sum::<u64>()
    };
    let stored = |graph: &Graph| graph.cost().parameters + graph.cost().buffers;
    [
        ("parameters", ratio(&|graph| graph.cost().parameters)),
        ("parameters and batch-norm statistics", ratio(&stored)),
        ("the same with MATLAB's zero biases", ratio(&|graph| stored(graph) + biases(graph))),
    ]
}

/// Zhang et al. 2022, Table 1: layer, what comes out (rows × columns × channels, or features), our node.
pub const TABLE_1: [(&str, &[usize], &str); 19] = [
    ("Input", &[23, 300, 2], "image"),
    ("Input max-pooling", &[11, 150, 2], "image/max_pool"),
    ("Conv1_1", &[23, 300, 1], "block1.single.conv"),
    ("Conv1_1 max-pooling", &[11, 150, 1], "block1.single.bn/max_pool"),
    ("Conv1_2", &[23, 300, 5], "block1.multi.conv"),
    ("Conv1_2 max-pooling", &[11, 150, 5], "block1.multi.bn/max_pool"),
    ("Cat_layer1", &[11, 150, 8], "block1.cat"),
    ("Conv2_1", &[11, 150, 1], "block2.single.conv"),
    ("Conv2_1 max-pooling", &[5, 75, 1], "block2.single.bn/max_pool"),
    ("Conv2_2", &[11, 150, 15], "block2.multi.conv"),
    ("Conv2_2 max-pooling", &[5, 75, 15], "block2.multi.bn/max_pool"),
    ("Cat_layer2", &[5, 75, 24], "block2.cat"),
    ("Conv3_1", &[5, 75, 1], "block3.single.conv"),
    ("Conv3_1 max-pooling", &[2, 37, 1], "block3.single.bn/max_pool"),
    ("Conv3_2", &[5, 75, 32], "block3.multi.conv"),
    ("Conv3_2 max-pooling", &[2, 37, 32], "block3.multi.bn/max_pool"),
    ("Cat_layer3", &[2, 37, 57], "block3.cat"),
    ("Fc1", &[512], "fc1"),
    ("Fc2", &[20], "fc2"),
];

/// The same shape in our node, if it is there.
pub fn table_1_shape(graph: &Graph, node: &str) -> Option<Vec<usize>> {
    let shape = &graph.nodes().iter().find(|n| n.name == node)?.shape;
    Some([&shape[1..], &shape[..1]].concat())
}

/// Rouhafzay et al. 2021, Table 6, and section 7: MATLAB's layer numbers of MobileNetV2, by torchvision's block.
pub fn matlab_blocks() -> Vec<(String, usize, usize)> {
    let graph = graph("mobilenet-v2");
    let mut blocks: Vec<(String, usize, usize)> = vec![];
    for (number, node) in matlab::layers(&graph) {
        let Some(number) = number else { continue };
        let here = match node.name.split(['.', '/']).nth(1) {
            _ if node.op == Op::GlobalAveragePool => "global average pool".into(),
            Some(part) if node.name.starts_with("features.") => format!("features.{part}"),
            _ => node.name.clone(),
        };
        match blocks.last_mut() {
            Some((block, _, last)) if *block == here => *last = number,
            _ => blocks.push((here, number, number)),
        }
    }
    blocks
}

pub fn graph(name: &str) -> Graph {
    find(name).unwrap().graph(&Settings::new()).unwrap()
}

fn number(printed: &str) -> f64 {
    printed.parse().unwrap()
}

fn mib(cost: Cost) -> f64 {
    cost.bytes() as f64 / f64::from(1 << 20)
}

fn grouped(number: u64) -> String {
    indicatif::HumanCount(number).to_string()
}

fn shape(sizes: &[usize]) -> String {
    sizes.iter().map(usize::to_string).collect::<Vec<_>>().join("×")
}

/// `docs/costs.md`.
pub fn page() -> String {
    let mut page = String::from(HEAD);
    table_5(&mut page);
    compression(&mut page);
    table_1(&mut page);
    layers(&mut page);
    page
}

const HEAD: &str = "\
<!-- Written by `cargo run -p taxel-zoo --example costs_page > docs/costs.md`; a test holds it. -->
# What the networks cost

What the papers print beside what the graphs say. All numbers are counted, for one sample in 32-bit floats; nothing is measured.
Tests hold the graphs against PyTorch twins. `taxel zoo` prints the costs of every network, `taxel cost MODEL` those of each layer.

- A MAC is one multiply–accumulate of a convolution, linear or recurrent layer. Batch norm, activations and pools are not counted.
- FLOPs are 2·MAC and one addition per bias and output value.
- MiB (2²⁰ bytes) are parameters and batch-norm statistics.
";

fn table_5(page: &mut String) {
    *page += "
## Kaewrakmuk and Srinonchat 2026, Table 5

*Published* beside computed. Sizes agree within 0.02 MB or 2 % if \"MB\" means 2²⁰ bytes of parameters and
batch-norm statistics. No single convention explains the GFLOPs: the last column names the one that gives the
printed digits. For \"none\", every convention misses, also with other image sizes near it (a test tries
them). Such a row is shown but not checked.

| network | *MB* | MiB | *GFLOPs* | 1·MAC | 2·MAC | 2·MAC + bias | explained by |
|---|---:|---:|---:|---:|---:|---:|---|
";
    for row in &TABLE_5 {
        let graph = graph(row.network);
        let giga = |convention: Convention| convention.giga(&graph).unwrap_or(f64::NAN);
        let _ = writeln!(
            page,
            "| `{}` | *{}* | {:.3} | *{}* | {:.6} | {:.6} | {:.6} | {} |",
            row.network,
            row.megabytes,
            row.size().0,
            row.gflops,
            giga(Convention::Mac),
            giga(Convention::TwoMac),
            giga(Convention::TwoMacBias),
            explained(row),
        );
    }
}

fn explained(row: &Row) -> String {
    match row.operations() {
        Some((ours, _)) if row.convention == Convention::Branches => {
            format!("{} = {ours:.6}", row.convention.text())
        }
        Some(_) => row.convention.text().into(),
        None => {
            let printed = number(row.gflops);
            let graph = graph(row.network);
            let gap =
                |convention: Convention| convention.giga(&graph).map(|ours| 100.0 * (ours / printed - 1.0));
            let tried = [Convention::Mac, Convention::TwoMacBias];
            let nearest = tried
                .into_iter()
                .filter_map(|c| Some((c, gap(c)?)))
                .min_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
            nearest.map_or("none".into(), |(c, gap)| format!("none; {} is {gap:+.1} %", c.text()))
        }
    }
}

fn compression(page: &mut String) {
    let [two, one] = COMPRESSION;
    let _ = write!(
        page,
        "
## Rouhafzay et al. 2021, section 7

Two of MobileNetV2 against the two-stream network, 6 classes. *Published: {} KB / {} KB = {:.4}*, of
compressed files; {} to {} is agreement.

| counted | ratio |
|---|---:|
",
        grouped(two as u64),
        grouped(one as u64),
        two / one,
        AGREEMENT.start,
        AGREEMENT.end,
    );
    for (counted, ratio) in ratios() {
        let _ = writeln!(page, "| {counted} | {ratio:.4} |");
    }
}

fn table_1(page: &mut String) {
    *page += "
## Zhang et al. 2022, Table 1

Rows × columns × channels of `multiscale-cnn`; every shape is the printed one.

| layer | *published* | node | computed |
|---|---|---|---|
";
    let graph = graph("multiscale-cnn");
    for (layer, printed, node) in TABLE_1 {
        let ours = table_1_shape(&graph, node).map_or("missing".into(), |sizes| shape(&sizes));
        let _ = writeln!(page, "| {layer} | *{}* | `{node}` | {ours} |", shape(printed));
    }
}

fn layers(page: &mut String) {
    *page += "
## Layer numbers of MobileNetV2

Rouhafzay et al. 2021 freeze ranges of MATLAB's 154 layers (Table 6). `mobilenet-v2` counts in the same way, without dropout: `18:139`
freezes everything between the first two blocks and the last. Layer 153 is MATLAB's softmax, 154 its output.

| block | layers |
|---|---:|
";
    for (block, first, last) in matlab_blocks() {
        let range = if first == last { first.to_string() } else { format!("{first}–{last}") };
        let _ = writeln!(page, "| `{block}` | {range} |");
    }
}
