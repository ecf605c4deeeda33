//! The memory that the C needs.

use std::collections::BTreeSet;

use crate::kernel::Kernel;

/// Memory and products of one prediction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Size {
    /// Bytes of the constant tables.
    pub tables: usize,
    /// Bytes of tables and code, the code as gcc 12 compiles it at -O2 for a Cortex-M4 with FPU, rounded up.
    pub flash: usize,
    /// Bytes of the workspace.
    pub ram: usize,
    /// Bytes of the time steps that `push` keeps.
    pub ring: usize,
    /// Products of weights and values.
    pub macs: usize,
}

impl Size {
    /// Returns the bytes of code besides encoding and answers.
    pub(crate) fn code(kernels: &BTreeSet<Kernel>) -> usize {
        /// Interface and input.
        const BASE: usize = 900;
        let bytes = |kernel: &Kernel| match kernel {
            Kernel::Fill => 40,
            Kernel::Root => 200,
            Kernel::Conv => 1700,
            Kernel::Depthwise => 500,
            Kernel::Map => 400,
            Kernel::Copy | Kernel::Flatten => 100,
            Kernel::Add => 500,
            Kernel::AddFloats => 200,
            Kernel::Pool => 0,
            Kernel::Most | Kernel::MostFloats | Kernel::MeanFloats | Kernel::Shuffle => 150,
            Kernel::Mean => 350,
            Kernel::Deviation | Kernel::FloatDeviation | Kernel::Norm => 450,
            Kernel::ConvRows | Kernel::DepthwiseRows | Kernel::MapRows => 80,
            Kernel::AddRows | Kernel::AddFloatsRows => 80,
            Kernel::ConvNumbers => 250,
            Kernel::PoolRows => 120,
            Kernel::Fused => 0,
            Kernel::FloatConv => 1000,
            Kernel::FloatDepthwise | Kernel::FloatMap => 250,
            Kernel::FloatSums => 300,
            Kernel::FloatLinear => 300,
            Kernel::Lstm => 1500,
        };
        BASE + kernels.iter().map(bytes).sum::<usize>()
    }
}
