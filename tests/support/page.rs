//! A stand-in for a browser that looks at a live page.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, Command};
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

use serde_json::Value;

/// A command that serves a page.
pub struct Served {
    child: Child,
    /// Where the page is: address and port.
    pub host: String,
    said: Receiver<String>,
}

impl Served {
    /// Starts a command, and waits until it says where its page is.
    pub fn of(command: &mut Command) -> Self {
        let mut child = command.spawn().unwrap();
        let errors = BufReader::new(child.stderr.take().unwrap());
        let (send, said) = channel();
        std::thread::spawn(move || errors.lines().map_while(Result::ok).try_for_each(|line| send.send(line)));
        let mut served = Served { child, host: String::new(), said };
        let mut heard = String::new();
        while served.host.is_empty() {
            let Ok(line) = served.said.recv_timeout(Duration::from_secs(60)) else {
                panic!("no page: {heard}")
            };
            if let Some(rest) = line.strip_prefix("live page: http://") {
                served.host = rest.trim_end_matches('/').into();
            }
            heard += &(line + "\n");
        }
        served
    }

    /// Reads what it prints to the end.
    #[allow(dead_code, reason = "not every test reads it")]
    pub fn out(&mut self) -> String {
        let mut out = String::new();
        self.child.stdout.take().unwrap().read_to_string(&mut out).unwrap();
        out
    }

    /// Waits for its end, with this exit code; returns its messages.
    #[allow(dead_code, reason = "not every test waits for it")]
    pub fn ends(mut self, code: i32) -> String {
        let found = self.child.wait().unwrap().code();
        let said: Vec<String> = self.said.iter().collect();
        assert_eq!(found, Some(code), "{}", said.join("\n"));
        said.join("\n")
    }

    /// Stops it.
    #[allow(dead_code, reason = "not every test stops it")]
    pub fn stop(mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Returns the whole answer to a request.
pub fn get(host: &str, path: &str) -> String {
    let mut stream = TcpStream::connect(host).unwrap();
    write!(stream, "GET {path} HTTP/1.1\r\nHost: {host}\r\n\r\n").unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    answer
}

/// Reads events until `is_enough`, or the end.
pub fn events(host: &str, is_enough: impl Fn(&[(String, Value)]) -> bool) -> Vec<(String, Value)> {
    let mut stream = TcpStream::connect(host).unwrap();
    stream.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
    write!(stream, "GET /events HTTP/1.1\r\nHost: {host}\r\n\r\n").unwrap();
    let (mut seen, mut name) = (vec![], String::new());
    for line in BufReader::new(stream).lines() {
        let Ok(line) = line else { break };
        if let Some(event) = line.strip_prefix("event: ") {
            name = event.into();
        } else if let Some(data) = line.strip_prefix("data: ") {
            seen.push((name.clone(), serde_json::from_str(data).unwrap()));
            if is_enough(&seen) {
                break;
            }
        }
    }
    seen
}
