//! Series of the UCR and UEA archives: pairs of `_TRAIN` and `_TEST` files.

pub(crate) mod arff;
pub(crate) mod case;
pub(crate) mod plain;
pub(crate) mod ts;
pub(crate) mod ucr;
