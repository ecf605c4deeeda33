//! A stand-in for a sensor on a serial port: a pseudo-terminal that sends presses.

use std::io::Write;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use serialport::{SerialPort, TTYPort};

/// A value of a stream of presses of one second each at 100 Hz, a quarter of a second at rest before each.
pub fn press(t: usize, channel: usize) -> f32 {
    let phase = (t % 75) as f32;
    let force = if phase < 25.0 { 0.0 } else { ((phase - 25.0) * 0.06).sin() };
    let noise = ((t * 7919 + channel * 31) % 13) as f32 * 0.05;
    100.0 + 80.0 * force * (1.0 + channel as f32) + noise
}

/// A sensor that sends lines until it is dropped: its cable is pulled then.
pub struct Sensor {
    /// Where it is.
    pub port: String,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Sensor {
    /// Begins to send two channels, `thumb` and `index`, at so many Hz.
    #[allow(dead_code, reason = "not every test has these presses")]
    pub fn start(rate: f64) -> Self {
        Self::of(rate, |t| [press(t, 0), press(t, 1)].map(f64::from))
    }

    /// Begins to send what two channels have at so many Hz, as JSON: whoever comes later hears their names too.
    pub fn of(rate: f64, values: impl Fn(usize) -> [f64; 2] + Send + 'static) -> Self {
        let (mut master, slave) = TTYPort::pair().unwrap();
        let port = slave.name().unwrap();
        // Whoever opened it keeps others out.
        drop(slave);
        let stop = Arc::new(AtomicBool::new(false));
        let stopped = Arc::clone(&stop);
        let send = move || {
            let begin = Instant::now();
            for t in 0.. {
                if stopped.load(Ordering::Relaxed) {
                    break;
                }
                let due = begin + Duration::from_secs_f64(t as f64 / rate);
                std::thread::sleep(due.saturating_duration_since(Instant::now()));
                // The terminal's buffer is full while nobody listens; readings are lost then, as those of a device are.
                let [thumb, index] = values(t);
                let _ =
                    master.write_all(format!("{{\"thumb\":{thumb:.3},\"index\":{index:.3}}}\r\n").as_bytes());
            }
        };
        Sensor { port, stop, thread: Some(std::thread::spawn(send)) }
    }
}

impl Drop for Sensor {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}
