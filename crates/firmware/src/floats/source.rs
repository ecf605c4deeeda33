//! Layers of floats as C: tables and descriptions.

use taxel_kernels::Rectifier;

use super::layer::{FloatConv, FloatDepthwise, FloatLinear, FloatWork, Fours, Lstm};
use crate::arena::{Arena, offset};
use crate::kernel::Kernel;
use crate::layer::{Layer, Row};
use crate::literals::{float, floats, numbers};

/// The C of a layer.
pub(crate) struct FloatSource {
    /// Kernels that it calls; the last one by the name `function`.
    pub kernels: Vec<Kernel>,
    pub function: &'static str,
    /// Its tables, and their bytes.
    pub tables: String,
    pub table_bytes: usize,
    /// The numbers of its description.
    pub fields: String,
}

impl FloatSource {
    /// Writes layer `number`.
    pub fn new(number: usize, layer: &Layer, work: &FloatWork, arena: &Arena) -> Self {
        let mut tables = Tables { number, text: String::new(), bytes: 0 };
        let to = &layer.to;
        let (kernels, function, fields) = match work {
            FloatWork::Conv(conv) => {
                (vec![Kernel::FloatConv], "float_conv", convolution(&mut tables, layer, conv, arena))
            }
            FloatWork::Depthwise(conv) => {
                (vec![Kernel::FloatDepthwise], "float_depthwise", depthwise(&mut tables, layer, conv, arena))
            }
            FloatWork::Linear(linear) => (
                vec![Kernel::FloatSums, Kernel::FloatLinear],
                "float_linear",
                dense(&mut tables, layer, linear, arena),
            ),
            FloatWork::Lstm(lstm) => {
                (vec![Kernel::FloatSums, Kernel::Lstm], "lstm", recurrent(&mut tables, layer, lstm, arena))
            }
            FloatWork::Map { affine, rectifier } => (
                vec![Kernel::FloatMap],
                "float_map",
                map(
                    &mut tables,
                    layer,
                    affine.as_ref().map(|(scale, shift)| [&scale[..], shift]),
                    *rectifier,
                    arena,
                ),
            ),
            FloatWork::Deviation { share, eps } => {
                let from = &layer.from[0];
                let places = [at(from, arena), at(to, arena), to.channels, from.positions, from.pitch];
                let fields = format!("{}, {}, {}", float(*share), float(*eps), numbers(&places));
                (vec![Kernel::Root, Kernel::FloatDeviation], "float_deviation", fields)
            }
            FloatWork::Norm { eps, weight, bias } => {
                let names = [tables.add("weight", weight), tables.add("shift", bias)].join(", ");
                let share = float(1.0 / weight.len() as f32);
                let places = [at(&layer.from[0], arena), at(to, arena), weight.len()];
                let fields = format!("{names}, {share}, {}, {}", float(*eps), numbers(&places));
                (vec![Kernel::Root, Kernel::Norm], "norm", fields)
            }
        };
        FloatSource { kernels, function, tables: tables.text, table_bytes: tables.bytes + 44, fields }
    }
}

/// The tables of one layer.
struct Tables {
    number: usize,
    text: String,
    bytes: usize,
}

impl Tables {
    /// Adds a table; its name comes back.
    fn add(&mut self, what: &str, values: &[f32]) -> String {
        let name = format!("{what}_{}", self.number);
        self.text += &floats(&name, values);
        self.bytes += size_of_val(values);
        name
    }

    fn fours(&mut self, fours: &Fours) -> String {
        [self.add("weight", &fours.weight), self.add("bias", &fours.bias)].join(", ")
    }
}

/// Returns the number of a row's first float in the arena.
fn at(row: &Row, arena: &Arena) -> usize {
    offset(row, arena) / size_of::<f32>()
}

/// Returns where the first window of a layer begins.
fn begin(row: &Row, first: usize, arena: &Arena) -> usize {
    at(row, arena) - row.start + first
}

fn rectifier(which: Rectifier) -> usize {
    match which {
        Rectifier::None => 0,
        Rectifier::Relu => 1,
        Rectifier::Relu6 => 2,
    }
}

fn convolution(tables: &mut Tables, layer: &Layer, conv: &FloatConv, arena: &Arena) -> String {
    let (to, addend) = (&layer.to, layer.from.get(1));
    let added = addend.map_or([0, 0], |row| [at(row, arena), row.pitch]);
    let places = [
        begin(&layer.from[0], conv.first, arena),
        at(to, arena),
        added[0],
        conv.step,
        conv.segments,
        conv.apart,
        conv.run,
        conv.groups,
        conv.channels,
        to.channels,
        to.positions,
        to.pitch,
        added[1],
        usize::from(addend.is_some()),
        rectifier(conv.rectifier),
    ];
    format!("{}, {}", tables.fours(&conv.fours), numbers(&places))
}

fn depthwise(tables: &mut Tables, layer: &Layer, conv: &FloatDepthwise, arena: &Arena) -> String {
    let to = &layer.to;
    let names = [tables.add("weight", &conv.weight), tables.add("bias", &conv.bias)].join(", ");
    let places = [
        begin(&layer.from[0], conv.first, arena),
        at(to, arena),
        conv.step,
        conv.taps,
        conv.apart,
        to.channels,
        to.positions,
        to.pitch,
        rectifier(conv.rectifier),
    ];
    format!("{names}, {}", numbers(&places))
}

fn dense(tables: &mut Tables, layer: &Layer, linear: &FloatLinear, arena: &Arena) -> String {
    let to = &layer.to;
    let places =
        [at(&layer.from[0], arena), at(to, arena), linear.inputs, to.channels, rectifier(linear.rectifier)];
    format!("{}, {}", tables.fours(&linear.fours), numbers(&places))
}

fn recurrent(tables: &mut Tables, layer: &Layer, lstm: &Lstm, arena: &Arena) -> String {
    let names = [tables.fours(&lstm.inputs), tables.add("hidden", &lstm.hidden_weight)].join(", ");
    let work = arena.offsets[lstm.work].unwrap_or(0) / size_of::<f32>();
    let from = &layer.from[0];
    let places =
        [at(from, arena), at(&layer.to, arena), work, lstm.channels, lstm.steps, lstm.hidden, from.pitch];
    format!("{names}, {}", numbers(&places))
}

fn map(
    tables: &mut Tables,
    layer: &Layer,
    affine: Option<[&[f32]; 2]>,
    which: Rectifier,
    arena: &Arena,
) -> String {
    let names = affine.map_or("NULL, NULL".into(), |[scale, shift]| {
        [tables.add("factor", scale), tables.add("shift", shift)].join(", ")
    });
    let (from, to) = (&layer.from[0], &layer.to);
    let places =
        [at(from, arena), at(to, arena), to.channels, to.positions, from.pitch, to.pitch, rectifier(which)];
    format!("{names}, {}", numbers(&places))
}
