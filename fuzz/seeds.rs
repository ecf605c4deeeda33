//! Writes the small whole files that every target starts from into `corpus/<target>/`, beside what was found.

use std::fs;
use std::path::Path;

fn main() {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    for reader in taxel_fuzz::READERS {
        let folder = here.join("corpus").join(reader.name);
        fs::create_dir_all(&folder).expect("a folder for seeds");
        for (number, seed) in (reader.seeds)().iter().enumerate() {
            fs::write(folder.join(format!("seed-{number}")), seed).expect("room for a seed");
        }
        for entry in fs::read_dir(here.join("found").join(reader.name)).into_iter().flatten().flatten() {
            fs::copy(entry.path(), folder.join(entry.file_name())).expect("room for a seed");
        }
    }
}
