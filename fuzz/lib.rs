//! Fuzz targets of all readers; see README.md.

use std::path::PathBuf;
use std::sync::OnceLock;

pub use libfuzzer_sys;

mod readers;
pub use readers::{READERS, Reader};

/// One fuzz target: the reader of that name.
#[macro_export]
macro_rules! target {
    ($name:literal) => {
        $crate::libfuzzer_sys::fuzz_target!(|bytes: &[u8]| $crate::read($name, bytes));
    };
}

/// Reads `bytes` with the reader `name`, in a folder of this process.
pub fn read(name: &str, bytes: &[u8]) {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    let folder = FOLDER.get_or_init(|| {
        let memory = PathBuf::from("/dev/shm");
        let at = if memory.is_dir() { memory } else { std::env::temp_dir() };
        let folder = at.join(format!("taxel-fuzz-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder to read from");
        folder
    });
    let reader = READERS.iter().find(|reader| reader.name == name).expect("a target for every reader");
    (reader.read)(folder, bytes);
}
