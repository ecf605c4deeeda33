//! The algorithms by name.

/// How a convolution is computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ConvKind {
    /// Every product of the definition.
    Direct,
    /// The same where every channel is a group of its own.
    Depthwise,
    /// Fewer products, at the price of transforms.
    Winograd,
}
