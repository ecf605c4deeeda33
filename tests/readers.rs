//! Every reader on damaged files: an answer or a refusal that names the file, never a panic, and no more memory
//! than the file is worth.
//!
//! `fuzz/` looks for such files with a coverage-guided fuzzer; what it found is replayed here. `TAXEL_FUZZ_ROUNDS`
//! asks for more damaged files per reader than the few of every test run, `TAXEL_FUZZ_READER` for one reader alone.

#![allow(clippy::unwrap_used, clippy::panic)]

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use peak_alloc::PeakAlloc;
use rand::RngExt;

#[allow(clippy::unwrap_used, clippy::expect_used)]
#[path = "../fuzz/readers.rs"]
mod readers;

use readers::{READERS, Reader};

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

/// A file that takes longer hangs.
const PATIENCE: Duration = Duration::from_secs(30);

/// Numbers that stand for sizes and counts in one format or another.
const SIZES: [&[u8]; 8] = [
    &[0xFF; 8],
    &[0xFF, 0xFF, 0xFF, 0x7F],
    &[0, 0, 0, 0x80],
    &[0; 8],
    b"4294967296",
    b"-1",
    b"1e308",
    b"NaN",
];

/// Numbers for texts.
const NUMBERS: [&str; 10] =
    ["0", "-1", "1", "7", "255", "65536", "4294967296", "18446744073709551615", "1e308", "0.5"];

/// The first whole number of a text from `at` on.
fn number(bytes: &[u8], at: usize) -> Option<std::ops::Range<usize>> {
    let from = at + bytes[at..].iter().position(u8::is_ascii_digit)?;
    let len = bytes[from..].iter().position(|byte| !byte.is_ascii_digit()).unwrap_or(bytes.len() - from);
    Some(from..from + len)
}

/// A damaged copy of a seed: bytes changed, cut out, doubled, put in from elsewhere, sizes made impossible.
fn damaged(rng: &mut taxel_base::seed::Rng, seeds: &[Vec<u8>]) -> Vec<u8> {
    let mut bytes = seeds[rng.random_range(0..seeds.len())].clone();
    for _ in 0..rng.random_range(1..5) {
        let at = rng.random_range(0..=bytes.len());
        let end = (at + rng.random_range(0..32)).min(bytes.len());
        match rng.random_range(0..9) {
            0 | 1 if at < bytes.len() => bytes[at] ^= 1u8 << rng.random_range(0..8),
            2 if at < bytes.len() => bytes[at] = rng.random(),
            3 => bytes.truncate(at),
            4 => drop(bytes.drain(at..end)),
            5 => {
                let piece = bytes[at..end].to_vec();
                let to = rng.random_range(0..=bytes.len());
                bytes.splice(to..to, piece);
            }
            6 => {
                let size = SIZES[rng.random_range(0..SIZES.len())];
                let end = (at + size.len()).min(bytes.len());
                bytes.splice(at..end, size.iter().copied());
            }
            7 => {
                let Some(place) = number(&bytes, at) else { continue };
                let number = NUMBERS[rng.random_range(0..NUMBERS.len())];
                bytes.splice(place, number.bytes());
            }
            _ => {
                let other = &seeds[rng.random_range(0..seeds.len())];
                let from = rng.random_range(0..=other.len());
                bytes.splice(at.., other[from..].iter().copied());
            }
        }
    }
    bytes
}

/// Reads `bytes`; panics with the reader's name and the place of a copy where something is wrong.
fn read(reader: &Reader, folder: &Path, bytes: &[u8]) -> bool {
    let before = MEMORY.current_usage();
    MEMORY.reset_peak_usage();
    let begun = Instant::now();
    let outcome = catch_unwind(AssertUnwindSafe(|| (reader.read)(folder, bytes)));
    let peak = MEMORY.peak_usage().saturating_sub(before);
    let wrong = match outcome {
        Err(_) => "panicked on",
        Ok(_) if peak > 4 * bytes.len() + (64 << 20) => "took too much memory for",
        Ok(_) if begun.elapsed() > PATIENCE => "took too long for",
        Ok(accepted) => return accepted,
    };
    let copy = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("{}-wrong", reader.name));
    std::fs::write(&copy, bytes).unwrap();
    panic!("{} {wrong} {} ({} bytes, peak {peak})", reader.name, copy.display(), bytes.len());
}

fn found(reader: &Reader) -> Vec<Vec<u8>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/found").join(reader.name);
    let Ok(entries) = std::fs::read_dir(folder) else { return vec![] };
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    paths.iter().map(|path| std::fs::read(path).unwrap()).collect()
}

#[test]
fn damaged_files_are_read_or_refused() {
    let rounds: usize = std::env::var("TAXEL_FUZZ_ROUNDS").map_or(200, |text| text.parse().unwrap());
    // Symbols for backtraces, where they are asked for, take more memory than any file here: once, and now.
    let _ = std::backtrace::Backtrace::force_capture().to_string();
    let only = std::env::var("TAXEL_FUZZ_READER").ok();
    let is_wanted = |reader: &&Reader| only.as_deref().is_none_or(|name| name == reader.name);
    assert!(READERS.iter().any(|reader| is_wanted(&reader)), "no reader is called {only:?}");
    for reader in READERS.iter().filter(is_wanted) {
        let folder = tempfile::tempdir().unwrap();
        let mut seeds = (reader.seeds)();
        // Some seeds are of versions that are refused by name.
        let sound = seeds.iter().filter(|seed| read(reader, folder.path(), seed)).count();
        assert!(sound > 0, "{} refuses every seed", reader.name);
        for bytes in found(reader) {
            read(reader, folder.path(), &bytes);
            seeds.push(bytes);
        }
        let mut rng = taxel_base::seed::rng(0, &format!("damaged {}", reader.name));
        let accepted = (0..rounds)
            .filter(|_| {
                let bytes = damaged(&mut rng, &seeds);
                read(reader, folder.path(), &bytes)
            })
            .count();
        eprintln!("{}: {} seeds, {accepted} of {rounds} damaged files accepted", reader.name, seeds.len());
    }
}

#[test]
fn every_format_of_recordings_is_fuzzed() {
    for format in taxel::data::formats().filter(|format| !format.endings.is_empty()) {
        let is_named = |reader: &&Reader| format.endings.contains(&reader.name);
        let name = format.name;
        assert!(READERS.iter().any(|reader| is_named(&reader)), "{name}: add one of its endings to READERS");
    }
}
