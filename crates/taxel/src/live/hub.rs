//! Events for everybody who looks on. Whoever is slow loses frames; who sends them never waits.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// Events that wait for one viewer; of more the oldest is dropped.
const ROOM: usize = 64;

/// An event as it is sent.
pub type Event = Arc<str>;

/// Hands events on to viewers.
#[derive(Default)]
pub struct Hub {
    viewers: Mutex<Vec<Arc<Viewer>>>,
    count: AtomicUsize,
    dropped: AtomicU64,
    /// Events that a viewer who comes late needs: one of each name.
    latest: Mutex<Vec<(&'static str, Event)>>,
}

/// The queue of one viewer.
#[derive(Default)]
pub struct Viewer {
    waiting: Mutex<(VecDeque<Event>, bool)>,
    wake: Condvar,
}

/// Locks what a panic of another thread does not spoil: all that is guarded is whole at any moment.
fn held<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Hub {
    /// Checks whether somebody looks on.
    pub fn has_viewers(&self) -> bool {
        self.viewers() > 0
    }

    /// Counts those who look on.
    pub fn viewers(&self) -> usize {
        self.count.load(Ordering::Relaxed)
    }

    /// Counts the events that slow viewers did not get.
    pub fn dropped(&self) -> u64 {
        self.dropped.load(Ordering::Relaxed)
    }

    /// Sends an event to all who look on.
    pub fn send(&self, event: &Event) {
        for viewer in held(&self.viewers).iter() {
            let mut waiting = held(&viewer.waiting);
            if waiting.0.len() == ROOM {
                waiting.0.pop_front();
                self.dropped.fetch_add(1, Ordering::Relaxed);
            }
            waiting.0.push_back(Arc::clone(event));
            viewer.wake.notify_one();
        }
    }

    /// Sends an event, and keeps it for those who come later, in place of the last of that name.
    pub fn keep(&self, name: &'static str, event: &Event) {
        let mut latest = held(&self.latest);
        match latest.iter_mut().find(|(known, _)| *known == name) {
            Some((_, old)) => *old = Arc::clone(event),
            None => latest.push((name, Arc::clone(event))),
        }
        drop(latest);
        self.send(event);
    }

    /// Adds a viewer, who first gets what was kept.
    pub fn join(&self) -> Arc<Viewer> {
        let viewer = Arc::new(Viewer::default());
        let latest = held(&self.latest);
        held(&viewer.waiting).0.extend(latest.iter().map(|(_, event)| Arc::clone(event)));
        held(&self.viewers).push(Arc::clone(&viewer));
        self.count.fetch_add(1, Ordering::Relaxed);
        viewer
    }

    /// Takes a viewer away who has gone.
    pub fn leave(&self, viewer: &Arc<Viewer>) {
        held(&self.viewers).retain(|other| !Arc::ptr_eq(other, viewer));
        self.count.fetch_sub(1, Ordering::Relaxed);
    }

    /// Ends all queues: viewers get what waits, and then nothing.
    pub fn close(&self) {
        for viewer in held(&self.viewers).iter() {
            held(&viewer.waiting).1 = true;
            viewer.wake.notify_one();
        }
    }

    /// Checks whether every viewer has got everything.
    pub fn is_idle(&self) -> bool {
        held(&self.viewers).iter().all(|viewer| held(&viewer.waiting).0.is_empty())
    }
}

/// The next event of a viewer.
pub enum Got {
    Event(Event),
    /// Nothing came for a while.
    Quiet,
    /// Nothing will come.
    End,
}

impl Viewer {
    /// Waits for the next event.
    pub fn next(&self, wait: Duration) -> Got {
        let mut waiting = held(&self.waiting);
        if waiting.0.is_empty() && !waiting.1 {
            waiting = self.wake.wait_timeout(waiting, wait).unwrap_or_else(PoisonError::into_inner).0;
        }
        match waiting.0.pop_front() {
            Some(event) => Got::Event(event),
            None if waiting.1 => Got::End,
            None => Got::Quiet,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(viewer: &Viewer) -> Option<String> {
        match viewer.next(Duration::ZERO) {
            Got::Event(event) => Some(event.to_string()),
            Got::Quiet => None,
            Got::End => Some("end".into()),
        }
    }

    #[test]
    fn who_does_not_read_loses_the_oldest_and_nobody_waits() {
        let hub = Hub::default();
        hub.keep("facts", &"facts".into());
        let (slow, quick) = (hub.join(), hub.join());
        assert!(hub.has_viewers());
        assert_eq!((text(&slow), text(&quick)), (Some("facts".into()), Some("facts".into())));
        for number in 0..1000 {
            hub.send(&number.to_string().into());
            assert_eq!(text(&quick), Some(number.to_string()));
        }
        assert_eq!(hub.dropped(), 1000 - ROOM as u64);
        assert_eq!(text(&slow), Some((1000 - ROOM).to_string()));
        let rest: Vec<String> = (1..ROOM).filter_map(|_| text(&slow)).collect();
        assert_eq!(rest.last().map(String::as_str), Some("999"));
        hub.leave(&slow);
        hub.leave(&quick);
        assert!(!hub.has_viewers() && hub.is_idle());
    }

    #[test]
    fn an_end_comes_after_what_waits() {
        let hub = Hub::default();
        let viewer = hub.join();
        hub.send(&"last".into());
        hub.close();
        assert!(!hub.is_idle());
        assert_eq!((text(&viewer), text(&viewer)), (Some("last".into()), Some("end".into())));
    }
}
