//! The bounded queue between the thread that reads and the one that predicts.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, TryRecvError, TrySendError, sync_channel};
use std::time::{Duration, Instant};

use crate::error::Result;

/// Bytes of time steps that may wait.
const BYTES: usize = 4 << 20;
/// The least and the most time steps that may wait.
const WAITING: (usize, usize) = (16, 1024);

/// A time step that has come.
#[derive(Debug)]
pub struct Arrival {
    /// Its values; give them back with [`ReadingStream::give_back`].
    pub values: Vec<f32>,
    /// Its own time stamp, in seconds.
    pub stamp: Option<f64>,
    /// When it came.
    pub at: Instant,
    /// Time steps before it that found no room.
    pub lost: u64,
    /// Lines right before it that were no time step.
    pub skipped: u64,
}

/// The next event of a stream.
#[derive(Debug)]
pub enum Next {
    /// A time step.
    Reading(Arrival),
    /// Another recording begins; its name.
    Begin(String),
    /// The sensor is at rest: the level at rest is to be taken anew.
    Tare,
    /// The source has ended, or broken off.
    End(Result<()>),
    /// Nothing came in the time given.
    Quiet,
}

/// Counters of a running stream.
#[derive(Debug, Default)]
pub struct StreamCounters {
    readings: AtomicU64,
    lines: AtomicU64,
    malformed: AtomicU64,
    columns: AtomicU64,
    not_finite: AtomicU64,
    too_long: AtomicU64,
    dropped: AtomicU64,
}

/// Counts of a stream.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct StreamCounts {
    /// Time steps that came, those dropped included.
    pub readings: u64,
    /// Lines that came, blank ones and names of columns included; 0 where recordings are replayed.
    pub lines: u64,
    /// Lines that are no numbers.
    pub malformed: u64,
    /// Lines of more or fewer numbers than a time step has.
    pub columns: u64,
    /// Time steps with a value that is not finite.
    pub not_finite: u64,
    /// Lines that are longer than any time step.
    pub too_long: u64,
    /// Time steps that found no room in the queue.
    pub dropped: u64,
}

impl StreamCounters {
    pub(crate) fn line(&self) {
        self.lines.fetch_add(1, Ordering::Relaxed);
    }

    /// Counts a line that is no time step; returns whether it is the first of its kind.
    pub(crate) fn skip(&self, kind: Skip) -> bool {
        let of = match kind {
            Skip::Malformed => &self.malformed,
            Skip::Columns => &self.columns,
            Skip::NotFinite => &self.not_finite,
            Skip::TooLong => &self.too_long,
        };
        of.fetch_add(1, Ordering::Relaxed) == 0
    }

    /// Returns the numbers as they are now.
    pub fn now(&self) -> StreamCounts {
        let of = |count: &AtomicU64| count.load(Ordering::Relaxed);
        StreamCounts {
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

/// Why a line is no time step.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Skip {
    Malformed,
    Columns,
    NotFinite,
    TooLong,
}

enum QueueItem {
    Reading(Arrival),
    Begin(String),
    Tare,
    End(Result<()>),
}

/// The receiving end of the queue.
pub struct ReadingStream {
    from: Receiver<QueueItem>,
    spare: SyncSender<Vec<f32>>,
    counters: Arc<StreamCounters>,
}

/// The sending end of the queue.
pub(crate) struct Feed {
    to: SyncSender<QueueItem>,
    spare: Receiver<Vec<f32>>,
    pub counters: Arc<StreamCounters>,
    /// Whether a time step without room is dropped; it waits otherwise.
    drops: bool,
    lost: u64,
    /// Lines since the last time step that were none.
    skipped: u64,
}

/// The receiver is gone.
pub(crate) struct Closed;

/// Makes a queue for time steps of `each` values.
pub(crate) fn queue(each: usize, drops: bool) -> (Feed, ReadingStream) {
    let room = (BYTES / (4 * each.max(1))).clamp(WAITING.0, WAITING.1);
    let (to, from) = sync_channel(room);
    let (back, spare) = sync_channel(room + 2);
    let counters = Arc::new(StreamCounters::default());
    let feed = Feed { to, spare, counters: Arc::clone(&counters), drops, lost: 0, skipped: 0 };
    (feed, ReadingStream { from, spare: back, counters })
}

impl Feed {
    /// Hands a time step on: waits for room, or drops it.
    pub fn reading(
        &mut self,
        values: &[f32],
        stamp: Option<f64>,
        at: Instant,
    ) -> std::result::Result<(), Closed> {
        self.counters.readings.fetch_add(1, Ordering::Relaxed);
        let mut copy = self.spare.try_recv().unwrap_or_default();
        copy.clear();
        copy.extend_from_slice(values);
        let (lost, skipped) = (self.lost, self.skipped);
        let item = QueueItem::Reading(Arrival { values: copy, stamp, at, lost, skipped });
        if !self.drops {
            self.skipped = 0;
            return self.to.send(item).map_err(|_| Closed);
        }
        match self.to.try_send(item) {
            Ok(()) => (self.lost, self.skipped) = (0, 0),
            Err(TrySendError::Full(_)) => {
                self.lost += 1;
                self.counters.dropped.fetch_add(1, Ordering::Relaxed);
            }
            Err(TrySendError::Disconnected(_)) => return Err(Closed),
        }
        Ok(())
    }

    /// Counts a line that is no time step.
    pub fn skip(&mut self) {
        self.skipped += 1;
    }

    pub fn begin(&self, name: &str) -> std::result::Result<(), Closed> {
        self.to.send(QueueItem::Begin(name.into())).map_err(|_| Closed)
    }

    pub fn tare(&self) -> std::result::Result<(), Closed> {
        self.to.send(QueueItem::Tare).map_err(|_| Closed)
    }

    pub fn end(self, how: Result<()>) {
        // Nobody may be there to hear it.
        let _ = self.to.send(QueueItem::End(how));
    }
}

impl ReadingStream {
    /// Returns the counts so far.
    pub fn counted(&self) -> StreamCounts {
        self.counters.now()
    }

    /// Returns the next event if there is one already.
    pub fn waiting(&self) -> Next {
        match self.from.try_recv() {
            Ok(item) => item.into(),
            Err(TryRecvError::Empty) => Next::Quiet,
            Err(TryRecvError::Disconnected) => Next::End(Ok(())),
        }
    }

    /// Returns the next event within `wait`.
    pub fn next(&self, wait: Duration) -> Next {
        match self.from.recv_timeout(wait) {
            Ok(item) => item.into(),
            Err(RecvTimeoutError::Timeout) => Next::Quiet,
            Err(RecvTimeoutError::Disconnected) => Next::End(Ok(())),
        }
    }

    /// Takes back the memory of a time step, for another one.
    pub fn give_back(&self, values: Vec<f32>) {
        let _ = self.spare.try_send(values);
    }
}

impl From<QueueItem> for Next {
    fn from(item: QueueItem) -> Self {
        match item {
            QueueItem::Reading(arrival) => Next::Reading(arrival),
            QueueItem::Begin(name) => Next::Begin(name),
            QueueItem::Tare => Next::Tare,
            QueueItem::End(how) => Next::End(how),
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn next(stream: &ReadingStream) -> (f32, u64) {
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
