//! How much memory of a microcontroller a network may take.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use taxel_base::thousands;
use taxel_learn::require;

use crate::error::Result;

/// How much flash and RAM a network may take, and what each one takes.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Room {
    /// Bytes of flash for code and tables; none: no limit.
    pub max_flash: Option<u64>,
    /// Bytes of RAM for the workspace and the last time steps; none: no limit.
    pub max_ram: Option<u64>,
    /// The memory that each row of the run takes, by name; a row that is not here has no C.
    pub needs: BTreeMap<String, Need>,
}

/// The memory that a network takes on a microcontroller.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Need {
    /// Bytes.
    Bytes {
        /// Code and tables.
        flash: u64,
        /// Workspace and time steps.
        ram: u64,
    },
    /// It has no C.
    Impossible {
        /// Why not.
        reason: String,
    },
}

impl Room {
    /// Checks the limits.
    ///
    /// # Errors
    /// A limit of 0.
    pub fn check(&self) -> Result<()> {
        for (key, limit) in [("max_flash", self.max_flash), ("max_ram", self.max_ram)] {
            let limit = limit.unwrap_or(u64::MAX);
            require(limit > 0, key, limit, "must be above 0: 64k")?;
        }
        Ok(())
    }

    /// Says why a row of the run does not fit; none of one that does.
    pub fn refusal(&self, network: &str) -> Option<String> {
        match self.needs.get(network) {
            None => Some("has no C".into()),
            Some(Need::Impossible { reason }) => Some(format!("has no C: {reason}")),
            Some(Need::Bytes { flash, ram }) => {
                let over = |what: &str, takes: u64, most: Option<u64>| {
                    let most = most.filter(|most| takes > *most)?;
                    Some(format!("{} bytes of {what}, and {} are there", thousands(takes), thousands(most)))
                };
                let over: Vec<String> =
                    [over("flash", *flash, self.max_flash), over("RAM", *ram, self.max_ram)]
                        .into_iter()
                        .flatten()
                        .collect();
                (!over.is_empty()).then(|| format!("needs {}", over.join("; ")))
            }
        }
    }

    /// Says what the chosen network takes.
    pub(crate) fn words(&self, network: &str) -> Option<String> {
        let Some(Need::Bytes { flash, ram }) = self.needs.get(network) else { return None };
        let limit = |most: Option<u64>| most.map_or(String::new(), |most| format!(" of {}", thousands(most)));
        Some(format!(
            "As C it takes about {}{} bytes of flash and {}{} of RAM.",
            thousands(*flash),
            limit(self.max_flash),
            thousands(*ram),
            limit(self.max_ram)
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_does_not_fit_is_named_with_its_bytes() {
        let needs = [
            ("small", Need::Bytes { flash: 65_536, ram: 16_384 }),
            ("large", Need::Bytes { flash: 65_537, ram: 16_385 }),
            ("image", Need::Impossible { reason: "reads images".into() }),
        ];
        let needs = needs.into_iter().map(|(name, need)| (name.to_string(), need)).collect();
        let room = Room { max_flash: Some(65_536), max_ram: Some(16_384), needs };
        assert_eq!(room.refusal("small"), None);
        let large = room.refusal("large").unwrap_or_default();
        assert_eq!(
            large,
            "needs 65,537 bytes of flash, and 65,536 are there; 16,385 bytes of RAM, and 16,384 are there"
        );
        assert_eq!(room.refusal("image").as_deref(), Some("has no C: reads images"));
        assert_eq!(room.refusal("unknown").as_deref(), Some("has no C"));
        let free = Room { max_flash: None, max_ram: None, ..room.clone() };
        assert_eq!(free.refusal("large"), None);
        assert!(free.check().is_ok() && Room { max_ram: Some(0), ..room }.check().is_err());
    }
}
