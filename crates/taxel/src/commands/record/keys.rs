//! Keys of a person who records: lines on the terminal, so that no mode of it has to be put back.

use std::io::BufRead;
use std::sync::mpsc::{Receiver, TryRecvError, channel};

/// A wish of a person.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Wish {
    /// Enter: begin the recording.
    Start,
    /// `u`: throw the last one away.
    Undo,
    /// `s`: begin another session.
    Session,
    /// `q`, or the end of the input.
    Quit,
    /// The name of a label: record that one.
    Label(String),
}

/// Hears keys without waiting for them.
pub struct Keys(Receiver<String>);

/// The keys, for a person.
pub const HELP: &str =
    "Enter starts; u throws the last one away; s begins another session; q ends; or write a label";

impl Keys {
    /// Listens to standard input.
    ///
    /// # Errors
    /// A thread that cannot be started.
    pub fn listen() -> std::io::Result<Self> {
        let (to, from) = channel();
        std::thread::Builder::new().name("keys".into()).spawn(move || {
            for line in std::io::stdin().lock().lines() {
                if line.map(|line| to.send(line)).is_ok_and(|sent| sent.is_ok()) {
                    continue;
                }
                break;
            }
        })?;
        Ok(Keys(from))
    }

    /// Returns a wish that was made; `labels` are those that can be named.
    pub fn wish(&self, labels: &[String]) -> Option<Result<Wish, String>> {
        match self.0.try_recv() {
            Ok(line) => Some(parse(&line, labels)),
            Err(TryRecvError::Empty) => None,
            Err(TryRecvError::Disconnected) => Some(Ok(Wish::Quit)),
        }
    }

    /// Forgets what was written while nobody looked: an Enter too many is no start.
    pub fn forget(&self) {
        while self.0.try_recv().is_ok() {}
    }
}

fn parse(line: &str, labels: &[String]) -> Result<Wish, String> {
    // A label may be called `q`.
    let line = line.trim();
    match line {
        label if labels.iter().any(|known| known == label) => Ok(Wish::Label(label.into())),
        "" => Ok(Wish::Start),
        "u" => Ok(Wish::Undo),
        "s" => Ok(Wish::Session),
        "q" => Ok(Wish::Quit),
        other => Err(format!("{other:?} is no key and no label. {HELP}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_and_labels_are_understood() {
        let labels = ["cup".to_string(), "q".into()];
        for (line, wish) in [
            ("", Wish::Start),
            (" u ", Wish::Undo),
            ("s", Wish::Session),
            ("cup", Wish::Label("cup".into())),
            ("q", Wish::Label("q".into())),
        ] {
            assert_eq!(parse(line, &labels), Ok(wish), "{line:?}");
        }
        assert_eq!(parse("q", &labels[..1]), Ok(Wish::Quit));
        assert!(parse("cupp", &labels).is_err_and(|why| why.contains("Enter starts")));
    }
}
