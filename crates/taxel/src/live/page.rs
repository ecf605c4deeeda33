//! Frames and events of the live page.

use std::net::{SocketAddr, TcpListener, ToSocketAddrs};
use std::sync::Arc;
use std::time::{Duration, Instant};

use clap::Args;
use serde_json::{Value, json};

use super::http;
use super::hub::Hub;
use crate::terminal::messages::{note, warn};

/// Time between two frames of readings: 25 a second, which no eye tells from all of them.
const FRAME: Duration = Duration::from_millis(40);
/// Values of a time step that a frame shows.
const SHOWN: usize = 1024;
/// Time that viewers get for the last events.
const PARTING: Duration = Duration::from_millis(300);

/// `--serve` and `--serve-anywhere`.
#[derive(Args, Debug, Clone)]
pub struct ServeOptions {
    /// Shows a live page at this address, such as 127.0.0.1:8000; port 0 takes a free one.
    #[arg(long, value_name = "ADDRESS")]
    serve: Option<String>,
    /// Allows addresses of --serve that other machines reach. Nothing on the page is secret from whoever can reach it then.
    #[arg(long, requires = "serve")]
    serve_anywhere: bool,
}

impl ServeOptions {
    /// Opens the page, if one is asked for.
    ///
    /// # Errors
    /// An address that is none, is in use, or that other machines reach without `--serve-anywhere`.
    pub fn open(&self) -> Result<Option<LivePage>, String> {
        let Some(text) = &self.serve else { return Ok(None) };
        let refuse = |why: String| format!("--serve {text}: {why}");
        let found = text
            .to_socket_addrs()
            .map_err(|_| refuse("is an address and a port, such as 127.0.0.1:8000".into()))?;
        let addresses: Vec<SocketAddr> = found.collect();
        if !self.serve_anywhere && addresses.iter().any(|address| !address.ip().is_loopback()) {
            let how = "other machines reach it; say 127.0.0.1 in its place, or --serve-anywhere as well";
            return Err(refuse(how.into()));
        }
        let listener = TcpListener::bind(addresses.as_slice())
            .map_err(|e| refuse(format!("cannot be opened: {e}; say another port")))?;
        let address = listener.local_addr().map_err(|e| refuse(e.to_string()))?;
        let hub = Arc::new(Hub::default());
        http::serve(listener, Arc::clone(&hub)).map_err(|e| refuse(format!("cannot be served: {e}")))?;
        note(format!("live page: http://{address}/"));
        if self.serve_anywhere && !address.ip().is_loopback() {
            warn("--serve-anywhere: whoever reaches this machine sees the page");
        }
        Ok(Some(LivePage { hub, frame: Frame::default() }))
    }
}

/// A page that viewers look at.
pub struct LivePage {
    hub: Arc<Hub>,
    frame: Frame,
}

/// The time steps since the last frame.
#[derive(Default)]
struct Frame {
    begun: Option<Instant>,
    low: Vec<f32>,
    high: Vec<f32>,
    /// Time steps since the beginning.
    readings: u64,
    lost: u64,
}

impl LivePage {
    /// Shows what does not change.
    pub fn facts(&self, facts: &Value) {
        self.hub.keep("facts", &event("facts", &facts.to_string()));
    }

    /// Shows a time step, at `time` in seconds, before which so many were `lost`. Between two frames the lowest and the highest value
    /// of each channel are kept.
    pub fn reading(&mut self, values: &[f32], time: f64, lost: u64) {
        let frame = &mut self.frame;
        frame.readings += 1;
        frame.lost += lost;
        if !self.hub.has_viewers() {
            frame.begun = None;
            return;
        }
        let values = &values[..values.len().min(SHOWN)];
        let now = Instant::now();
        let begun = *frame.begun.get_or_insert_with(|| {
            frame.low.clear();
            frame.high.clear();
            frame.low.extend_from_slice(values);
            frame.high.extend_from_slice(values);
            now
        });
        let ends = frame.low.iter_mut().zip(&mut frame.high).zip(values);
        ends.for_each(|((low, high), value)| (*low, *high) = (low.min(*value), high.max(*value)));
        if now - begun >= FRAME {
            frame.begun = None;
            let data = json!({
                "time": time, "low": frame.low, "high": frame.high, "readings": frame.readings, "lost": frame.lost,
            });
            self.hub.send(&event("readings", &data.to_string()));
        }
    }

    /// Shows an event of this name, as one line of JSON, also to those who come later.
    pub fn show(&self, name: &'static str, line: &str) {
        self.hub.keep(name, &event(name, line.trim_end()));
    }

    /// Says that nothing more comes, and waits a moment until viewers have got it.
    pub fn end(&self, why: &str) {
        self.show("end", &json!({ "why": why, "frames_dropped": self.hub.dropped() }).to_string());
        self.hub.close();
        let begin = Instant::now();
        while !self.hub.is_idle() && begin.elapsed() < PARTING {
            std::thread::sleep(Duration::from_millis(5));
        }
        // The last one is being written.
        std::thread::sleep(Duration::from_millis(10));
    }
}

fn event(name: &str, data: &str) -> Arc<str> {
    format!("event: {name}\ndata: {data}\n\n").into()
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn options(address: &str, serve_anywhere: bool) -> ServeOptions {
        ServeOptions { serve: Some(address.into()), serve_anywhere }
    }

    #[test]
    fn other_machines_see_the_page_only_when_asked() {
        for address in ["0.0.0.0:0", "[::]:0", "8.8.8.8:80"] {
            let refused = options(address, false).open().err().unwrap();
            assert!(refused.contains("--serve-anywhere"), "{refused}");
        }
        for wrong in ["8000", "nowhere", "127.0.0.1"] {
            assert!(options(wrong, false).open().is_err_and(|why| why.contains("127.0.0.1:8000")), "{wrong}");
        }
        assert!(options("127.0.0.1:0", false).open().unwrap().is_some());
        assert!(options("0.0.0.0:0", true).open().unwrap().is_some());
        assert!(ServeOptions { serve: None, serve_anywhere: false }.open().unwrap().is_none());
    }

    #[test]
    fn a_frame_keeps_the_peaks_between() {
        let hub = Arc::new(Hub::default());
        let mut page = LivePage { hub: Arc::clone(&hub), frame: Frame::default() };
        page.reading(&[9.0], 0.0, 0);
        let viewer = hub.join();
        page.reading(&[1.0], 0.001, 0);
        page.reading(&[5.0], 0.002, 3);
        page.reading(&[-2.0], 0.003, 0);
        std::thread::sleep(FRAME);
        page.reading(&[0.0], 0.05, 0);
        let super::super::hub::Got::Event(event) = viewer.next(Duration::ZERO) else {
            unreachable!("a frame is due")
        };
        let data: Value =
            serde_json::from_str(event.trim().lines().last().unwrap().trim_start_matches("data: ")).unwrap();
        assert_eq!((&data["low"][0], &data["high"][0]), (&json!(-2.0), &json!(5.0)));
        assert_eq!((&data["readings"], &data["lost"]), (&json!(5), &json!(3)));
    }
}
