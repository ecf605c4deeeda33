//! `environment.json`: on what machine and with which code a run was made.

use std::fs;

use serde::{Deserialize, Serialize};
use taxel_data::{Facts, Source};

/// Git commit that this program was built from, with `-dirty` behind it if sources had been changed since.
pub(crate) const COMMIT: Option<&str> = option_env!("TAXEL_COMMIT");

/// Machine, code and data of a run; what cannot be found out is left out.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Environment {
    /// Version of taxel.
    pub taxel: String,
    /// Git commit that it was built from, with `-dirty` behind it if sources had been changed since.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub commit: Option<String>,
    /// The compiler that built it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rustc: Option<String>,
    /// Whether it was built with `--release`.
    pub optimised: bool,
    /// Operating system and architecture.
    pub platform: String,
    /// Processor.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cpu: Option<String>,
    /// Width of its vectors that the engine computes with: `AVX-512`, `AVX2` or `portable`. With AVX-512
    /// matrix products are rounded elsewhere than without, so that the same training ends a little elsewhere.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub vectors: Option<String>,
    /// Hardware threads that the process may use.
    pub cores: usize,
    /// Worker threads of the run.
    pub threads: usize,
    /// Seed of the experiment.
    pub seed: u64,
    /// The data that the scores were measured on.
    pub source: Source,
    /// BLAKE3 of the samples.
    pub data_digest: String,
    /// The facts about them that a training depends on; none in folders of older versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub facts: Option<Facts>,
}

/// Returns the version of this program with the commit that it was built from, where that is known: `0.1.0 1f0c..`.
pub fn program() -> String {
    let version = env!("CARGO_PKG_VERSION");
    COMMIT.map_or(version.into(), |commit| format!("{version} {commit}"))
}

impl Environment {
    /// Describes this machine and this build, for scores on `source`.
    pub fn now(threads: usize, seed: u64, source: &Source, data_digest: &str) -> Self {
        Environment {
            taxel: env!("CARGO_PKG_VERSION").into(),
            commit: COMMIT.map(String::from),
            rustc: option_env!("TAXEL_RUSTC").map(String::from),
            optimised: !cfg!(debug_assertions),
            platform: format!("{}-{}", std::env::consts::OS, std::env::consts::ARCH),
            cpu: cpu(),
            vectors: Some(taxel_engine::vectors().into()),
            cores: cores(),
            threads,
            seed,
            source: source.clone(),
            data_digest: data_digest.into(),
            facts: None,
        }
    }

    /// Returns the processor, with the width of its vectors where the run has written it: `AMD EPYC (AVX2)`.
    pub fn processor(&self) -> Option<String> {
        let cpu = self.cpu.as_deref()?;
        Some(self.vectors.as_ref().map_or(cpu.into(), |vectors| format!("{cpu} ({vectors})")))
    }

    /// Says that this run and `now` are of two processors, or of vectors of two widths; `None` where they are not.
    pub(crate) fn another_machine(&self, now: &Environment) -> Option<String> {
        // A run of a version that did not write the width says nothing against it.
        if self.cpu == now.cpu && (self.vectors.is_none() || self.vectors == now.vectors) {
            return None;
        }
        let name =
            |environment: &Environment| environment.processor().unwrap_or("an unknown processor".into());
        Some(format!("was run on {}, this is {}", name(self), name(now)))
    }
}

/// Returns the number of hardware threads that the process may use; 1 where that is unknown.
pub fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, Into::into)
}

fn cpu() -> Option<String> {
    let text = fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = text.lines().find(|line| line.starts_with("model name"))?;
    Some(line.split_once(':')?.1.trim().into())
}
