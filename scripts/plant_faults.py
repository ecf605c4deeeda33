#!/usr/bin/env python3
"""Plants one fault after the other that gives silent wrong numbers, and checks that a test notices each.

    python3 scripts/plant_faults.py                  all of them, a table at the end (about an hour)
    python3 scripts/plant_faults.py copies labels    those with one of these words in their name
    python3 scripts/plant_faults.py --list           the names
    python3 scripts/plant_faults.py --places         only whether each place is still in the source

The source is copied to a folder of its own first and built there; --built FOLDER saves that first build, which is long. A
fault is a line of the product that is replaced; one whose place is gone is an error, so that the list follows the code.
Exit code 1 if a fault goes unnoticed.
"""

import argparse
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
DATA = "crates/data/src/"
LEARN = "crates/learn/src/"
JUDGE = "crates/judge/src/decide/"


def tests(package, *names):
    """Arguments of `cargo test` for test files of a package; `lib` are its unit tests."""
    return ["-p", package, *(part for name in names for part in (["--lib"] if name == "lib" else ["--test", name]))]


NOISE = tests("taxel", "noise_audit")

# name, file, the code, what stands there with the fault, the tests
FAULTS = [
    ("copies under data.channels", DATA + "dataset/assemble.rs", "raw.x.hashes(channels.as_deref())", "raw.x.hashes(None)", NOISE),
    ("copies under encoding.reduce", LEARN + "encoding/copies.rs", "dataset.seek_copies_in(&read);", "let _ = read;", NOISE),
    ("resume mixes facts", DATA + "dataset/facts.rs", "blake3::hash(self.fields().to_string().as_bytes())", 'blake3::hash(b"")', tests("taxel-learn", "integrity")),
    ("a unit that differs", DATA + "compare.rs", 'differs("unit", trained.clone(), here.clone());', "", tests("taxel-data", "lib")),
    ("a rate that differs", DATA + "compare.rs", 'differs("rate", format!("{trained} Hz"), format!("{here} Hz"));', "", tests("taxel-data", "lib")),
    ("a bit depth that differs", DATA + "compare.rs", 'differs("bit depth", format!("{trained} bits"), format!("{here} bits"));', "", tests("taxel-data", "lib")),
    ("values outside the training", LEARN + "model/ranges.rs", "(beyond(value) > width)", "(beyond(value) > f32::INFINITY)", tests("taxel-learn", "lib")),
    ("columns of files by place", DATA + "formats/csv_file.rs", "columns.arrange(table, &first.names, &first.file)?;", "", tests("taxel-data", "columns", "folder")),
    ("keys of JSON by place", DATA + "formats/json_time_step.rs", "if self.names == wanted {", "if self.names.len() == wanted.len() {", tests("taxel-data", "columns")),
    ("numbers in disguise", DATA + "formats/table/column_kind.rs", "Some(first) if self.disguised == self.texts", "Some(first) if self.disguised > self.texts", tests("taxel-data", "columns")),
    ("time is a channel", DATA + "formats/table/column_name.rs", "if let Some(clock) = time(&words) {", "if let Some(clock) = time(&words[..0]) {", tests("taxel-data", "columns")),
    ("an index is a channel", DATA + "formats/table/column_name.rs", "if is_pandas || is_readr", "if is_readr", tests("taxel-data", "columns", "lib")),
    ("a counter is a channel", DATA + "formats/table/column_kind.rs", "ColumnName::Counter if self.counter.is_index()", "ColumnName::Counter if false", tests("taxel-data", "columns")),
    ("numbers of columns are a reading", DATA + "formats/table/column_kind.rs", "0 => count > 1 ||", "0 => count > 1000 ||", tests("taxel-data", "columns", "lib")),
    ("counters in bags are channels", DATA + "formats/bag/tracks.rs", "if *chosen == track.topic { track.without_counters", "if false { track.without_counters", tests("taxel-data", "bag_messages")),
    ("copies are no headline", LEARN + "run/leaks.rs", "trained.contains(&hashes[**row])", "trained.len() > hashes.len() && **row > 0", tests("taxel-learn", "leaks")),
    ("an untrained class is no headline", LEARN + "run/leaks.rs", "names.extend(missing);", "names.extend(missing.into_iter().take(0));", tests("taxel-learn", "leaks")),
    ("an untrained class is a plain 0", "crates/learn/src/metrics/mod.rs", "occurs(class) && !untrained.iter().any(|other| *other as usize == class)", "occurs(class) && !untrained.is_empty() == !untrained.is_empty()", tests("taxel-learn", "lib", "leaks")),
    ("all right promises 100 %", LEARN + "metrics/interval.rs", "let low = if share <= 0.0 {", "let low = if share >= 1.0 { 1.0 } else if share <= 0.0 {", tests("taxel-learn", "intervals")),
    ("groups count as samples", LEARN + "metrics/interval.rs", "Some(_) => plain.grouped(kind, &tested),", "Some(_) => plain.ungrouped(kind),", tests("taxel-learn", "intervals")),
    ("a bootstrap of few groups is narrow", JUDGE + "statistics/bootstrap.rs", "t_quantile((alike - 1.0).max(1.0), quantile)", "t_quantile(f64::INFINITY, quantile)", tests("taxel-judge", "statistics")),
    ("two folds have no power", JUDGE + "comparison.rs", "const FEW_PARTS: usize = 2;", "const FEW_PARTS: usize = 1;", tests("taxel-judge", "lib")),
    ("what faults break is recommended", JUDGE + "choice.rs", "curve.breaks_at == Some(1)", "curve.breaks_at == Some(0)", tests("taxel-judge", "lib")),
    ("the beginning says the class", DATA + "check/beginning.rs", "above >= SUSPICIOUS * (1.0 - self.chance) &&", "above >= 1.0 &&", tests("taxel-data", "beginning")),
    ("blocks of one class", LEARN + "run/leaks.rs", "runs as f64 <= 0.25 * expected", "runs as f64 <= 0.0 * expected", tests("taxel-learn", "leaks")),
    ("look-alike labels", DATA + "dataset/labels.rs", "if let Some(first) = seen.insert(plain, name) {", "if let Some(first) = seen.insert(name.clone(), name) {", tests("taxel-data", "text_files")),
    ("bytes that are no UTF-8 merge", DATA + "formats/text.rs", "String::from_utf8(bytes).map_err(|e| {", "Ok::<_, std::string::FromUtf8Error>(String::from_utf8_lossy(&bytes).into_owned()).map_err(|e| {", tests("taxel-data", "text_files")),
    ("marks of another kind", DATA + "dataset/validate.rs", "!(0..=1).contains(*value)", "**value < 0", tests("taxel-data", "text_files")),
    ("labels with fractions are classes", DATA + "dataset/labels.rs", "has_fraction.then_some(values)", "(has_fraction && false).then_some(values)", tests("taxel-data", "text_files")),
    ("train and test are classes", DATA + "layout/split_part.rs", '"test" | "testing" => Some(Self::Test),', "", tests("taxel-data", "text_files")),
    ("a mark of the encoding is a label", DATA + "formats/text.rs", 'bytes.starts_with("\\u{feff}".as_bytes())', "false", tests("taxel-data", "text_files")),
    ("lists of lists are dropped", DATA + "formats/parquet_cells.rs", 'list.iter().enumerate().for_each(|(at, one)| one.name(&format!("{column}.{at}"), out));', 'list.iter().enumerate().filter(|(_, one)| !matches!(one, Self::List(_))).for_each(|(at, one)| one.name(&format!("{column}.{at}"), out));', tests("taxel-data", "lerobot")),
    ("tasks have no names", DATA + "layout/lerobot.rs", "name_tasks(&mut raw, path, &options.limits)?;", "let _ = name_tasks;", tests("taxel-data", "lerobot")),
    ("whole numbers are rounded", DATA + "dataset/precision.rs", "value.fract() == 0.0 && value.abs() <= WHOLE", "value.fract() != 0.0 && value.abs() <= WHOLE", tests("taxel-data", "columns")),
    ("an offset hides the signal", DATA + "dataset/precision.rs", "const LOST: f64 = 1e-3;", "const LOST: f64 = 1e9;", tests("taxel-data", "lerobot", "bag_messages")),
    ("images stay turned", DATA + "formats/image_file.rs", "image.apply_orientation(orientation);", "let _ = &mut image;", tests("taxel-data", "images")),
    ("a full scale far below", DATA + "dataset/full_scale.rs", "const OVERSHOOT: f32 = 2.0;", "const OVERSHOOT: f32 = f32::MAX;", tests("taxel-data", "facts")),
    ("a clock that wraps", DATA + "formats/stamps.rs", "const SHARE: f64 = 64.0;", "const SHARE: f64 = 1e18;", tests("taxel-data", "clocks")),
    ("a repeated stamp", DATA + "formats/stamps.rs", "(repeated == 1 || repeated * REPEATED <= steps)", "repeated > steps", tests("taxel-data", "clocks", "bag_messages")),
    ("dropout in training", "crates/onnx/src/import/layers.rs", "call.input(2).is_some() && work.flag(call, 2)? != Some(false)", "call.input(9).is_some()", tests("taxel-onnx", "refusals")),
    ("weights that are NaN", "crates/graph/src/weights.rs", "!value.is_finite() || is_variance && *value < 0.0", "is_variance && *value < -1e30", tests("taxel-onnx", "refusals")),
    ("a link out of the folder", "crates/onnx/src/import/stored.rs", "(Ok(folder), Ok(path)) => !path.starts_with(folder),", "(Ok(_), Ok(_)) => false,", tests("taxel-onnx", "refusals")),
    ("formulas in tables", "crates/base/src/printable.rs", "const FORMULA: [char; 4] = ['=', '+', '-', '@'];", "const FORMULA: [char; 4] = ['~', '~', '~', '~'];", tests("taxel-base", "lib")),
    ("escapes in names", "crates/base/src/printable.rs", r"turns || c.is_control() && !matches!(c, '\n' | '\t')", r"turns && c.is_control() && !matches!(c, '\n' | '\t')", tests("taxel-base", "lib")),
    ("the cut first line of a port", "crates/stream/src/text.rs", "number == 1 && self.begins_inside", "number == 0 && self.begins_inside", tests("taxel", "stream")),
    ("a .pth in another order of memory", "crates/checkpoint/src/pth.rs", "index.iter().zip(strides)", "index.iter().rev().zip(strides)", [*tests("taxel-checkpoint", "pth"), "--features", "pth"]),
    ("a prefix of parameter names", "crates/graph/src/weights.rs", "hint: self.hint(&param.name).into(),", 'hint: "".into(),', tests("taxel-checkpoint", "files")),
    ("runs differ by chance alone", JUDGE + "statistics/pooling.rs", "let between = paule_mandel(effects);", "let between = 0.0 * paule_mandel(effects);", tests("taxel-judge", "statistics")),
    ("runs that agree by chance are sure", JUDGE + "statistics/pooling.rs", "(heterogeneity(effects, between) / freedom).max(1.0)", "(heterogeneity(effects, between) / freedom)", tests("taxel-judge", "statistics")),
    ("few runs are many", JUDGE + "statistics/pooling.rs", "student(mean, error, freedom, confidence)", "student(mean, error, 1e6 * freedom, confidence)", tests("taxel-judge", "statistics")),
    ("every look may spend all", JUDGE + "statistics/pooling.rs", "let confidence = 1.0 - (by_now - before);", "let confidence = 0.95 + 0.0 * (by_now - before);", tests("taxel-judge", "lib")),
    ("a look has the level of the whole run", "crates/reproduction/src/claims/benchmark.rs", "confidence: look.confidence,", "confidence: self.confidence,", tests("taxel-reproduction", "lib")),
    ("weights are not trained with", LEARN + "training/learner.rs", "Some(weights) => engine.backward_weighted(loss, targets, weights),", "Some(_) => engine.backward_with(loss, targets),", tests("taxel-learn", "weights")),
    ("a window has the target of its first step", DATA + "targets/steps.rs", "firsts[*recording] + start + to - 1", "firsts[*recording] + start + to - to", tests("taxel-data", "events", "values_steps")),
    ("a delay counts samples", LEARN + "metrics/detections.rs", "at.steps[*row] - at.steps[run[0]]", "(at.steps[*row] - at.steps[run[0]]) / at.hop", tests("taxel-learn", "detections")),
    ("a delay is that of the last call", LEARN + "metrics/detections.rs", "run.iter().find(|row| is_called[**row])", "run.iter().rev().find(|row| is_called[**row])", tests("taxel-learn", "detections")),
    ("the rest of another sample", DATA + "length/ragged.rs", "levels.chunks_exact(inner.max(1)).zip(lengths)", "levels.chunks_exact(inner.max(1)).cycle().skip(outer).zip(lengths)", tests("taxel-data", "tare")),
    ("a fold without a trained class", "crates/learn/src/metrics/table.rs", "if recalls.is_empty() { 0.0 }", "if recalls.is_empty() { f64::NAN }", NOISE),
    ("a summary is a time step", DATA + "formats/odd_lines.rs", "columns.summary(text, begin, &odd).filter(|_| of_readings)", "columns.summary(text, begin, &odd).filter(|_| false)", tests("taxel-data", "logger_lines")),
    ("a pause is not said", DATA + "check/rates.rs", "const PAUSE: f64 = 5.0;", "const PAUSE: f64 = 1e9;", tests("taxel-data", "rates")),
    ("rates that differ are not said", DATA + "check/rates.rs", "const ALIKE: f64 = 0.1;", "const ALIKE: f64 = 1e9;", tests("taxel-data", "rates")),
    ("labels in disguise", DATA + "formats/table/table.rs", "warnings.extend(doubts_of_labels(&file, &y_names, &all));", "", tests("taxel-data", "decorated")),
    ("a header that changes", "crates/stream/src/numbers.rs", "is_header(line) && (!self.is_fresh || shared > 0)", "false", tests("taxel-stream", "lib")),
    ("a late header by place", "crates/stream/src/columns.rs", "if self.model_names.iter().zip(&taken.values).all(is_there) {", "if self.model_names.iter().zip(&taken.values).all(is_there) || true {", tests("taxel-stream", "lib")),
    ("another rate than that of the stamps", "crates/taxel/src/commands/record/sensor.rs", "Some(rate) if !is_stamped => rate,", "Some(rate) => rate,", tests("taxel", "record")),
]


def copy(source):
    """Copies the sources that git knows or would take. What is here already and differs gets a new time, so that cargo never
    takes what an earlier run built of a fault for what was built of the source."""
    kept = subprocess.run(["git", "ls-files", "-z", "-co", "--exclude-standard"], cwd=ROOT, check=True, capture_output=True).stdout
    names = {name for name in kept.decode().split("\0") if name and (ROOT / name).is_file()}
    for path in [path for path in source.rglob("*") if path.is_file() and str(path.relative_to(source)) not in names]:
        path.unlink()
    for name in names:
        path = source / name
        path.parent.mkdir(parents=True, exist_ok=True)
        if not path.exists():
            shutil.copy2(ROOT / name, path)
        elif path.read_bytes() != (ROOT / name).read_bytes():
            shutil.copyfile(ROOT / name, path)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("words", nargs="*", help="words of the names [all]")
    parser.add_argument("--list", action="store_true", help="print the names")
    parser.add_argument("--places", action="store_true", help="only check that each place is there once")
    parser.add_argument("--work", type=Path, default=ROOT / "target/faults", help="folder of the copy [%(default)s]")
    parser.add_argument("--built", type=Path, help="target folder of the same source, copied as the first build")
    parser.add_argument("--seconds", type=int, default=1500, help="longest build and test of one fault [%(default)s]")
    options = parser.parse_args()

    chosen = [fault for fault in FAULTS if not options.words or any(word in fault[0] for word in options.words)]
    gone = [f"{name}: {file} does not hold {code!r} once" for name, file, code, _, _ in chosen if (ROOT / file).read_text().count(code) != 1]
    if gone:
        sys.exit("\n".join(gone))
    if options.list or options.places:
        print("\n".join(name for name, *_ in chosen))
        return

    source, target = options.work / "source", options.work / "target"
    if options.built and not target.exists():
        if source.exists():
            sys.exit(f"{source} is from an earlier run, and {target} is gone; remove both to begin anew")
        shutil.copytree(options.built, target, symlinks=True)
    copy(source)
    environment = {**os.environ, "CARGO_TARGET_DIR": str(target.resolve()), "CARGO_INCREMENTAL": "0"}

    unnoticed = 0
    print("| fault | test | outcome | seconds |\n|---|---|---|---|", flush=True)
    for name, file, code, faulty, arguments in chosen:
        path, begun = source / file, time.time()
        sound = path.read_text()
        path.write_text(sound.replace(code, faulty))
        cargo = ["cargo", "test", "--locked", "--quiet", *arguments]
        try:
            built = subprocess.run([*cargo, "--no-run"], cwd=source, env=environment, capture_output=True, text=True, timeout=options.seconds)
            ran = built if built.returncode else subprocess.run(cargo, cwd=source, env=environment, capture_output=True, text=True, timeout=options.seconds)
        finally:
            path.write_text(sound)
        if built.returncode:
            outcome = "does not compile: " + next((line for line in built.stderr.splitlines() if line.startswith("error")), "?")
        elif ran.returncode:
            failed = {line.strip() for line in ran.stdout.splitlines() if line.startswith("    ") and " " not in line.strip()}
            outcome = "red: " + ", ".join(sorted(failed)[:3])
        else:
            outcome = "UNNOTICED"
        unnoticed += not outcome.startswith("red")
        of = " ".join(arguments[1:]).replace("--test ", "").replace("--lib", "unit tests")
        print(f"| {name} | {of} | {outcome} | {time.time() - begun:.0f} |", flush=True)
    print(f"\n{len(chosen) - unnoticed} of {len(chosen)} faults turn a test red")
    sys.exit(1 if unnoticed else 0)


if __name__ == "__main__":
    main()
