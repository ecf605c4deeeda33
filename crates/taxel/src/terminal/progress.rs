//! Progress of long work on standard error.

use std::io::IsTerminal;

use taxel::IndicatifProgress;
use taxel::learn::{Progress, Silent};

use super::messages::{Verbosity, says};

/// Makes a bar on a terminal, with its lines elsewhere too; nothing with `--quiet`.
pub fn progress() -> Box<dyn Progress + Sync> {
    if says(Verbosity::Normal) { Box::<IndicatifProgress>::default() } else { Box::new(Silent) }
}

/// Makes a bar on a terminal, and nothing elsewhere.
pub fn bar() -> Box<dyn Progress + Sync> {
    if std::io::stderr().is_terminal() { progress() } else { Box::new(Silent) }
}
