//! The other end of the board's console.

use super::error::Error;
use crate::reply::{Line, Reply};
use std::io::{ErrorKind, Read, Write};
use std::os::unix::net::UnixStream;
use std::time::{Duration, Instant};

/// How long a reply may take. The contract gives the board 2 s of its own time; how long an emulator on a busy machine takes for
/// them nobody knows, so that only a board that does not answer at all fails.
const REPLY_LIMIT: Duration = Duration::from_secs(300);

/// A client of the console. It keeps the unasked lines (the streams) apart from the replies, each in its order.
pub struct Console {
    socket: UnixStream,
    partial: Vec<u8>,
    streamed: Vec<String>,
}

impl Console {
    /// Over an open connection.
    pub(super) fn new(socket: UnixStream) -> Self {
        Self { socket, partial: Vec::new(), streamed: Vec::new() }
    }

    /// Sends `bytes` as they are: for what no well-behaved client sends.
    pub fn send(&mut self, bytes: &[u8]) -> Result<(), Error> {
        self.socket.write_all(bytes).map_err(Error::io("write to the console"))
    }

    /// Sends one command and waits for its reply.
    ///
    /// # Errors
    /// [`Error::Timeout`] without a complete reply; [`Error::Protocol`] for a line that is neither reply nor stream.
    pub fn command(&mut self, command: &str) -> Result<Reply, Error> {
        self.send(format!("{command}\n").as_bytes())?;
        self.reply(command)
    }

    /// Waits for the reply to what was sent with [`Console::send`]; `sent` is for the error message.
    pub fn reply(&mut self, sent: &str) -> Result<Reply, Error> {
        let deadline = Instant::now() + REPLY_LIMIT;
        let mut info = Vec::new();
        loop {
            let line = self.line(deadline, &format!("the reply to `{sent}`"))?;
            match Line::of(&line) {
                Line::Streamed => self.streamed.push(line),
                Line::Info(text) => info.push(text.to_owned()),
                Line::Closing(outcome) => return Ok(Reply { info, outcome }),
                Line::Unknown => return Err(Error::Protocol { line, expected: "`+ `, `ok` or `err CODE`" }),
            }
        }
    }

    /// The next unasked line, waiting for it if there is none yet.
    ///
    /// # Errors
    /// [`Error::Timeout`]; [`Error::Protocol`] for any other line.
    pub fn next_streamed(&mut self, limit: Duration) -> Result<String, Error> {
        if !self.streamed.is_empty() {
            return Ok(self.streamed.remove(0));
        }
        let line = self.line(Instant::now() + limit, "a line of the stream")?;
        if Line::of(&line) == Line::Streamed {
            Ok(line)
        } else {
            Err(Error::Protocol { line, expected: "a line of the stream" })
        }
    }

    /// The unasked lines that came while replies were waited for, oldest first.
    pub fn take_streamed(&mut self) -> Vec<String> {
        std::mem::take(&mut self.streamed)
    }

    /// Whether an unasked line has come while a reply was waited for.
    pub fn has_streamed(&self) -> bool {
        !self.streamed.is_empty()
    }

    /// Everything that has come and was not asked for, without waiting: a silent board gives nothing.
    pub fn drain(&mut self, wait: Duration) -> Result<Vec<String>, Error> {
        let deadline = Instant::now() + wait;
        let mut lines = self.take_streamed();
        loop {
            match self.line(deadline, "") {
                Ok(line) => lines.push(line),
                Err(Error::Timeout { .. }) => return Ok(lines),
                Err(error) => return Err(error),
            }
        }
    }

    /// What comes within `limit`, as it is, after what was left over: for whoever passes it on.
    pub(super) fn read_some(&mut self, limit: Duration) -> Result<Vec<u8>, Error> {
        let mut bytes = std::mem::take(&mut self.partial);
        self.socket.set_read_timeout(Some(limit)).map_err(Error::io("set the console's time limit"))?;
        let mut chunk = [0; 4096];
        match self.socket.read(&mut chunk) {
            Ok(0) => {
                let source = std::io::Error::from(ErrorKind::UnexpectedEof);
                Err(Error::Io { doing: "read the console".into(), source })
            }
            Ok(count) => {
                bytes.extend_from_slice(&chunk[..count]);
                Ok(bytes)
            }
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => Ok(bytes),
            Err(error) => Err(Error::io("read the console")(error)),
        }
    }

    /// One line, without its end.
    fn line(&mut self, deadline: Instant, expected: &str) -> Result<String, Error> {
        let started = Instant::now();
        loop {
            if let Some(end) = self.partial.iter().position(|&byte| byte == b'\n') {
                let mut line: Vec<u8> = self.partial.drain(..=end).collect();
                line.pop();
                if line.last() == Some(&b'\r') {
                    line.pop();
                }
                return Ok(String::from_utf8_lossy(&line).into_owned());
            }
            let now = Instant::now();
            if now >= deadline {
                return Err(Error::Timeout {
                    expected: expected.to_owned(),
                    waited: now - started,
                    received: String::from_utf8_lossy(&self.partial).into_owned(),
                });
            }
            self.socket
                .set_read_timeout(Some(deadline - now))
                .map_err(Error::io("set the console's time limit"))?;
            let mut chunk = [0; 4096];
            match self.socket.read(&mut chunk) {
                Ok(0) => {
                    let source = std::io::Error::from(ErrorKind::UnexpectedEof);
                    return Err(Error::Io { doing: "read the console".into(), source });
                }
                Ok(count) => self.partial.extend_from_slice(&chunk[..count]),
                Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {}
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(Error::io("read the console")(error)),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pair() -> (Console, UnixStream) {
        let (near, far) = UnixStream::pair().unwrap();
        (Console::new(near), far)
    }

    #[test]
    fn a_reply_is_told_from_the_stream_around_it() {
        let (mut console, mut board) = pair();
        board
            .write_all(b"R,20,1,2,3\n+ matrix=1,0,0\r\n+ matrix=0,1,0\nR,40,4,5,6\nok n=12 rms_ut=-\n")
            .unwrap();
        let reply = console.command("cal show").unwrap();
        assert_eq!(reply.info, ["matrix=1,0,0", "matrix=0,1,0"]);
        assert_eq!(reply.value("n"), Some("12"));
        assert_eq!(reply.value("rms_ut"), Some("-"));
        assert_eq!(reply.value("rms"), None);
        assert_eq!(reply.values("matrix").collect::<Vec<_>>(), ["1,0,0", "0,1,0"]);
        assert_eq!(console.take_streamed(), ["R,20,1,2,3", "R,40,4,5,6"]);
    }

    #[test]
    fn a_refusal_has_its_code_and_words() {
        let (mut console, mut board) = pair();
        board.write_all(b"err unknown no such command\n").unwrap();
        let reply = console.command("dance").unwrap();
        assert_eq!(reply.code(), Some("unknown"));
        assert_eq!(reply.to_string(), "err unknown no such command");
    }

    #[test]
    fn lines_outside_the_contract_are_named() {
        let (mut console, mut board) = pair();
        board.write_all(b"okay\n").unwrap();
        assert!(matches!(console.command("help"), Err(Error::Protocol { line, .. }) if line == "okay"));
    }

    #[test]
    fn silence_is_a_timeout_that_shows_what_came() {
        let (mut console, mut board) = pair();
        board.write_all(b"R,20,1").unwrap();
        let error = console.next_streamed(Duration::from_millis(20)).unwrap_err();
        assert!(matches!(error, Error::Timeout { received, .. } if received == "R,20,1"));
    }
}
