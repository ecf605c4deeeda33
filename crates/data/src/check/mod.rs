//! The checks of a data set that `data check` prints.

pub(crate) mod beginning;
pub(crate) mod card;
pub(crate) mod card_channels;
pub(crate) mod card_text;
pub(crate) mod counting;
pub(crate) mod describe;
pub(crate) mod drift;
pub(crate) mod duplicates;
pub(crate) mod quantities;
pub(crate) mod rates;
pub(crate) mod shortcut;
pub(crate) mod value_confounds;
pub(crate) mod values;
pub(crate) mod voters;
pub(crate) mod warnings;
