//! The live page as a browser sees it, and what a browser must not do to a stream.

#![cfg(unix)]
#![allow(clippy::unwrap_used, clippy::panic)]

#[path = "support/page.rs"]
mod page;

use std::fs;
use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::LazyLock;
use std::time::Duration;

use page::{Served, events, get};
use serde_json::Value;
use tempfile::TempDir;

const CONFIG: &str = r#"
name = "live"
[data]
scene = "fingertip"
samples = 60
rate = 1000.0
[train]
epochs = 2
batch_size = 16
[[networks]]
name = "resnet8-lite-1d"
"#;

static MODEL: LazyLock<(TempDir, PathBuf)> = LazyLock::new(|| {
    let folder = tempfile::tempdir().unwrap();
    let (config, model) = (folder.path().join("c.toml"), folder.path().join("m.safetensors"));
    fs::write(&config, CONFIG).unwrap();
    let output = taxel(&["fit", text(&config), "--output", text(&model)]).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    (folder, model)
});

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

fn taxel(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_taxel"));
    command.args(arguments).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

/// A file of so many readings at 1 kHz.
fn readings(folder: &TempDir, count: usize) -> PathBuf {
    let value = |t: usize, channel: usize| 4.0 + 3.0 * (t as f32 / (7.0 + channel as f32)).sin();
    let line = |t: usize| {
        let values: Vec<String> = (0..5).map(|channel| value(t, channel).to_string()).collect();
        format!("{},{}\n", 1e-3 * t as f64, values.join(","))
    };
    let path = folder.path().join("press.csv");
    fs::write(&path, format!("time,a,b,c,d,e\n{}", (0..count).map(line).collect::<String>())).unwrap();
    path
}

fn served(arguments: &[&str]) -> Served {
    let all = [&["stream", text(&MODEL.1), "--serve", "127.0.0.1:0"], arguments].concat();
    Served::of(taxel(&all).stdin(Stdio::piped()))
}

fn summary(said: &str) -> Value {
    let last: Value = serde_json::from_str(said.lines().last().unwrap()).unwrap();
    last["summary"].clone()
}

#[test]
fn browsers_that_do_not_read_lose_no_reading() {
    let folder = tempfile::tempdir().unwrap();
    let path = readings(&folder, 3000);
    let mut served = served(&["--input", text(&path), "--pace", "rate", "--hop", "10"]);
    // One reads, ten do not, and three go away at once.
    let host = served.host.clone();
    let reader = std::thread::spawn(move || events(&host, |all| all.iter().any(|(name, _)| name == "end")));
    let ask = || {
        let mut stream = TcpStream::connect(&served.host).unwrap();
        write!(stream, "GET /events HTTP/1.1\r\nHost: {}\r\n\r\n", served.host).unwrap();
        stream
    };
    let blocked: Vec<TcpStream> = (0..10).map(|_| ask()).collect();
    (0..3).for_each(|_| drop(ask()));
    let decisions = served.out();
    let said = served.ends(0);
    let summary = summary(&said);
    assert_eq!((&summary["readings"], &summary["dropped"]), (&3000.into(), &0.into()), "{summary}");
    assert_eq!(decisions.lines().count(), 296);
    drop(blocked);
    let seen = reader.join().unwrap();
    let last = seen.iter().rfind(|(name, _)| name == "readings").map(|(_, data)| data["readings"].clone());
    assert!(last.as_ref().and_then(Value::as_u64).is_some_and(|count| count > 2500), "{last:?}");
    let of = |wanted: &str| seen.iter().filter(|(name, _)| name == wanted).count();
    assert!(
        of("readings") > 20 && of("decision") > 20 && of("facts") == 1,
        "{} {}",
        of("readings"),
        of("decision")
    );
}

#[test]
fn events_say_what_the_output_says() {
    let folder = tempfile::tempdir().unwrap();
    let path = readings(&folder, 1000);
    let mut served = served(&["--input", text(&path), "--pace", "rate", "--hop", "50"]);
    let seen = events(&served.host, |all| all.iter().any(|(name, _)| name == "end"));
    let lines: Vec<Value> = served.out().lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    served.ends(0);
    let decided: Vec<&Value> =
        seen.iter().filter(|(name, _)| name == "decision").map(|(_, data)| data).collect();
    assert!(
        decided.len() > 5 && decided.iter().all(|decision| lines.contains(decision)),
        "{}",
        decided.len()
    );
    let facts = &seen.iter().find(|(name, _)| name == "facts").unwrap().1;
    assert_eq!((&facts["title"], &facts["rate"]), (&"resnet8-lite-1d".into(), &1000.0.into()));
    assert_eq!(seen.last().unwrap().1["why"], "input");
    let frame = &seen.iter().find(|(name, _)| name == "readings").unwrap().1;
    assert_eq!(frame["low"].as_array().unwrap().len(), 5);
}

#[test]
fn only_this_page_is_answered_and_only_to_its_own_name() {
    let served = served(&[]);
    let host = served.host.clone();
    let status = |request: &str| {
        let mut stream = TcpStream::connect(&host).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(30))).unwrap();
        stream.write_all(request.as_bytes()).unwrap();
        let mut answer = String::new();
        let _ = stream.read_to_string(&mut answer);
        answer
    };
    let page = get(&host, "/");
    assert!(page.starts_with("HTTP/1.1 200 OK") && page.contains("<!doctype html>"), "{page:.200}");
    assert!(page.contains("default-src 'none'") && page.ends_with("</html>\n"));
    for (request, wanted) in [
        ("GET / HTTP/1.1\r\nHost: evil.example\r\n\r\n", "421"),
        ("GET /events HTTP/1.1\r\nHost: 127.0.0.1.evil.example:8000\r\n\r\n", "421"),
        ("GET / HTTP/1.1\r\n\r\n", "421"),
        ("POST / HTTP/1.1\r\nHost: localhost\r\n\r\n", "405"),
        ("GET /../../etc/passwd HTTP/1.1\r\nHost: localhost\r\n\r\n", "404"),
        ("nonsense\r\n\r\n", "400"),
    ] {
        let answer = status(request);
        assert!(answer.starts_with(&format!("HTTP/1.1 {wanted} ")), "{request:?}: {answer:.80}");
        assert!(!answer.contains("Access-Control"), "{answer}");
    }
    served.stop();
}

#[test]
fn addresses_that_others_reach_have_to_be_asked_for() {
    let run = |arguments: &[&str]| {
        let output = taxel(&[&["stream", text(&MODEL.1)], arguments].concat()).output().unwrap();
        (output.status.code(), String::from_utf8(output.stderr).unwrap())
    };
    let (code, said) = run(&["--serve", "0.0.0.0:0"]);
    assert!(code == Some(2) && said.contains("--serve-anywhere"), "{said}");
    let (code, said) = run(&["--serve-anywhere"]);
    assert!(code == Some(2) && said.contains("--serve"), "{said}");
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let address = taken.local_addr().unwrap().to_string();
    let (code, said) = run(&["--serve", &address]);
    assert!(code == Some(2) && said.contains("say another port"), "{said}");
    let child: Child =
        taxel(&["stream", text(&MODEL.1), "--serve", "0.0.0.0:0", "--serve-anywhere"]).spawn().unwrap();
    let output = child.wait_with_output().unwrap();
    assert!(String::from_utf8_lossy(&output.stderr).contains("whoever reaches this machine sees the page"));
}
