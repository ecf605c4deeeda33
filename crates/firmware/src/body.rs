//! The computation of a method, as C: a network, or a linear model on features.

use crate::arena::{Arena, element, offset};
use crate::cores::Counts;
use crate::encoding::Encoding;
use crate::floats::in_place::in_place;
use crate::fuse::fuse;
use crate::layer::{Layer, Stage, Work};
use crate::lower::{Network, lower};
use crate::rows::lined;
use crate::size::Size;
use crate::source::{Source, margins};

/// The C of a method, and what it needs.
#[derive(Debug)]
pub(crate) struct Body {
    /// Functions that it calls.
    pub kernels: String,
    /// Constant tables.
    pub tables: String,
    /// Statements that compute the outputs of the input in the arena.
    pub calls: String,
    pub table_bytes: usize,
    pub code_bytes: usize,
    /// Its operations; not counted for linear models.
    pub counts: Option<Counts>,
    pub macs: usize,
    /// Bytes of whole numbers that processors without floats in hardware need besides.
    pub whole_bytes: usize,
    /// Bytes of the arena.
    pub arena: usize,
    /// How the input is written, and its first value.
    pub stage: Stage,
    pub stage_at: usize,
    /// Statements that fill the margins of the input.
    pub stage_margins: String,
    /// First byte of the outputs, and their number.
    pub outputs_at: usize,
    pub outputs: usize,
    /// Whether it needs an FPU with fused products.
    pub needs_fpu: bool,
    /// Layers whose endings the test tries.
    pub layers: Vec<Layer>,
}

impl Body {
    /// Plans a network.
    ///
    /// # Errors
    /// The reason, where it has no C of the same bits.
    pub fn network(
        blueprint: &taxel_runtime::Blueprint,
        encoding: &Encoding,
        sample: [usize; 2],
    ) -> Result<Self, String> {
        let network = lined(in_place(fuse(lower(blueprint, encoding.shape(sample))?)));
        let staged = network.layers.iter().rev().find_map(|layer| match &layer.work {
            Work::Stage(stage) => Some((stage.clone(), layer.to)),
            _ => None,
        });
        let Some((stage, to)) = staged else { return Err("it reads no sample".into()) };
        let arena = Arena::new(&network.layers, &network.memories, &network.logits);
        let source = Source::new(&network, &arena);
        let mut kernels = String::new();
        for kernel in &source.kernels {
            kernels += &format!("\n{}", kernel.text(&network));
        }
        let full = if has_full_bytes(&network) { "#define FULL_BYTES 1\n\n" } else { "" };
        Ok(Body {
            kernels: format!("{full}{}{kernels}", include_str!("c/floats.c")),
            table_bytes: source.table_bytes,
            code_bytes: Size::code(&source.kernels),
            counts: Some(Counts::of(&network.layers, encoding.operations(sample))),
            whole_bytes: source.whole_bytes,
            macs: network.layers.iter().map(Layer::macs).sum(),
            arena: arena.len,
            stage_at: offset(&to, &arena) / element(&to),
            stage_margins: margins(&network, &arena, to.memory),
            stage,
            outputs_at: offset(&network.logits, &arena),
            outputs: network.logits.channels,
            tables: source.tables,
            calls: source.calls,
            needs_fpu: network
                .layers
                .iter()
                .any(|layer| matches!(&layer.work, Work::Floats(work) if work.is_fused())),
            layers: network.layers,
        })
    }
}

/// Checks whether all bytes may be 0 to 255: nothing is cut off before.
fn has_full_bytes(network: &Network) -> bool {
    network.layers.iter().filter(|layer| layer.to.scale.is_some()).all(|layer| match &layer.work {
        Work::Stage(Stage { ending, .. })
        | Work::Map { ending, .. }
        | Work::Add { ending, .. }
        | Work::Mean { ending, .. } => (ending.low, ending.high) == (0.0, 255.0),
        Work::Conv(conv) => {
            let ending = conv.then.map_or(conv.ending, |then| then.ending);
            (ending.low, ending.high) == (0.0, 255.0)
        }
        Work::Depthwise(conv) => (conv.ending.low, conv.ending.high) == (0.0, 255.0),
        _ => true,
    })
}
