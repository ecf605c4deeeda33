//! Networks in floats under QEMU: bits, and instructions and bytes that do not change unnoticed.
#![allow(clippy::unwrap_used, clippy::panic)]

mod common;

use std::path::Path;
use std::process::Command;

use common::{Case, classes, z_score};
use taxel_firmware::write_folder;

/// The page whose rows have to come out again.
const PAGE: &str = "docs/benchmarks/2026-11-29-firmware.md";

#[test]
#[ignore = "needs qemu-system-arm, qemu-system-misc, gcc-arm-none-eabi and gcc-riscv64-unknown-elf"]
fn needs_emulators_that_count_what_the_page_says() {
    let home = tempfile::tempdir().unwrap();
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).unwrap();
    let mut command = Command::new("python3");
    command.current_dir(root).args(["scripts/firmware_cores.py", "--levels", "1", "--pinned", PAGE]);
    command.args(["--cores", "M4", "M55", "RV32IMAFC", "--rows"]).arg(home.path().join("rows.jsonl"));
    command.arg("--folders");
    for name in ["resnet8-lite-1d", "mlp"] {
        let case = Case::floats(name, z_score(), classes(None));
        let folder = home.path().join(&case.name);
        write_folder(&folder, &case.library().files().unwrap()).unwrap();
        command.arg(folder);
    }
    let done = command.output().unwrap();
    let said = [done.stdout, done.stderr].concat();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&said));
}
