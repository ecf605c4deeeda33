//! Kernels as C text.

use crate::cores::Core;
use crate::layer::{RowNumber, Work};
use crate::lower::Network;
use crate::row_text::{self, Lines};

/// From the end of a row of a window to the start of the next one.
const POOL_STEP: &str = "x += l->line - ((uint32_t)s.to - s.from) * l->from_pitch;";

/// A kernel as C text, in the order in which they have to stand.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Kernel {
    Fill,
    Root,
    Conv,
    ConvRows,
    ConvNumbers,
    Depthwise,
    DepthwiseRows,
    Map,
    MapRows,
    Copy,
    Add,
    AddRows,
    AddFloats,
    AddFloatsRows,
    Pool,
    Most,
    MostFloats,
    Mean,
    MeanFloats,
    PoolRows,
    Deviation,
    Shuffle,
    Flatten,
    Fused,
    FloatConv,
    FloatDepthwise,
    FloatMap,
    FloatDeviation,
    FloatSums,
    FloatLinear,
    Lstm,
    Norm,
}

impl Kernel {
    /// Returns the C text for a network.
    pub fn text(self, network: &Network) -> String {
        let lines = Lines::of(&network.layers);
        let step = lines.pool.then_some(POOL_STEP);
        let text = match self {
            Kernel::Conv => return conv_text(network, lines),
            Kernel::ConvRows => return row_text::text("conv", &["from", "to", "addend"]),
            Kernel::ConvNumbers => include_str!("c/image/numbers.c"),
            Kernel::Fill => include_str!("c/image/fill.c"),
            Kernel::Root => include_str!("c/root.c"),
            Kernel::Depthwise => return depthwise_text(lines),
            Kernel::DepthwiseRows => return row_text::text("depthwise", &["from", "to"]),
            Kernel::Map => include_str!("c/map.c"),
            Kernel::MapRows => return row_text::text("map", &["from", "to"]),
            Kernel::AddRows => return row_text::text("add", &["a", "b", "to"]),
            Kernel::AddFloatsRows => return row_text::text("add_floats", &["a", "b", "to"]),
            Kernel::Copy => include_str!("c/copy.c"),
            Kernel::Add => include_str!("c/add.c"),
            Kernel::AddFloats => include_str!("c/add_floats.c"),
            Kernel::Pool => return pool_text(lines),
            Kernel::Most => return row_text::windows(include_str!("c/most.c"), step),
            Kernel::MostFloats => return row_text::windows(include_str!("c/most_floats.c"), step),
            Kernel::Mean => return row_text::windows(include_str!("c/mean.c"), step),
            Kernel::MeanFloats => return row_text::windows(include_str!("c/mean_floats.c"), step),
            Kernel::PoolRows => include_str!("c/image/pool.c"),
            Kernel::Deviation => include_str!("c/deviation.c"),
            Kernel::Shuffle => include_str!("c/shuffle.c"),
            Kernel::Flatten => include_str!("c/flatten.c"),
            Kernel::Fused => return fused_text(),
            Kernel::FloatConv => include_str!("c/float32/conv.c"),
            Kernel::FloatDepthwise => include_str!("c/float32/depthwise.c"),
            Kernel::FloatMap => include_str!("c/float32/map.c"),
            Kernel::FloatDeviation => include_str!("c/float32/deviation.c"),
            Kernel::FloatSums => include_str!("c/float32/sums.c"),
            Kernel::FloatLinear => include_str!("c/float32/linear.c"),
            Kernel::Lstm => {
                let log2_e = crate::literals::float(std::f32::consts::LOG2_E);
                return include_str!("c/float32/lstm.c").replace("@log2_e@", &log2_e);
            }
            Kernel::Norm => include_str!("c/float32/norm.c"),
        };
        text.into()
    }
}

/// Returns the text that all kernels of floats begin with.
fn fused_text() -> String {
    let soft = format!("about {:.0}", Core::M3.float_product());
    include_str!("c/float32/fused.c").replace("@soft@", &soft)
}

/// Returns the text of depthwise convolutions, of images where a kernel has several rows.
fn depthwise_text(lines: Lines) -> String {
    let fields = "    uint16_t lines;\n    int32_t gap; /* from the end of a row of the kernel to the start of the next one */\n";
    let text = include_str!("c/depthwise.c");
    if lines.depthwise {
        row_text::windows(&text.replace("MORE_FIELDS\n", fields), Some("x += l->gap;"))
    } else {
        row_text::windows(text, None)
    }
}

/// Returns the description of poolings, of images where a window has several rows.
fn pool_text(lines: Lines) -> String {
    let fields = if lines.pool { include_str!("c/image/pool_fields.c") } else { "" };
    include_str!("c/pool.c").replace("MORE_FIELDS\n", fields)
}

/// Returns the text of convolutions with the modes that the network needs.
fn conv_text(network: &Network, lines: Lines) -> String {
    let mut statistics = vec![];
    for layer in &network.layers {
        let Work::Conv(conv) = &layer.work else { continue };
        statistics.extend(conv.statistics.iter().map(|statistic| statistic.number));
    }
    let has_deviation = statistics.iter().any(|number| matches!(number, RowNumber::Deviation { .. }));
    let deviation = if has_deviation { include_str!("c/statistics_deviation.c").trim_end() } else { "" };
    let (functions, ended) = if statistics.is_empty() {
        (String::new(), "")
    } else {
        let ended = "if (l->statistics != NULL) {\n        \
                     conv_statistics(l, arena + l->to / 4u, arena, filter);\n        \
                     if (next != filter) {\n            \
                     conv_statistics(l, arena + l->to / 4u + l->positions, arena, next);\n        }\n    }";
        let text = include_str!("c/statistics.c").replace("            DEVIATION\n", &indented(deviation));
        (if lines.numbers { text.replace("row[at]", "row[at * l->to_pitch]") } else { text }, ended)
    };
    include_str!("c/conv.c")
        .replace("@fraction@", &crate::whole::FRACTION.to_string())
        .replace("@more@", &crate::whole::MORE.to_string())
        .replace("@low_bits@", &format!("0x{:x}", (1u32 << crate::whole::FRACTION) - 1))
        .replace("@doubt@", &(2 * crate::whole::MARGIN).to_string())
        .replace("DOTS\n", include_str!("c/dots.c"))
        .replace("STATISTICS\n", &functions)
        .replace("VECTOR_ENDINGS\n", include_str!("c/endings_mve.c"))
        .replace("STORE_MVE\n", include_str!("c/store_mve.c"))
        .replace("    CONV_ENDED\n", &if ended.is_empty() { String::new() } else { format!("    {ended}\n") })
}

/// Returns lines in a loop of a loop; nothing of nothing.
fn indented(text: &str) -> String {
    if text.is_empty() { String::new() } else { format!("            {text}\n") }
}
