//! A real browser that looks at a live page.
//!
//! `chromium --dump-dom` prints a page as it is when it has loaded, which may be before the first event. So the page goes through a
//! door of this test: it adds a picture that comes only when the page has shown a decision. Until then the page has not loaded.

use std::io::{BufRead, BufReader, Write, copy};
use std::net::{TcpListener, TcpStream};
use std::process::Command;
use std::sync::{Arc, Condvar, Mutex};
use std::time::Duration;

use super::page::get;

/// Longest wait for a decision on the page.
const PATIENCE: Duration = Duration::from_secs(60);

/// Asks for the picture, and says when the decision has changed.
const ADDED: &str = r#"<img src="/held" alt=""><script>
new MutationObserver(() => fetch("/shown")).observe(document.getElementById("class"), {childList: true});
</script>"#;

/// Whether the page has shown a decision.
type Shown = Arc<(Mutex<bool>, Condvar)>;

/// Returns the page of `host` as Chromium has it after the first decision, or after a minute.
pub fn page_with_decision(host: &str) -> String {
    let door = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = door.local_addr().unwrap();
    let (host, shown) = (host.to_string(), Shown::default());
    std::thread::spawn(move || {
        for stream in door.incoming().map_while(Result::ok) {
            let (host, shown) = (host.clone(), Arc::clone(&shown));
            std::thread::spawn(move || answer(stream, &host, &shown));
        }
    });
    let home = tempfile::tempdir().unwrap();
    let output = Command::new("chromium")
        .args([
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--disable-background-networking",
            "--no-first-run",
        ])
        .arg(format!("--user-data-dir={}", home.path().display()))
        .args(["--timeout=90000", "--dump-dom", &format!("http://{address}/")])
        .output()
        .unwrap();
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// Answers a request of the browser. One that it gives up is no fault.
fn answer(mut stream: TcpStream, host: &str, shown: &Shown) {
    let mut lines = BufReader::new(stream.try_clone().unwrap()).lines().map_while(Result::ok);
    let first = lines.next().unwrap_or_default();
    lines.find(String::is_empty);
    match first.split(' ').nth(1) {
        Some("/") => {
            let page = get(host, "/");
            let body = page.split_once("\r\n\r\n").unwrap().1;
            let _ = write!(
                stream,
                "HTTP/1.1 200 OK\r\nContent-Type: text/html; charset=utf-8\r\nConnection: close\r\n\r\n{body}{ADDED}"
            );
        }
        Some("/events") => {
            let mut events = TcpStream::connect(host).unwrap();
            write!(events, "GET /events HTTP/1.1\r\nHost: {host}\r\n\r\n").unwrap();
            let _ = copy(&mut events, &mut stream);
        }
        path => {
            let (is_shown, wake) = &**shown;
            if path == Some("/shown") {
                *is_shown.lock().unwrap() = true;
                wake.notify_all();
            } else if path == Some("/held") {
                drop(wake.wait_timeout_while(is_shown.lock().unwrap(), PATIENCE, |shown| !*shown).unwrap());
            }
            let _ = write!(stream, "HTTP/1.1 204 No Content\r\nConnection: close\r\n\r\n");
        }
    }
}
