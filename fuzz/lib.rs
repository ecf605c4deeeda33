//! The readers to fuzz; see README.md.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::sync::OnceLock;

pub use libfuzzer_sys;
use peak_alloc::PeakAlloc;

mod readers;
pub use readers::{READERS, Reader};

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

/// Returns the reader to fuzz, which `TAXEL_FUZZ_READER` names.
pub fn asked() -> &'static Reader {
    static ASKED: OnceLock<&Reader> = OnceLock::new();
    ASKED.get_or_init(|| {
        let name = std::env::var("TAXEL_FUZZ_READER").expect("TAXEL_FUZZ_READER names a reader");
        READERS.iter().find(|reader| reader.name == name).expect("the name of a reader in READERS")
    })
}

/// Reads `bytes` in a folder of this process.
///
/// A panic ends the process, and so does a reader that takes more memory than the file is worth.
pub fn read(reader: &Reader, bytes: &[u8]) {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    let folder = FOLDER.get_or_init(|| {
        // libfuzzer's hook ends the process at every panic, also at one that a reader catches at its boundary.
        drop(std::panic::take_hook());
        let memory = PathBuf::from("/dev/shm");
        let at = if memory.is_dir() { memory } else { std::env::temp_dir() };
        let folder = at.join(format!("taxel-fuzz-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder to read from");
        folder
    });
    let before = MEMORY.current_usage();
    MEMORY.reset_peak_usage();
    if catch_unwind(AssertUnwindSafe(|| (reader.read)(folder, bytes))).is_err() {
        std::process::abort();
    }
    let peak = MEMORY.peak_usage().saturating_sub(before);
    if peak > 4 * bytes.len() + (64 << 20) {
        eprintln!("{} took {peak} bytes of memory for a file of {}", reader.name, bytes.len());
        std::process::abort();
    }
}
