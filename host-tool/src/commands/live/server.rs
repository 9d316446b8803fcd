//! The page and its way to the board, on this machine alone: `/` is the page, `/lines` the board's lines as server-sent events,
//! `/say` takes a line for the board.
//!
//! A page of another site may send requests here too: it is refused by the `Host` that a rebound name would have, and by a header
//! that no page of another origin can set without being allowed to.

use crate::commands::live::link::{Event, Link};
use crate::failure::{Failure, Outcome};
use crate::interrupt::Interrupt;
use std::io::{Read, Write};
use std::sync::mpsc::RecvTimeoutError;
use std::time::{Duration, Instant};
use tiny_http::{Header, Method, Request, Response, Server};

/// How long a request is waited for before Ctrl-C is looked at again.
const GLANCE: Duration = Duration::from_millis(200);
/// A listener that is gone is noticed within this.
const PULSE: Duration = Duration::from_secs(2);
/// Events go out thirty times a second at most: a page has work with each, and no eye sees more.
const BEAT: Duration = Duration::from_millis(33);
/// A console's line, and its end.
const MAX_SAID: u64 = 256;

/// Serves one page.
pub struct Serving {
    server: Server,
    port: u16,
    page: String,
    link: Link,
}

impl Serving {
    /// At a port of this machine; 0 takes a free one.
    ///
    /// # Errors
    /// The port is taken.
    pub fn at(port: u16, page: String, link: Link) -> Outcome<Self> {
        let server = Server::http(("127.0.0.1", port))
            .map_err(|error| Failure::usage(format!("--listen {port}: {error}: is the port taken?")))?;
        let port = server.server_addr().to_ip().map_or(port, |address| address.port());
        Ok(Serving { server, port, page, link })
    }

    /// Where the page is.
    pub fn address(&self) -> String {
        format!("http://127.0.0.1:{}/", self.port)
    }

    /// Answers until Ctrl-C.
    ///
    /// # Errors
    /// The server has failed.
    pub fn run(&self, interrupt: &Interrupt) -> Outcome<()> {
        while !interrupt.is_asked() {
            match self.server.recv_timeout(GLANCE) {
                // A listener that hangs up in the middle is not a failure of the program.
                Ok(Some(request)) => drop(self.answer(request)),
                Ok(None) => {}
                Err(error) => return Err(Failure::usage(format!("the page cannot be served: {error}"))),
            }
        }
        Ok(())
    }

    fn answer(&self, mut request: Request) -> std::io::Result<()> {
        let head = |name: &'static str| {
            let found = request.headers().iter().find(|header| header.field.equiv(name));
            found.map(|header| header.value.as_str().to_string())
        };
        let own = [format!("127.0.0.1:{}", self.port), format!("localhost:{}", self.port)];
        if !head("Host").is_some_and(|host| own.contains(&host)) {
            return request.respond(said(403, "this page is for this machine only"));
        }
        let from_page = head("X-Ironout").is_some();
        match (request.method().clone(), request.url()) {
            (Method::Get, "/") => {
                let kind = header("Content-Type", "text/html; charset=utf-8");
                request.respond(Response::from_string(&self.page).with_header(kind).with_header(fresh()))
            }
            (Method::Get, "/lines") => {
                let link = self.link.clone();
                std::thread::spawn(move || tell(request, &link));
                Ok(())
            }
            (Method::Post, "/say") if from_page => {
                let mut line = String::new();
                let read = request.as_reader().take(MAX_SAID).read_to_string(&mut line);
                let sound = |c: char| c == '\n' || c == ' ' || c.is_ascii_graphic();
                if read.is_err() || !line.chars().all(sound) {
                    return request.respond(said(400, "a line of printable ASCII is expected"));
                }
                self.link.say(format!("{line}\n").into_bytes());
                request.respond(said(200, "said"))
            }
            (Method::Post, "/say") => request.respond(said(403, "only this page may access the board")),
            _ => request.respond(said(404, "there is nothing here")),
        }
    }
}

fn header(name: &str, value: &str) -> Header {
    // Both are the program's own ASCII.
    Header::from_bytes(name, value).unwrap_or_else(|()| unreachable!("a header of its own"))
}

fn fresh() -> Header {
    header("Cache-Control", "no-store")
}

fn said(status: u16, text: &str) -> Response<std::io::Cursor<Vec<u8>>> {
    Response::from_string(text).with_status_code(status).with_header(fresh())
}

/// Writes events until the listener hangs up.
fn tell(request: Request, link: &Link) {
    let events = link.listen();
    let mut out = request.into_writer();
    let begin = "HTTP/1.1 200 OK\r\nContent-Type: text/event-stream\r\nCache-Control: no-store\r\nConnection: close\r\n\r\n";
    let mut written = out.write_all(begin.as_bytes()).and_then(|()| out.flush());
    let mut told = Instant::now();
    while written.is_ok() {
        let text = match events.recv_timeout(PULSE) {
            Ok(Event::Lines(mut lines)) => {
                std::thread::sleep(BEAT.saturating_sub(told.elapsed()));
                told = Instant::now();
                let mut state = None;
                // What has come meanwhile goes with it.
                while let Ok(more) = events.try_recv() {
                    match more {
                        Event::Lines(more) => lines.extend(more),
                        Event::State(other) => {
                            state = Some(other);
                            break;
                        }
                    }
                }
                let state = state.map_or(String::new(), |state| format!("event: state\ndata: {state}\n\n"));
                format!("event: lines\ndata: {}\n\n{state}", serde_json::json!(lines))
            }
            Ok(Event::State(state)) if state.is_empty() => String::new(),
            Ok(Event::State(state)) => format!("event: state\ndata: {state}\n\n"),
            Err(RecvTimeoutError::Timeout) => ": here\n\n".to_string(),
            Err(RecvTimeoutError::Disconnected) => return,
        };
        written = out.write_all(text.as_bytes()).and_then(|()| out.flush());
    }
}
