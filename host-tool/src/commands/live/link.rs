//! The board's lines to whoever listens, and lines to the board. The page speaks the console itself; here are only bytes.

use crate::board::Wire;
use crate::failure::Outcome;
use serde_json::json;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver, Sender};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// How long a line is waited for before something is sent.
const GLANCE: Duration = Duration::from_millis(10);
/// Pause between two attempts to find a disconnected board.
const PAUSE: Duration = Duration::from_millis(500);
/// A longer line is none of a console's.
const MAX_LINE: usize = 4096;

/// What a listener is told.
#[derive(Debug, Clone)]
pub enum Event {
    /// Lines of the board.
    Lines(Vec<String>),
    /// Whether the board is there, as JSON.
    State(String),
}

#[derive(Default)]
struct Audience {
    listeners: Vec<Sender<Event>>,
    state: String,
}

/// The way to a board, shared by all pages.
#[derive(Clone)]
pub struct Link {
    audience: Arc<Mutex<Audience>>,
    ended: Arc<AtomicBool>,
    to_board: Sender<Vec<u8>>,
}

impl Link {
    /// Keeps the way to a board open, in a thread of its own; `open` is tried again whenever it is gone.
    pub fn keep(
        name: String,
        wait: Duration,
        open: impl Fn() -> Outcome<Box<dyn Wire>> + Send + 'static,
    ) -> Self {
        let (to_board, from_pages) = mpsc::channel();
        let link = Link { audience: Arc::default(), ended: Arc::default(), to_board };
        let own = link.clone();
        std::thread::spawn(move || own.follow(&name, wait, &open, &from_pages));
        link
    }

    /// What comes from now on; first how it stands.
    pub fn listen(&self) -> Receiver<Event> {
        let (listener, heard) = mpsc::channel();
        let mut audience = self.audience.lock().unwrap_or_else(PoisonError::into_inner);
        // The other end is here.
        let _ = listener.send(Event::State(audience.state.clone()));
        audience.listeners.push(listener);
        heard
    }

    /// Sends bytes to the board; those for a board that is not there are lost.
    pub fn say(&self, bytes: Vec<u8>) {
        let _ = self.to_board.send(bytes);
    }

    /// Hangs up for good.
    #[cfg(feature = "demo")]
    pub fn end(&self) {
        self.ended.store(true, Ordering::Relaxed);
    }

    fn is_ended(&self) -> bool {
        self.ended.load(Ordering::Relaxed)
    }

    fn tell(&self, event: Event) {
        let mut audience = self.audience.lock().unwrap_or_else(PoisonError::into_inner);
        if let Event::State(state) = &event {
            audience.state.clone_from(state);
        }
        audience.listeners.retain(|listener| listener.send(event.clone()).is_ok());
    }

    fn state(&self, name: &str, open: bool, why: &str) {
        self.tell(Event::State(json!({"name": name, "open": open, "why": why}).to_string()));
    }

    fn follow(
        &self,
        name: &str,
        wait: Duration,
        open: &impl Fn() -> Outcome<Box<dyn Wire>>,
        from_pages: &Receiver<Vec<u8>>,
    ) {
        // The last failure on the terminal: one that lasts is printed once.
        let mut printed = String::new();
        while !self.is_ended() {
            match open() {
                Ok(mut wire) => {
                    printed.clear();
                    while from_pages.try_recv().is_ok() {}
                    self.state(name, true, "");
                    let why = self.pass(wire.as_mut(), wait, from_pages);
                    self.state(name, false, &why);
                }
                Err(failure) => {
                    if printed != failure.message {
                        eprintln!(
                            "note: {name}: {}. ironout tries again until it can be opened",
                            failure.message
                        );
                    }
                    self.state(name, false, &failure.message);
                    printed = failure.message;
                }
            }
            std::thread::sleep(PAUSE);
        }
    }

    /// Passes bytes both ways until the wire is gone: why it is.
    fn pass(&self, wire: &mut dyn Wire, wait: Duration, from_pages: &Receiver<Vec<u8>>) -> String {
        let mut rest = Vec::new();
        let mut chunk = [0; 4096];
        loop {
            if self.is_ended() {
                return "the program has ended".into();
            }
            while let Ok(bytes) = from_pages.try_recv() {
                if let Err(error) = wire.write(&bytes, wait) {
                    return error.to_string();
                }
            }
            match wire.read(&mut chunk, GLANCE) {
                Ok(count) => rest.extend_from_slice(chunk.get(..count).unwrap_or_default()),
                Err(error) => return error.to_string(),
            }
            let Some(end) = rest.iter().rposition(|byte| *byte == b'\n') else {
                if rest.len() > MAX_LINE {
                    rest.clear();
                }
                continue;
            };
            let whole: Vec<u8> = rest.drain(..=end).collect();
            let text = String::from_utf8_lossy(&whole);
            let lines: Vec<String> =
                text.lines().filter(|line| !line.is_empty()).map(str::to_string).collect();
            if !lines.is_empty() {
                self.tell(Event::Lines(lines));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::VecDeque;
    use std::io;

    struct Script(VecDeque<&'static [u8]>, Sender<Vec<u8>>);

    impl Wire for Script {
        fn read(&mut self, into: &mut [u8], _: Duration) -> io::Result<usize> {
            let Some(piece) = self.0.pop_front() else { return Err(io::ErrorKind::UnexpectedEof.into()) };
            into[..piece.len()].copy_from_slice(piece);
            Ok(piece.len())
        }
        fn write(&mut self, bytes: &[u8], _: Duration) -> io::Result<()> {
            self.1.send(bytes.to_vec()).map_err(io::Error::other)
        }
    }

    #[test]
    fn lines_come_whole_and_a_wire_that_is_gone_is_opened_again() {
        let (heard, _hears) = mpsc::channel();
        let heard = Mutex::new(heard);
        let link = Link::keep("a board".into(), Duration::from_secs(1), move || {
            let heard = heard.lock().expect("alone").clone();
            std::thread::sleep(Duration::from_millis(50));
            Ok(Box::new(Script(VecDeque::from([&b"R,1,2"[..], b",3\n+ a\nok", b"\r\n"]), heard)))
        });
        let events = link.listen();
        let (mut lines, mut opened) = (Vec::new(), 0);
        while opened < 2 {
            match events.recv_timeout(Duration::from_secs(300)).expect("it goes on") {
                Event::Lines(more) => lines.extend(more),
                Event::State(state) => opened += usize::from(state.contains("\"open\":true")),
            }
        }
        assert_eq!(lines.get(..3), Some(&["R,1,2,3".to_string(), "+ a".into(), "ok".into()][..]));
    }
}
