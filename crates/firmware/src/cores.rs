//! The cost of one prediction on different cores, estimated: instructions and flash.
//!
//! The numbers are fitted to those that QEMU counted (`docs/benchmarks/2026-11-28-firmware.md`), and a test holds both against
//! each other.

use std::fmt::{self, Display, Formatter};

use crate::layer::{Layer, Work};

/// A microcontroller's core.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Core {
    /// Arm Cortex-M0, without floats in hardware.
    M0,
    /// Arm Cortex-M3, without floats in hardware.
    M3,
    /// Arm Cortex-M4 with FPU.
    M4f,
    /// Arm Cortex-M7 with FPU.
    M7,
    /// Arm Cortex-M33 with FPU.
    M33,
    /// Arm Cortex-M55; the loops are those of the M4.
    M55,
    /// RISC-V of 32 bits, without floats in hardware.
    Rv32imac,
    /// RISC-V of 32 bits with FPU.
    Rv32imafc,
}

/// The operations of a network.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Counts {
    /// Products at several positions, two of which share what is loaded. Stretches of inputs are filled up to fours.
    pub products: usize,
    /// Products at one position.
    pub single: usize,
    /// Sums that begin or become values, stretches of their inputs, and values of other layers and the encoding.
    pub others: usize,
}

impl Counts {
    /// Counts the operations of layers behind an encoding of so many operations.
    pub fn of(layers: &[Layer], encoding: usize) -> Self {
        let mut counts = Counts { products: 0, single: 0, others: encoding };
        for layer in layers {
            let stored = layer.to.positions * layer.to.channels;
            match &layer.work {
                Work::Conv(conv) => {
                    let products = stored * conv.segments * conv.fours * 4;
                    *(if layer.to.positions > 1 { &mut counts.products } else { &mut counts.single }) +=
                        products;
                    counts.others += stored * (1 + conv.segments);
                }
                Work::Depthwise(conv) => {
                    counts.single += conv.macs;
                    counts.others += 2 * stored;
                }
                Work::Stage(_) => {}
                Work::Most(spans) | Work::Mean { spans, .. } | Work::MeanFloats { spans, .. } => {
                    let read: usize = spans.iter().map(|[from, to]| to - from).sum();
                    counts.others += read * layer.to.channels;
                }
                _ => counts.others += stored,
            }
        }
        counts
    }
}

impl Core {
    /// All cores.
    pub const ALL: [Core; 8] =
        [Core::M0, Core::M3, Core::M4f, Core::M7, Core::M33, Core::M55, Core::Rv32imac, Core::Rv32imafc];

    /// Returns the name that commands know it by.
    pub fn name(self) -> &'static str {
        match self {
            Core::M0 => "m0",
            Core::M3 => "m3",
            Core::M4f => "m4f",
            Core::M7 => "m7",
            Core::M33 => "m33",
            Core::M55 => "m55",
            Core::Rv32imac => "rv32imac",
            Core::Rv32imafc => "rv32imafc",
        }
    }

    /// Checks whether it computes floats in hardware.
    pub fn has_floats(self) -> bool {
        !matches!(self, Core::M0 | Core::M3 | Core::Rv32imac)
    }

    /// Returns the instructions for each of the [`Counts`], by least squares of shares.
    fn each(self) -> [f64; 3] {
        match self {
            Core::M0 => [6.59, 11.09, 156.3],
            Core::M3 => [2.05, 6.39, 87.76],
            Core::M4f => [1.51, 2.17, 20.8],
            Core::M7 => [1.52, 2.17, 20.51],
            Core::M33 => [1.52, 2.17, 20.39],
            Core::M55 => [1.52, 2.09, 20.36],
            Core::Rv32imac => [1.39, 8.82, 151.38],
            Core::Rv32imafc => [3.57, 6.34, 18.98],
        }
    }

    /// Estimates the instructions of a prediction.
    pub(crate) fn instructions(self, counts: &Counts) -> usize {
        let Counts { products, single, others } = *counts;
        let each = self.each().into_iter().zip([products, single, others]);
        each.map(|(instructions, count)| instructions * count as f64).sum::<f64>().round() as usize
    }

    /// Estimates the flash of tables and of code that takes `code` bytes on a Cortex-M4.
    pub(crate) fn flash(self, tables: usize, code: usize, whole: usize) -> usize {
        let (share, whole) = match self {
            Core::M0 => (1.3, whole),
            Core::M3 => (1.25, whole),
            Core::M4f | Core::M7 | Core::M33 | Core::M55 => (1.0, 0),
            Core::Rv32imac => (1.6, whole),
            Core::Rv32imafc => (1.15, 0),
        };
        tables + whole + (share * code as f64) as usize
    }
}

impl Display for Core {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
