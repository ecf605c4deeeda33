//! A stand-in for a person: a terminal of their own, eyes and fingers.

use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

use serialport::{SerialPort, TTYPort};

/// A person at a terminal, in which a command runs.
pub struct Person {
    child: Child,
    to: TTYPort,
    said: Receiver<String>,
    heard: String,
}

impl Person {
    /// Starts a command in a terminal.
    pub fn at(command: &mut Command) -> Self {
        let (to, slave) = TTYPort::pair().unwrap();
        let terminal = fs::OpenOptions::new().read(true).write(true).open(slave.name().unwrap()).unwrap();
        let mut child = command.stdin(Stdio::from(terminal)).spawn().unwrap();
        drop(slave);
        let errors = BufReader::new(child.stderr.take().unwrap());
        let (send, said) = channel();
        std::thread::spawn(move || errors.lines().map_while(Result::ok).try_for_each(|line| send.send(line)));
        Person { child, to, said, heard: String::new() }
    }

    /// Returns the next line that is said; none at the end.
    pub fn next(&mut self) -> Option<String> {
        let line = self.said.recv_timeout(Duration::from_secs(60)).ok()?;
        self.heard += &(line.clone() + "\n");
        Some(line)
    }

    /// Waits until these words are said; returns their line.
    #[allow(dead_code, reason = "not every test waits for words")]
    pub fn hears(&mut self, words: &str) -> String {
        loop {
            match self.next() {
                Some(line) if line.contains(words) => return line,
                Some(_) => {}
                None => panic!("{words:?} was not said:\n{}", self.heard),
            }
        }
    }

    /// Writes into the terminal.
    pub fn writes(&mut self, text: &str) {
        self.to.write_all(text.as_bytes()).unwrap();
    }

    /// Waits for the end; returns the exit code, and all that was printed and said.
    pub fn leaves(mut self) -> (i32, String) {
        let code = self.child.wait().unwrap().code().unwrap();
        let mut out = String::new();
        self.child.stdout.take().unwrap().read_to_string(&mut out).unwrap();
        while self.next().is_some() {}
        (code, self.heard + &out)
    }
}
