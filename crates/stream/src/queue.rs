//! The bounded queue between the thread that reads and the one that answers.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, TryRecvError, TrySendError, sync_channel};
use std::time::{Duration, Instant};

use crate::error::Result;

/// Bytes of readings that may wait.
const BYTES: usize = 4 << 20;
/// The least and the most readings that may wait.
const WAITING: (usize, usize) = (16, 1024);

/// A reading that has come.
#[derive(Debug)]
pub struct Arrival {
    /// Its values; give them back with [`Stream::give_back`].
    pub values: Vec<f32>,
    /// Its own time stamp, in seconds.
    pub stamp: Option<f64>,
    /// When it came.
    pub at: Instant,
    /// Readings before it that found no room.
    pub lost: u64,
}

/// What a stream brings next.
#[derive(Debug)]
pub enum Next {
    /// A reading.
    Reading(Arrival),
    /// Another recording begins; its name.
    Begin(String),
    /// Nothing comes any more, or the source has broken off.
    End(Result<()>),
    /// Nothing came in the time given.
    Quiet,
}

/// What has been counted of a stream, as it goes on.
#[derive(Debug, Default)]
pub struct Counts {
    readings: AtomicU64,
    lines: AtomicU64,
    malformed: AtomicU64,
    columns: AtomicU64,
    not_finite: AtomicU64,
    too_long: AtomicU64,
    dropped: AtomicU64,
}

/// What has been counted of a stream.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counted {
    /// Readings that came, those dropped included.
    pub readings: u64,
    /// Lines that came, blank ones and names of columns included; 0 where recordings are replayed.
    pub lines: u64,
    /// Lines that are no numbers.
    pub malformed: u64,
    /// Lines of more or fewer numbers than a reading has.
    pub columns: u64,
    /// Readings with a value that is not finite.
    pub not_finite: u64,
    /// Lines that are longer than any reading.
    pub too_long: u64,
    /// Readings that found no room in the queue.
    pub dropped: u64,
}

impl Counts {
    pub(crate) fn line(&self) {
        self.lines.fetch_add(1, Ordering::Relaxed);
    }

    /// Counts a line that is no reading; whether it is the first of its kind.
    pub(crate) fn skip(&self, kind: Skip) -> bool {
        let of = match kind {
            Skip::Malformed => &self.malformed,
            Skip::Columns => &self.columns,
            Skip::NotFinite => &self.not_finite,
            Skip::TooLong => &self.too_long,
        };
        of.fetch_add(1, Ordering::Relaxed) == 0
    }

    /// The numbers as they are now.
    pub fn now(&self) -> Counted {
        let of = |count: &AtomicU64| count.load(Ordering::Relaxed);
        Counted {
            readings: of(&self.readings),
            lines: of(&self.lines),
            malformed: of(&self.malformed),
            columns: of(&self.columns),
            not_finite: of(&self.not_finite),
            too_long: of(&self.too_long),
            dropped: of(&self.dropped),
        }
    }
}

/// Why a line is no reading.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Skip {
    Malformed,
    Columns,
    NotFinite,
    TooLong,
}

enum Message {
    Reading(Arrival),
    Begin(String),
    End(Result<()>),
}

/// The end of the queue that is answered.
pub struct Stream {
    from: Receiver<Message>,
    spare: SyncSender<Vec<f32>>,
    counts: Arc<Counts>,
}

/// The end of the queue that is filled.
pub(crate) struct Feed {
    to: SyncSender<Message>,
    spare: Receiver<Vec<f32>>,
    pub counts: Arc<Counts>,
    /// Whether a reading without room is dropped; it waits otherwise.
    drops: bool,
    lost: u64,
}

/// Nobody answers any more.
pub(crate) struct Closed;

/// A queue for readings of `each` values.
pub(crate) fn queue(each: usize, drops: bool) -> (Feed, Stream) {
    let room = (BYTES / (4 * each.max(1))).clamp(WAITING.0, WAITING.1);
    let (to, from) = sync_channel(room);
    let (back, spare) = sync_channel(room + 2);
    let counts = Arc::new(Counts::default());
    let feed = Feed { to, spare, counts: Arc::clone(&counts), drops, lost: 0 };
    (feed, Stream { from, spare: back, counts })
}

impl Feed {
    /// Hands a reading on: waits for room, or drops it.
    pub fn reading(
        &mut self,
        values: &[f32],
        stamp: Option<f64>,
        at: Instant,
    ) -> std::result::Result<(), Closed> {
        self.counts.readings.fetch_add(1, Ordering::Relaxed);
        let mut own = self.spare.try_recv().unwrap_or_default();
        own.clear();
        own.extend_from_slice(values);
        let message = Message::Reading(Arrival { values: own, stamp, at, lost: self.lost });
        if !self.drops {
            return self.to.send(message).map_err(|_| Closed);
        }
        match self.to.try_send(message) {
            Ok(()) => self.lost = 0,
            Err(TrySendError::Full(_)) => {
                self.lost += 1;
                self.counts.dropped.fetch_add(1, Ordering::Relaxed);
            }
            Err(TrySendError::Disconnected(_)) => return Err(Closed),
        }
        Ok(())
    }

    pub fn begin(&self, name: &str) -> std::result::Result<(), Closed> {
        self.to.send(Message::Begin(name.into())).map_err(|_| Closed)
    }

    pub fn end(self, how: Result<()>) {
        // Nobody may be there to hear it.
        let _ = self.to.send(Message::End(how));
    }
}

impl Stream {
    /// What has been counted so far.
    pub fn counted(&self) -> Counted {
        self.counts.now()
    }

    /// What is there already.
    pub fn waiting(&self) -> Next {
        match self.from.try_recv() {
            Ok(message) => message.into(),
            Err(TryRecvError::Empty) => Next::Quiet,
            Err(TryRecvError::Disconnected) => Next::End(Ok(())),
        }
    }

    /// What comes within `wait`.
    pub fn next(&self, wait: Duration) -> Next {
        match self.from.recv_timeout(wait) {
            Ok(message) => message.into(),
            Err(RecvTimeoutError::Timeout) => Next::Quiet,
            Err(RecvTimeoutError::Disconnected) => Next::End(Ok(())),
        }
    }

    /// The memory of a reading, for another one.
    pub fn give_back(&self, values: Vec<f32>) {
        let _ = self.spare.try_send(values);
    }
}

impl From<Message> for Next {
    fn from(message: Message) -> Self {
        match message {
            Message::Reading(arrival) => Next::Reading(arrival),
            Message::Begin(name) => Next::Begin(name),
            Message::End(how) => Next::End(how),
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn next(stream: &Stream) -> (f32, u64) {
        match stream.waiting() {
            Next::Reading(Arrival { values, lost, .. }) => {
                let first = values[0];
                stream.give_back(values);
                (first, lost)
            }
            other => unreachable!("{other:?}"),
        }
    }

    #[test]
    fn what_finds_no_room_is_counted_where_it_comes_anyway() {
        // As many as fit, and three more.
        let (mut feed, stream) = queue(BYTES, true);
        for value in 0..WAITING.0 + 3 {
            assert!(feed.reading(&[value as f32], None, Instant::now()).is_ok());
        }
        assert_eq!((stream.counted().readings, stream.counted().dropped), (WAITING.0 as u64 + 3, 3));
        assert_eq!(next(&stream), (0.0, 0));
        assert!(feed.reading(&[99.0], None, Instant::now()).is_ok());
        (1..WAITING.0).for_each(|value| assert_eq!(next(&stream), (value as f32, 0)));
        assert_eq!(next(&stream), (99.0, 3), "three were lost before it");
        assert!(feed.reading(&[100.0], None, Instant::now()).is_ok());
        assert_eq!(next(&stream), (100.0, 0), "and none before this one");
        drop(stream);
        assert!(feed.reading(&[0.0], None, Instant::now()).is_err());
    }

    #[test]
    fn what_may_wait_waits() {
        let (mut feed, stream) = queue(BYTES, false);
        let many = 10 * WAITING.0;
        let filler = std::thread::spawn(move || {
            for value in 0..many {
                assert!(feed.reading(&[value as f32], None, Instant::now()).is_ok());
            }
            feed.end(Ok(()));
        });
        let mut seen = 0;
        loop {
            match stream.next(Duration::from_secs(60)) {
                Next::Reading(arrival) => {
                    assert_eq!((arrival.values[0], arrival.lost), (seen as f32, 0));
                    seen += 1;
                }
                Next::End(how) => break how.unwrap(),
                other => unreachable!("{other:?}"),
            }
        }
        filler.join().unwrap();
        assert_eq!((seen, stream.counted().dropped), (many, 0));
    }
}
