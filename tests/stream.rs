//! `taxel stream` as a user runs it: pipes, broken lines, gaps, signals, replays, a serial port.

#![cfg(unix)]
#![allow(clippy::unwrap_used, clippy::panic)]

use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::sync::LazyLock;

use serde_json::Value;
use tempfile::TempDir;

const CONFIG: &str = r#"
name = "stream"
[data]
scene = "fingertip"
samples = 60
rate = 100.0
[train]
epochs = 2
batch_size = 16
[[networks]]
name = "resnet8-lite-1d"
"#;

/// Channels and readings of a window.
const CHANNELS: usize = 5;
const TICKS: usize = 50;

static MODEL: LazyLock<(TempDir, PathBuf)> = LazyLock::new(|| {
    let folder = tempfile::tempdir().unwrap();
    let (config, model) = (folder.path().join("c.toml"), folder.path().join("m.safetensors"));
    fs::write(&config, CONFIG).unwrap();
    let output = taxel(&["fit", text(&config), "--output", text(&model)]).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    (folder, model)
});

fn taxel(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_taxel"));
    command.args(arguments).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// `taxel stream` of the model with these arguments.
fn stream(arguments: &[&str]) -> Command {
    let mut command = taxel(&["stream", text(&MODEL.1)]);
    command.args(arguments).stdin(Stdio::piped());
    command
}

/// Returns the output for `lines` on standard input.
fn piped(arguments: &[&str], lines: &str) -> Output {
    let mut child = stream(arguments).spawn().unwrap();
    let mut to = child.stdin.take().unwrap();
    let lines = lines.to_string();
    let writer = std::thread::spawn(move || to.write_all(lines.as_bytes()));
    let output = child.wait_with_output().unwrap();
    writer.join().unwrap().unwrap();
    output
}

fn decisions(output: &Output) -> Vec<Value> {
    let lines = String::from_utf8(output.stdout.clone()).unwrap();
    lines.lines().map(|line| serde_json::from_str(line).unwrap_or_else(|e| panic!("{line}: {e}"))).collect()
}

fn said(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

/// The summary of a stream that has ended well.
fn summary(output: &Output) -> Value {
    let said = said(output);
    assert_eq!(output.status.code(), Some(0), "{said}");
    let last: Value = serde_json::from_str(said.lines().last().unwrap()).unwrap();
    last["summary"].clone()
}

fn lasts(output: &Output) -> Vec<u64> {
    decisions(output).iter().map(|decision| decision["reading"].as_u64().unwrap()).collect()
}

/// A value of a stream in newton.
fn value(t: usize, channel: usize) -> f32 {
    let t = t as f32;
    4.0 + 3.0 * (t / (7.0 + channel as f32)).sin() + 0.01 * (t * 0.7).cos()
}

fn numbers(t: usize) -> String {
    (0..CHANNELS).map(|channel| value(t, channel).to_string()).collect::<Vec<_>>().join(",")
}

fn lines(readings: std::ops::Range<usize>) -> String {
    readings.map(|t| numbers(t) + "\n").collect()
}

#[test]
fn piped_lines_are_answered_whatever_they_are_written_in() {
    let output = piped(&["--hop", "10"], &lines(0..85));
    assert_eq!(lasts(&output), [49, 59, 69, 79]);
    let first = &decisions(&output)[0];
    let keys: Vec<&String> = first.as_object().unwrap().keys().collect();
    let want =
        ["time", "reading", "class", "probabilities", "latency_ms", "seen", "dead", "stuck", "saturated"];
    assert_eq!(keys, want);
    let probabilities = first["probabilities"].as_object().unwrap();
    let of = |class: &str| probabilities[class].as_f64().unwrap();
    let best = probabilities.keys().max_by(|a, b| of(a).total_cmp(&of(b))).unwrap();
    assert_eq!(first["class"], best.as_str());
    assert!((probabilities.keys().map(|class| of(class)).sum::<f64>() - 1.0).abs() < 1e-5);
    assert!(first["latency_ms"].as_f64().unwrap() > 0.0 && first["seen"] == 1.0);
    let summary = summary(&output);
    assert_eq!(
        (&summary["readings"], &summary["decisions"], &summary["ended"]),
        (&85.into(), &4.into(), &"input".into())
    );
    assert_eq!(summary["lines"], 85);
    // The same readings as JSON, and with a header: the same answers.
    let answers = |output: &Output| {
        decisions(output).iter().map(|decision| decision["probabilities"].clone()).collect::<Vec<_>>()
    };
    let want = answers(&output);
    let arrays: String = (0..85).map(|t| format!("[{}]\n", numbers(t))).collect();
    assert_eq!(answers(&piped(&["--hop", "10"], &arrays)), want);
    let header: String = (0..85).map(|t| format!("{},{}\n", 10 * t, numbers(t))).collect();
    let output = piped(&["--hop", "10"], &format!("time_ms,a,b,c,d,e\n{header}"));
    assert_eq!(answers(&output), want);
    assert_eq!(decisions(&output)[1]["time"], 0.59);
    let output = piped(&["--hop", "10", "--time", "1", "--clock", "ms"], &header);
    assert_eq!((answers(&output), &decisions(&output)[1]["time"]), (want, &0.59.into()));
}

#[test]
fn lines_that_are_no_readings_are_skipped_counted_and_said_once() {
    let mut all = lines(0..30);
    let long = "9".repeat(70_000);
    for broken in ["1,2,x,4,5", "", "garbage", "1,2,3,4", "1,2,3,4,5,6", "1,2,NaN,4,5", "{\"a\":", &long] {
        all += &format!("{broken}\n");
    }
    all += &lines(30..60);
    let mut bytes = all.into_bytes();
    bytes.extend(b"\xff\xfe,1\n");
    let mut child = stream(&["--hop", "5"]).spawn().unwrap();
    child.stdin.take().unwrap().write_all(&bytes).unwrap();
    let output = child.wait_with_output().unwrap();
    assert_eq!(lasts(&output), [49, 54, 59]);
    let summary = summary(&output);
    let want = serde_json::json!({"malformed": 4, "columns": 2, "not_finite": 1, "too_long": 1});
    assert_eq!(summary["skipped"], want, "{}", said(&output));
    assert_eq!((&summary["lines"], &summary["readings"]), (&69.into(), &60.into()));
    let warnings: Vec<String> =
        said(&output).lines().filter(|line| line.starts_with("warning")).map(Into::into).collect();
    assert_eq!(warnings.len(), 4, "{warnings:?}");
    assert!(warnings[0].contains("line 31: column 3: \"x\" is no number; skipped"), "{warnings:?}");
    assert!(warnings[1].contains("line 34: it has 4 numbers, a reading of the model has 5"), "{warnings:?}");
}

#[test]
fn a_stream_without_a_reading_is_refused_with_the_way_out() {
    for (arguments, lines, part) in [
        (&[][..], "", "standard input: nothing came; a line is a reading of 5 numbers"),
        (&[], "0.1,1,2,3,4,5\n0.2,1,2,3,4,5\n", "say --time 1"),
        (&[], "a\nb\n", "nothing in 2 lines is a reading"),
        (&["--hop", "0"], "", "hop 0"),
        (&["--early", "2"], "", "early 2"),
        (&["--input", "/no/such.csv"], "", "/no/such.csv"),
        (&["--input", "/no/such.npz"], "", "/no/such.npz"),
        (&["--serial", "/no/such/port"], "", "/no/such/port: the serial port cannot be opened"),
    ] {
        let mut child = stream(arguments).spawn().unwrap();
        // The process may have ended before it reads.
        let _ = child.stdin.take().unwrap().write_all(lines.as_bytes());
        let output = child.wait_with_output().unwrap();
        let error = said(&output);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {error}");
        let last = error.lines().last().unwrap();
        assert!(last.starts_with("error: ") && last.contains(part), "{arguments:?}: {error}");
    }
}

/// Stamped readings at 100 Hz.
fn stamped(readings: std::ops::Range<usize>, offset: f64) -> String {
    readings.map(|t| format!("{:.3},{}\n", t as f64 / 100.0 + offset, numbers(t))).collect()
}

#[test]
fn gaps_and_clocks_that_are_set_are_counted_and_long_ones_begin_a_window_anew() {
    // 10 readings missing: the window goes on. 30 missing: it begins anew.
    let all = stamped(0..40, 0.0) + &stamped(50..100, 0.0) + &stamped(130..190, 0.0);
    let output = piped(&["--time", "1", "--hop", "20"], &all);
    let summary_of_gaps = summary(&output);
    assert_eq!((&summary_of_gaps["gaps"], &summary_of_gaps["missing_readings"]), (&2.into(), &40.into()));
    assert_eq!(
        (&summary_of_gaps["windows_begun_anew"], &summary_of_gaps["clock_jumps"]),
        (&1.into(), &0.into())
    );
    assert_eq!(lasts(&output), [49, 69, 89, 139]);
    assert!(said(&output).contains("a gap: 10 readings are missing"), "{}", said(&output));
    assert_eq!(decisions(&output)[0]["time"], 0.59, "the stream's own stamp");
    // An hour ahead, and a little back.
    let all = stamped(0..40, 0.0) + &stamped(40..95, 3600.0) + &stamped(95..110, 3599.9);
    let output = piped(&["--time", "1", "--hop", "20"], &all);
    let summary = summary(&output);
    assert_eq!(
        (&summary["clock_jumps"], &summary["gaps"], &summary["windows_begun_anew"]),
        (&2.into(), &0.into(), &1.into())
    );
    assert_eq!(lasts(&output), [89, 109]);
    assert!(
        said(&output).contains("the clock jumps by 3600.010 s; the window begins anew"),
        "{}",
        said(&output)
    );
}

#[test]
fn another_rate_than_the_models_is_said() {
    let slow: String = (0..60).map(|t| format!("{},{}\n", t, numbers(t))).collect();
    let output = piped(&["--time", "1"], &slow);
    assert_eq!(summary(&output)["gaps"], 0);
    assert!(
        said(&output).contains("readings come at 1.0 Hz, the model has learned them at"),
        "{}",
        said(&output)
    );
}

/// A stream that goes on: readings are written as they are asked for.
struct Live {
    child: Child,
    from: BufReader<std::process::ChildStdout>,
}

impl Live {
    /// Begins, and has given the first decision.
    fn begin(arguments: &[&str]) -> Self {
        let mut child = stream(arguments).spawn().unwrap();
        child.stdin.as_mut().unwrap().write_all(lines(0..TICKS).as_bytes()).unwrap();
        let from = BufReader::new(child.stdout.take().unwrap());
        let mut live = Live { child, from };
        // Not held back until more comes.
        assert_eq!(live.decision()["reading"], 49);
        live
    }

    fn decision(&mut self) -> Value {
        let mut line = String::new();
        self.from.read_line(&mut line).unwrap();
        serde_json::from_str(&line).unwrap()
    }
}

#[test]
fn signals_end_a_stream_with_its_summary() {
    for signal in ["TERM", "INT"] {
        let mut live = Live::begin(&[]);
        let _open = live.child.stdin.take();
        let id = live.child.id().to_string();
        assert!(Command::new("kill").args([format!("-{signal}"), id]).status().unwrap().success());
        let summary = summary(&live.child.wait_with_output().unwrap());
        assert_eq!((&summary["ended"], &summary["decisions"]), (&"signal".into(), &1.into()), "{signal}");
    }
}

/// Nobody reads its output, so that no decision can be written; a supervisor would have to kill it.
#[test]
fn a_signal_ends_a_stream_that_waits_for_its_reader() {
    let mut child = stream(&["--hop", "1"]).spawn().unwrap();
    let mut to = child.stdin.take().unwrap();
    let writer = std::thread::spawn(move || to.write_all(lines(0..20_000).as_bytes()));
    let begun = std::time::Instant::now();
    while begun.elapsed() < std::time::Duration::from_secs(3) {
        assert!(child.try_wait().unwrap().is_none(), "it does not wait");
        std::thread::sleep(std::time::Duration::from_millis(50));
    }
    Command::new("kill").args(["-TERM", &child.id().to_string()]).status().unwrap();
    let told = std::time::Instant::now();
    let status = loop {
        if let Some(status) = child.try_wait().unwrap() {
            break status;
        }
        assert!(told.elapsed() < std::time::Duration::from_secs(20), "the signal was not heard");
        std::thread::sleep(std::time::Duration::from_millis(50));
    };
    assert_eq!(status.code(), Some(130));
    assert!(writer.join().unwrap().is_err(), "all lines were taken");
}

#[test]
fn a_closed_output_ends_a_stream_with_its_summary() {
    let Live { mut child, from } = Live::begin(&["--hop", "1"]);
    drop(from);
    let mut to = child.stdin.take().unwrap();
    // Until nobody reads any more.
    let more = lines(0..100);
    while to.write_all(more.as_bytes()).is_ok() && child.try_wait().unwrap().is_none() {}
    let summary = summary(&child.wait_with_output().unwrap());
    assert_eq!(summary["ended"], "output");
}

#[test]
fn nothing_is_lost_from_standard_input_while_nobody_reads() {
    let readings = 6000;
    let mut child = stream(&["--hop", "1"]).spawn().unwrap();
    let mut to = child.stdin.take().unwrap();
    // More than pipes and queue hold: the writer must wait until the decisions are read.
    let writer = std::thread::spawn(move || to.write_all(lines(0..readings).as_bytes()).unwrap());
    let mut error = child.stderr.take().unwrap();
    let errors = std::thread::spawn(move || {
        let mut text = String::new();
        error.read_to_string(&mut text).unwrap();
        text
    });
    std::thread::sleep(std::time::Duration::from_millis(300));
    let mut output = child.wait_with_output().unwrap();
    writer.join().unwrap();
    output.stderr = errors.join().unwrap().into_bytes();
    assert_eq!(lasts(&output), (TICKS as u64 - 1..readings as u64).collect::<Vec<_>>());
    assert_eq!(summary(&output)["dropped"], 0);
}

/// Two recordings of 130 readings.
fn recordings(folder: &Path) -> PathBuf {
    let path = folder.join("long.npz");
    let (count, length) = (2, 130);
    let at = |i: usize| value(i / (CHANNELS * length) * 1000 + i % length, i / length % CHANNELS);
    let x: Vec<f32> = (0..count * CHANNELS * length).map(at).collect();
    let mut npz = taxel_data::Npz::default();
    npz.add("x", &[count, CHANNELS, length], &x).unwrap();
    fs::write(&path, npz.finish().unwrap()).unwrap();
    path
}

/// Probabilities of an answer as bits.
fn bits(answer: &Value) -> Vec<u32> {
    let probabilities = answer["probabilities"].as_object().unwrap();
    probabilities.values().map(|p| (p.as_f64().unwrap() as f32).to_bits()).collect()
}

#[test]
fn replayed_recordings_get_the_answers_of_predict_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    let file = recordings(folder.path());
    let length = format!("window:{TICKS},7");
    let output = taxel(&["predict", text(&MODEL.1), text(&file), "--length", &length, "--format", "json"]);
    let all: Value = serde_json::from_slice(&{ output }.output().unwrap().stdout).unwrap();
    let want = all["answers"].as_array().unwrap();
    assert_eq!(want.len(), 2 * 12);
    for more in [&[][..], &["--pace", "rate", "--rate", "2000"]] {
        let output =
            taxel(&[&["stream", text(&MODEL.1), "--input", text(&file), "--hop", "7"], more].concat());
        let output = { output }.output().unwrap();
        let made = decisions(&output);
        assert_eq!(made.len(), want.len(), "{}", said(&output));
        for (decision, want) in made.iter().zip(want) {
            assert_eq!(decision["recording"], want["sample"]);
            assert_eq!(
                decision["reading"].as_u64().unwrap() + 1 - TICKS as u64,
                want["start"].as_u64().unwrap()
            );
            assert_eq!(bits(decision), bits(want));
            assert_eq!(decision["class"], want["predicted"]["class"]);
        }
        let rate = if more.is_empty() { 100.0 } else { 2000.0 };
        for decision in &made {
            let (time, reading) = (decision["time"].as_f64().unwrap(), decision["reading"].as_f64().unwrap());
            assert!((time - reading / rate).abs() < 1e-9, "{decision}");
        }
        assert_eq!(summary(&output)["dropped"], 0);
    }
}

#[test]
fn a_csv_is_replayed_and_may_be_decided_early() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("press.csv");
    fs::write(&file, lines(0..100)).unwrap();
    let input = ["--input", text(&file), "--hop", "50"];
    let whole = stream(&input).output().unwrap();
    assert_eq!(lasts(&whole), [49, 99]);
    let early = stream(&[&input[..], &["--early", "0.01"]].concat()).output().unwrap();
    let made = decisions(&early);
    assert_eq!((lasts(&early), &made[0]["seen"]), (vec![4, 54], &0.1.into()));
    assert_eq!(summary(&early)["early"], 2);
    // What was not there was filled up as predict does it with a rule of the same kind.
    let start = folder.path().join("start.csv");
    fs::write(&start, lines(0..5)).unwrap();
    for (pad, rule) in [("zero", "pad:50"), ("edge", "pad:50,edge")] {
        let output = taxel(&["predict", text(&MODEL.1), text(&start), "--length", rule, "--format", "json"]);
        let all: Value = serde_json::from_slice(&{ output }.output().unwrap().stdout).unwrap();
        let early = stream(&[&input[..], &["--early", "0.01", "--pad", pad]].concat()).output().unwrap();
        assert_eq!(bits(&decisions(&early)[0]), bits(&all["answers"][0]), "{pad}");
    }
    let late = stream(&[&input[..], &["--early", "0.01", "--least", "20"]].concat()).output().unwrap();
    assert_eq!(lasts(&late), [19, 69]);
    let never = stream(&[&input[..], &["--early", "1"]].concat()).output().unwrap();
    assert_eq!((lasts(&never), summary(&never)["early"].as_u64()), (vec![49, 99], Some(0)));
}

#[test]
fn contact_starts_windows_and_what_is_wrong_is_said_beside_them() {
    let level = |t: usize| if (100..160).contains(&t) { 8.0 } else { 0.0 };
    // The last channel is dead, the one before it stuck at full scale from 90 on.
    let all: String = (0..220)
        .map(|t| {
            let flicker = (t % 2) as f32 * 0.01;
            let full = if t < 90 { flicker } else { 20.0 };
            format!("{},{},{},{full},0\n", level(t) + flicker, flicker, level(t))
        })
        .collect();
    let output = piped(&["--contact", "--before", "5", "--full-scale", "20", "--hop", "50"], &all);
    // The channel at full scale holds contact from 90 to the end; the window begins five readings before it.
    assert_eq!(lasts(&output), [134, 184]);
    assert_eq!(summary(&output)["contacts"], 1);
    let last = &decisions(&output)[1];
    assert_eq!((&last["dead"], &last["stuck"], &last["saturated"]), (&[4].into(), &[3].into(), &[3].into()));
}

#[test]
fn a_serial_port_is_read_until_it_is_stopped() {
    use serialport::{SerialPort, TTYPort};
    let (mut master, slave) = TTYPort::pair().unwrap();
    let port = slave.name().unwrap();
    // Whoever opened it keeps others out.
    drop(slave);
    let mut child = stream(&["--serial", &port, "--hop", "25"]).spawn().unwrap();
    let mut from = BufReader::new(child.stdout.take().unwrap());
    // As a device does: whether somebody listens or not.
    let stop = std::sync::Arc::new(std::sync::atomic::AtomicBool::new(false));
    let stopped = std::sync::Arc::clone(&stop);
    let device = std::thread::spawn(move || {
        for t in 0.. {
            if stopped.load(std::sync::atomic::Ordering::Relaxed) {
                break;
            }
            // The terminal's buffer may be full before anybody listens.
            let _ = master.write_all((numbers(t) + "\r\n").as_bytes());
            std::thread::sleep(std::time::Duration::from_millis(1));
        }
        master
    });
    for want in [49, 74] {
        let mut line = String::new();
        if from.read_line(&mut line).unwrap() == 0 {
            panic!("{}", said(&child.wait_with_output().unwrap()));
        }
        let decision: Value = serde_json::from_str(&line).unwrap();
        assert_eq!(decision["reading"], want);
    }
    assert!(Command::new("kill").arg(child.id().to_string()).status().unwrap().success());
    let summary = summary(&child.wait_with_output().unwrap());
    assert_eq!((&summary["ended"], &summary["dropped"]), (&"signal".into(), &0.into()));
    stop.store(true, std::sync::atomic::Ordering::Relaxed);
    drop(device.join().unwrap());
}

#[test]
fn a_header_that_changes_ends_the_stream_and_names_both() {
    let all = format!("a,b,c,d,e\n{}b,a,c,d,e\n{}", lines(0..60), lines(60..90));
    let output = piped(&["--hop", "10"], &all);
    assert_eq!(output.status.code(), Some(2), "{}", said(&output));
    assert_eq!(lasts(&output), [49, 59], "what came before is answered");
    let last = said(&output).lines().last().unwrap_or_default().to_string();
    let want = "line 62: the names of the columns change: expected a, b, c, d, e, as before, and found b, a, c, d, e";
    assert!(last.starts_with("error: standard input: ") && last.contains(want), "{last}");
    let more = format!("a,b,c,d,e\n{}a,b,c,d,e,f\n{}", lines(0..60), lines(60..90));
    assert_eq!(piped(&[], &more).status.code(), Some(2));
    // A device that starts again sends the same header, and messages are no header.
    let again = format!("a,b,c,d,e\n{}OVERFLOW\na,b,c,d,e\n{}", lines(0..60), lines(60..90));
    assert_eq!(summary(&piped(&[], &again))["readings"], 90);
}

/// Fits a model to recordings in class folders, whose channels have names.
fn named_model(folder: &Path) -> PathBuf {
    for (class, scale) in [("soft", 1.0), ("hard", 3.0)] {
        fs::create_dir_all(folder.join("set").join(class)).unwrap();
        for file in 0..10 {
            let line = |t: usize| format!("{},{}\n", scale * value(t + file, 0), value(t, 1 + file % 3));
            let text = format!("thumb,index\n{}", (0..TICKS).map(line).collect::<String>());
            fs::write(folder.join("set").join(class).join(format!("{file}.csv")), text).unwrap();
        }
    }
    let (config, model) = (folder.join("c.toml"), folder.join("m.safetensors"));
    fs::write(&config, CONFIG.replace("scene = \"fingertip\"\nsamples = 60", "path = \"set\"")).unwrap();
    let output = taxel(&["fit", text(&config), "--output", text(&model)]).output().unwrap();
    assert!(output.status.success(), "{}", said(&output));
    model
}

#[test]
fn sensors_are_named_where_the_model_knows_their_names() {
    let folder = tempfile::tempdir().unwrap();
    let model = named_model(folder.path());
    let press = folder.path().join("press.csv");
    let line = |t: usize| format!("0,{}\n", value(t, 0));
    fs::write(&press, format!("index,thumb\n{}", (0..TICKS).map(line).collect::<String>())).unwrap();
    let output = taxel(&["stream", text(&model), "--input", text(&press)]).output().unwrap();
    assert_eq!(decisions(&output)[0]["dead"], serde_json::json!(["index"]), "{}", said(&output));
    let inspected = taxel(&["inspect", text(&model)]).output().unwrap();
    let card = String::from_utf8(inspected.stdout).unwrap();
    assert!(card.contains("channels     thumb, index"), "{card}");
}
