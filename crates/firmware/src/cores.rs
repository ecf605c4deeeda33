//! The cost of one prediction on different cores, estimated: instructions and flash.
//!
//! The numbers are fitted to those that QEMU counted (`docs/benchmarks/2026-11-29-firmware.md`), and a test holds both against
//! each other.

use std::fmt::{self, Display, Formatter};

use crate::floats::layer::FloatWork;
use crate::layer::{Layer, Row, Work};
use crate::whole::Whole;

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
    /// Arm Cortex-M55 with Helium.
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
    /// Those that are computed in floats everywhere, also where whole numbers could be: floats of convolutions and maps, and the
    /// encoding.
    pub floats: usize,
    /// Whether products are of floats: then `floats` counts what needs functions, such as a sigmoid.
    pub is_float: bool,
}

impl Counts {
    /// Counts the operations of layers behind an encoding of so many operations.
    pub fn of(layers: &[Layer], encoding: usize) -> Self {
        let mut counts =
            Counts { products: 0, single: 0, others: encoding, floats: encoding, is_float: false };
        for layer in layers {
            let stored = layer.to.len() * layer.to.channels;
            match &layer.work {
                Work::Conv(conv) => {
                    let products = stored * conv.segments * conv.fours * 4;
                    *(if layer.to.len() > 1 { &mut counts.products } else { &mut counts.single }) += products;
                    counts.others += stored * (1 + conv.segments);
                    counts.floats += if Whole::new(conv).is_none() { stored } else { 0 };
                }
                Work::Depthwise(conv) => {
                    counts.single += conv.macs;
                    counts.others += 2 * stored;
                }
                Work::Floats(work) => counts.add_floats(work, &layer.to),
                Work::Stage(_) => {}
                Work::Most(windows) | Work::Mean { windows, .. } | Work::MeanFloats { windows, .. } => {
                    counts.others += windows.reads() * layer.to.channels;
                }
                Work::Map { .. } => {
                    counts.others += stored;
                    counts.floats += stored;
                }
                _ => counts.others += stored,
            }
        }
        if counts.is_float {
            counts.floats -= encoding;
        }
        counts
    }

    fn add_floats(&mut self, work: &FloatWork, to: &Row) {
        let macs = work.macs(to.positions, to.channels);
        self.is_float |= work.is_fused();
        match work {
            FloatWork::Conv(_) => {
                // Four positions share weights; those that are left do not.
                let left = macs / to.positions * (to.positions % 4);
                self.products += macs - left;
                self.single += left;
                self.others += to.positions * to.channels;
            }
            FloatWork::Depthwise(_) => {
                self.single += macs;
                self.others += 2 * to.positions * to.channels;
            }
            FloatWork::Linear(_) => {
                self.single += macs;
                self.others += to.channels;
            }
            FloatWork::Lstm(lstm) => {
                self.single += macs;
                self.floats += lstm.steps * lstm.hidden;
            }
            FloatWork::Map { .. } => self.others += to.positions * to.channels,
            FloatWork::Norm { weight, .. } => self.others += 4 * weight.len(),
            FloatWork::Deviation { share, .. } => {
                self.others += 2 * (1.0 / share).round() as usize * to.channels;
            }
        }
    }
}

/// A microcontroller, as a measure of what its core usually has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Part {
    /// Its name.
    pub name: &'static str,
    /// Bytes of flash on the chip.
    pub flash: usize,
    /// Bytes of RAM.
    pub ram: usize,
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

    /// Returns a large part with this core.
    pub fn part(self) -> Part {
        let part = |name, flash: usize, ram: usize| Part { name, flash: flash << 10, ram: ram << 10 };
        match self {
            Core::M0 => part("STM32F091", 256, 32),
            Core::M3 => part("STM32F103xG", 1024, 96),
            Core::M4f => part("STM32L4R9", 2048, 640),
            Core::M7 => part("STM32H743", 2048, 1024),
            Core::M33 => part("STM32U5A9", 4096, 2496),
            Core::M55 => part("Alif E3", 5632, 4096),
            Core::Rv32imac => part("GD32VF103", 128, 32),
            Core::Rv32imafc => part("CH32V307", 256, 64),
        }
    }

    /// Checks whether it computes floats in hardware.
    pub fn has_floats(self) -> bool {
        !matches!(self, Core::M0 | Core::M3 | Core::Rv32imac)
    }

    /// Returns the instructions for each of the [`Counts`], by least squares of shares.
    fn each(self) -> [f64; 4] {
        match self {
            Core::M0 => [3.66, 9.83, 54.23, 185.48],
            Core::M3 => [2.51, 5.48, 26.5, 108.35],
            Core::M4f => [1.27, 2.0, 17.7, 0.0],
            Core::M7 => [1.28, 2.01, 17.3, 0.0],
            Core::M33 => [1.28, 2.01, 17.28, 0.0],
            Core::M55 => [0.12, 0.5, 7.71, 17.65],
            Core::Rv32imac => [3.59, 7.69, 34.02, 191.77],
            Core::Rv32imafc => [3.32, 5.79, 21.81, 0.0],
        }
    }

    /// Returns about how many instructions a product of floats takes in a convolution, rounded once as the runtime does.
    pub(crate) fn float_product(self) -> f64 {
        self.each_float()[0]
    }

    /// Returns the instructions for each of the [`Counts`] of floats, by least squares of shares.
    fn each_float(self) -> [f64; 4] {
        match self {
            Core::M0 => [1276.85, 1276.85, 0.0, 0.0],
            Core::M3 => [478.4, 533.65, 0.0, 0.0],
            Core::M4f => [1.67, 3.5, 15.58, 391.58],
            Core::M7 => [1.67, 3.5, 15.51, 396.31],
            Core::M33 => [1.66, 3.5, 15.58, 392.66],
            Core::M55 => [1.63, 3.54, 13.84, 383.44],
            Core::Rv32imac => [891.52, 972.0, 0.0, 0.0],
            Core::Rv32imafc => [1.95, 3.28, 12.77, 429.56],
        }
    }

    /// Estimates the instructions of a prediction.
    pub(crate) fn instructions(self, counts: &Counts) -> usize {
        let Counts { products, single, others, floats, is_float } = *counts;
        let each = if is_float { self.each_float() } else { self.each() };
        let each = each.into_iter().zip([products, single, others, floats]);
        each.map(|(instructions, count)| instructions * count as f64).sum::<f64>().round() as usize
    }

    /// Estimates the flash of tables and of code that takes `code` bytes on a Cortex-M4.
    pub(crate) fn flash(self, tables: usize, code: usize, whole: usize) -> usize {
        let (share, whole) = match self {
            Core::M0 => (1.3, whole),
            Core::M3 => (1.25, whole),
            Core::M4f | Core::M7 | Core::M33 | Core::M55 => (1.0, 0),
            Core::Rv32imac => (1.75, whole),
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
