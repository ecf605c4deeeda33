//! As much of HTTP as the live page needs.
//!
//! A server of the standard library and no crate: there are three answers to `GET`, none has a body in the request, and each
//! connection needs a time limit on writing, so that a browser that is blocked is let go. `tiny_http` sets none.

use std::io::{BufRead, BufReader, ErrorKind, Read, Write};
use std::net::{IpAddr, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use super::hub::{Got, Hub};

/// Connections at once; more are turned away.
const CONNECTIONS: usize = 16;
/// Bytes of a request.
const REQUEST: u64 = 8 << 10;
/// Time in which a whole request has to come, and an answer has to be taken.
const PATIENCE: Duration = Duration::from_secs(5);
/// Time without an event after which a comment keeps the connection open, and shows who has gone.
const QUIET: Duration = Duration::from_secs(2);

const PAGE: &str = include_str!("page.html");

/// Sent with every answer: nothing may be loaded from elsewhere, nobody may frame the page or keep a copy.
const HEADERS: &str = "Cache-Control: no-store\r\nX-Content-Type-Options: nosniff\r\nX-Frame-Options: DENY\r\n\
    Referrer-Policy: no-referrer\r\nCross-Origin-Resource-Policy: same-origin\r\n\
    Content-Security-Policy: default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; connect-src 'self'; \
    img-src data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'\r\nConnection: close\r\n";

/// Answers requests on threads of their own until the process ends.
///
/// # Errors
/// A thread that cannot be started.
pub fn serve(listener: TcpListener, hub: Arc<Hub>) -> std::io::Result<()> {
    let open = Arc::new(AtomicUsize::new(0));
    let accept = move || {
        for stream in listener.incoming() {
            let Ok(stream) = stream else {
                // No file handles are left, for example: others have to close theirs.
                std::thread::sleep(Duration::from_millis(50));
                continue;
            };
            let (hub, counted) = (Arc::clone(&hub), Connection::new(&open));
            let answer = move || {
                let is_too_many = counted.is_too_many();
                let _ = answer(&stream, &hub, is_too_many);
                drop(counted);
            };
            // A viewer without a thread is turned away by its own patience.
            let _ = std::thread::Builder::new().name("viewer".into()).spawn(answer);
        }
    };
    std::thread::Builder::new().name("page".into()).spawn(accept).map(|_| ())
}

/// Counts a connection for as long as it is open.
struct Connection(Arc<AtomicUsize>, usize);

impl Connection {
    fn new(open: &Arc<AtomicUsize>) -> Self {
        let before = open.fetch_add(1, Ordering::SeqCst);
        Connection(Arc::clone(open), before)
    }

    fn is_too_many(&self) -> bool {
        self.1 >= CONNECTIONS
    }
}

impl Drop for Connection {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::SeqCst);
    }
}

fn answer(stream: &TcpStream, hub: &Hub, is_too_many: bool) -> std::io::Result<()> {
    stream.set_write_timeout(Some(PATIENCE))?;
    stream.set_nodelay(true)?;
    let refuse = |status: &str, why: &str| plain(stream, status, "text/plain; charset=utf-8", why);
    if is_too_many {
        return refuse("503 Service Unavailable", "too many viewers; close some\n");
    }
    let request = match read_request(UntilThen { stream, end: Instant::now() + PATIENCE }) {
        Ok(Some(request)) => request,
        Ok(None) => return refuse("400 Bad Request", "not a request that this page answers\n"),
        Err(error) if is_late(&error) => {
            return refuse("408 Request Timeout", "the request was not complete in time\n");
        }
        Err(error) => return Err(error),
    };
    if !request.host.as_deref().is_some_and(is_own_host) {
        return refuse("421 Misdirected Request", "ask for the page by its IP address, or by localhost\n");
    }
    if request.method != "GET" {
        return refuse("405 Method Not Allowed", "only GET is answered\n");
    }
    match request.path.as_str() {
        "/" | "/index.html" => plain(stream, "200 OK", "text/html; charset=utf-8", PAGE),
        "/events" => events(stream, hub),
        _ => refuse("404 Not Found", "there is / and /events\n"),
    }
}

/// Reads a connection until a moment, however slowly its bytes come: a limit for each byte would let one client after the other
/// keep a connection open for hours.
struct UntilThen<'s> {
    stream: &'s TcpStream,
    end: Instant,
}

impl Read for UntilThen<'_> {
    fn read(&mut self, into: &mut [u8]) -> std::io::Result<usize> {
        let left = self.end.saturating_duration_since(Instant::now());
        // A limit of nothing would be none.
        if left.is_zero() {
            return Err(ErrorKind::TimedOut.into());
        }
        self.stream.set_read_timeout(Some(left))?;
        self.stream.read(into)
    }
}

/// Checks whether a read ended for its time limit; systems name that differently.
fn is_late(error: &std::io::Error) -> bool {
    matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::WouldBlock)
}

/// The head of a request.
#[derive(Debug, PartialEq)]
struct Request {
    method: String,
    path: String,
    host: Option<String>,
}

/// Reads the head of a request; none of what is no HTTP/1, or too long.
fn read_request(stream: impl Read) -> std::io::Result<Option<Request>> {
    let mut lines = BufReader::new(stream.take(REQUEST));
    let mut line = String::new();
    lines.read_line(&mut line)?;
    let mut words = line.split_ascii_whitespace();
    let (Some(method), Some(path), Some(version)) = (words.next(), words.next(), words.next()) else {
        return Ok(None);
    };
    if !version.starts_with("HTTP/1.") {
        return Ok(None);
    }
    let path = path.split(['?', '#']).next().unwrap_or_default().to_string();
    let mut request = Request { method: method.into(), path, host: None };
    loop {
        let mut line = String::new();
        if lines.read_line(&mut line)? == 0 {
            return Ok(None);
        }
        let header = line.trim();
        if header.is_empty() {
            return Ok(Some(request));
        }
        if let Some((name, value)) = header.split_once(':')
            && name.eq_ignore_ascii_case("host")
        {
            // Two would be read by one as the first, by another as the second.
            if request.host.replace(value.trim().into()).is_some() {
                return Ok(None);
            }
        }
    }
}

/// Checks whether a `Host` is an address or this machine's own name. A page of somebody else whose name is made to lead here would
/// say its own name.
fn is_own_host(host: &str) -> bool {
    let name = match host.strip_prefix('[') {
        Some(rest) => match rest.split_once(']') {
            Some((name, port)) if port.is_empty() || is_port(port) => name,
            _ => return false,
        },
        None => match host.split_once(':') {
            Some((name, port)) if port.parse::<u16>().is_ok() => name,
            Some(_) => return false,
            None => host,
        },
    };
    name.eq_ignore_ascii_case("localhost") || name.parse::<IpAddr>().is_ok()
}

fn is_port(text: &str) -> bool {
    text.strip_prefix(':').is_some_and(|port| port.parse::<u16>().is_ok())
}

fn plain(mut stream: &TcpStream, status: &str, kind: &str, body: &str) -> std::io::Result<()> {
    let length = body.len();
    write!(
        stream,
        "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {length}\r\n{HEADERS}\r\n{body}"
    )
}

/// Sends events until the viewer goes, or takes none for too long.
fn events(mut stream: &TcpStream, hub: &Hub) -> std::io::Result<()> {
    write!(stream, "HTTP/1.1 200 OK\r\nContent-Type: text/event-stream\r\n{HEADERS}\r\n")?;
    let viewer = hub.join();
    let mut send = || {
        loop {
            match viewer.next(QUIET) {
                Got::Event(event) => stream.write_all(event.as_bytes())?,
                Got::Quiet => stream.write_all(b":\n\n")?,
                Got::End => return Ok(()),
            }
        }
    };
    let how = send();
    hub.leave(&viewer);
    how
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn only_addresses_and_this_machine_are_hosts() {
        for own in [
            "127.0.0.1:8000",
            "localhost",
            "LOCALHOST:80",
            "[::1]:8000",
            "[::1]",
            "192.168.1.7:8000",
            "10.0.0.1",
        ] {
            assert!(is_own_host(own), "{own}");
        }
        for other in [
            "evil.example",
            "evil.example:8000",
            "127.0.0.1.evil.example",
            "localhost.evil.example",
            "",
            "[::1",
            "[::1]x",
            "127.0.0.1:x",
            "::1",
            "localhost:99999",
            "1.2.3.4@evil.example",
        ] {
            assert!(!is_own_host(other), "{other}");
        }
    }

    #[test]
    fn requests_are_read_or_refused() {
        let read = |text: &str| read_request(text.as_bytes()).unwrap();
        let request =
            read("GET /events?x=1 HTTP/1.1\r\nAccept: */*\r\nhOsT: localhost:8000\r\n\r\n").unwrap();
        assert_eq!((request.method.as_str(), request.path.as_str()), ("GET", "/events"));
        assert_eq!(request.host.as_deref(), Some("localhost:8000"));
        for wrong in [
            "",
            "GET /",
            "GET / SPDY/3\r\n\r\n",
            "GET / HTTP/1.1\r\nHost: a\r\n",
            "GET / HTTP/1.1\r\nHost: localhost\r\nHost: evil.example\r\n\r\n",
            &format!("GET / HTTP/1.1\r\nX: {}\r\n\r\n", "x".repeat(REQUEST as usize)),
        ] {
            assert_eq!(read(wrong), None, "{wrong:.40}");
        }
    }

    #[test]
    fn a_request_has_to_be_complete_in_time() {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let mut client = TcpStream::connect(listener.local_addr().unwrap()).unwrap();
        let (stream, _) = listener.accept().unwrap();
        // A byte now and then, each long before the end.
        let slow = std::thread::spawn(move || {
            let mut sent = 0;
            for byte in b"GET / HTTP/1.1\r\nHost: localhost\r\nX: ".iter().chain([b'x'; 200].iter()) {
                if client.write_all(&[*byte]).is_err() {
                    break;
                }
                sent += 1;
                std::thread::sleep(Duration::from_millis(20));
            }
            sent
        });
        let begin = Instant::now();
        let end = begin + Duration::from_millis(400);
        let error = read_request(UntilThen { stream: &stream, end }).unwrap_err();
        assert!(is_late(&error), "{error:?}");
        assert!(begin.elapsed() < Duration::from_secs(3), "{:?}", begin.elapsed());
        drop(stream);
        assert!(slow.join().unwrap() < 200);
    }

    #[test]
    fn a_viewer_that_does_not_read_never_holds_the_sender_up() {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap();
        let hub = Arc::new(Hub::default());
        serve(listener, Arc::clone(&hub)).unwrap();
        let ask = || {
            let mut stream = TcpStream::connect(address).unwrap();
            write!(stream, "GET /events HTTP/1.1\r\nHost: {address}\r\n\r\n").unwrap();
            stream
        };
        let (_blocked, reading) = (ask(), ask());
        while hub.viewers() < 2 {
            std::thread::sleep(Duration::from_millis(1));
        }
        let reader = std::thread::spawn(move || {
            let lines = BufReader::new(reading).lines().map_while(std::io::Result::ok);
            lines.filter(|line| line.starts_with("data: last")).count()
        });
        // More than all buffers between two sockets hold.
        let event: super::super::hub::Event = format!("data: {}\n\n", "x".repeat(1 << 17)).into();
        let begin = Instant::now();
        (0..1000).for_each(|_| hub.send(&event));
        assert!(begin.elapsed() < PATIENCE / 2, "{:?}", begin.elapsed());
        assert!(hub.dropped() > 500, "{}", hub.dropped());
        hub.send(&"data: last\n\n".into());
        // The one that is blocked is let go.
        let begin = Instant::now();
        while hub.viewers() > 1 && begin.elapsed() < 10 * PATIENCE {
            std::thread::sleep(Duration::from_millis(20));
        }
        assert_eq!(hub.viewers(), 1);
        hub.close();
        assert_eq!(reader.join().unwrap(), 1);
    }

    #[test]
    fn the_page_needs_nothing_from_elsewhere() {
        for outside in ["http://", "https://", "src=", "@import", "url("] {
            assert!(!PAGE.contains(outside), "{outside}");
        }
    }
}
