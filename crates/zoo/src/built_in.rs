//! Every network that taxel knows, family by family.

use std::sync::OnceLock;

use serde::Serialize;
use serde::de::DeserializeOwned;
use taxel_graph::{Architecture, Listing, Register};

use crate::entry::Entry;
use crate::error::Result;
use crate::registry::Registry;

/// Returns the registry of all of them.
pub fn built_in() -> &'static Registry {
    static BUILT_IN: OnceLock<Registry> = OnceLock::new();
    BUILT_IN.get_or_init(|| {
        let mut families = Families(Registry::empty());
        taxel_reference_networks::list(&mut families);
        taxel_hybrid_cnn::list(&mut families);
        taxel_tactnet3d::list(&mut families);
        taxel_multiscale_cnn::list(&mut families);
        taxel_visuotactile::list(&mut families);
        families.0
    })
}

impl Registry {
    /// Returns the networks of the papers and those they compare with.
    pub fn built_in() -> Self {
        built_in().clone()
    }
}

/// Finds the network called `name` among them.
///
/// # Errors
/// As [`Registry::find`].
pub fn find(name: &str) -> Result<&'static Entry> {
    built_in().find(name)
}

/// Collects what the families list.
struct Families(Registry);

impl Register for Families {
    fn add<C>(&mut self, network: Listing<C>)
    where
        C: Architecture + Serialize + DeserializeOwned + Send + Sync + 'static,
    {
        #[expect(clippy::expect_used, reason = "a test builds this registry")]
        self.0.add(Entry::listed(network)).expect("the names of the families differ");
    }
}
