//! The other end of a board's console: what is asked, what is answered, and the streams in between.

use super::wire::{Address, Trouble, Wire};
use std::collections::VecDeque;
use std::time::{Duration, Instant};

/// A longer line is none of a console's.
const MAX_LINE: usize = 4096;
/// How much of a foreign line is shown.
const SHOWN: usize = 60;

/// What a command was answered.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Reply {
    /// The lines that began with `+ `, without that mark.
    pub info: Vec<String>,
    /// The text after `ok`, or the refusal.
    pub outcome: Result<String, Refusal>,
}

/// An `err` line.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Refusal {
    /// `unknown`, `usage`, `long`, `busy`, `state`, `refused`, `sensor` or `store`.
    pub code: String,
    /// The words after it.
    pub text: String,
}

/// A line of a board.
enum Said {
    Info(String),
    Last(Result<String, Refusal>),
    Streamed(String),
    Foreign(String),
}

impl Said {
    fn of(line: String) -> Self {
        let after = |mark: &str| {
            let rest = line.strip_prefix(mark)?;
            if rest.is_empty() { Some(rest) } else { rest.strip_prefix(' ') }
        };
        if let Some(text) = line.strip_prefix("+ ") {
            Said::Info(text.to_string())
        } else if let Some(text) = after("ok") {
            Said::Last(Ok(text.to_string()))
        } else if let Some(text) = after("err") {
            let (code, text) = text.split_once(' ').unwrap_or((text, ""));
            Said::Last(Err(Refusal { code: code.to_string(), text: text.to_string() }))
        } else if ["R,", "C,", "L,", "H,", "Raw:"].iter().any(|mark| line.starts_with(mark)) {
            Said::Streamed(line)
        } else {
            Said::Foreign(line)
        }
    }
}

impl Reply {
    /// The reply that these lines are, streams and others left out; `None` where its last line is not among them.
    pub fn of(lines: impl IntoIterator<Item = String>) -> Option<Self> {
        let mut info = Vec::new();
        for line in lines {
            match Said::of(line) {
                Said::Info(text) => info.push(text),
                Said::Last(outcome) => return Some(Reply { info, outcome }),
                Said::Streamed(_) | Said::Foreign(_) => {}
            }
        }
        None
    }

    /// The last line as it was sent.
    pub fn closing(&self) -> String {
        match &self.outcome {
            Ok(text) if text.is_empty() => "ok".into(),
            Ok(text) => format!("ok {text}"),
            Err(refusal) => format!("err {} {}", refusal.code, refusal.text),
        }
    }

    /// The values named `key`, those of the last line first.
    pub fn values<'a>(&'a self, key: &'a str) -> impl Iterator<Item = &'a str> {
        let last = match &self.outcome {
            Ok(text) => text,
            Err(refusal) => &refusal.text,
        };
        std::iter::once(last)
            .chain(&self.info)
            .flat_map(|line| line.split(' '))
            .filter_map(move |word| word.strip_prefix(key)?.strip_prefix('='))
    }

    /// The first of [`Reply::values`].
    pub fn value<'a>(&'a self, key: &'a str) -> Option<&'a str> {
        self.values(key).next()
    }
}

/// What a board says of itself.
#[derive(Debug, Clone, PartialEq)]
pub struct Identity {
    /// The firmware's version.
    pub firmware: String,
    /// The board's name.
    pub board: String,
    /// The sensor's name.
    pub sensor: String,
    /// µT a count along each of the board's axes; `None` of a firmware that does not say.
    pub ut_per_count: Option<[f64; 3]>,
}

impl Identity {
    fn of(reply: &Reply) -> Option<Self> {
        let text = |key: &str| reply.value(key).map(str::to_string);
        Some(Identity {
            firmware: text("ironout")?,
            board: text("board")?,
            sensor: text("sensor")?,
            ut_per_count: reply.value("ut_per_count").and_then(scale),
        })
    }
}

/// Three positive numbers, in single precision as the board holds them.
fn scale(text: &str) -> Option<[f64; 3]> {
    let values: Option<Vec<f64>> = text
        .split(',')
        .map(|word| word.parse::<f32>().ok().filter(|v| v.is_finite() && *v > 0.0).map(f64::from))
        .collect();
    values?.try_into().ok()
}

/// A client of the console. Lines of a stream are kept apart from the replies, in their order.
pub struct Console {
    wire: Box<dyn Wire>,
    wait: Duration,
    partial: Vec<u8>,
    streamed: VecDeque<String>,
    not_text: bool,
}

impl Console {
    /// Over a wire that is open; each answer may take `wait`.
    pub fn new(wire: Box<dyn Wire>, wait: Duration) -> Self {
        Console { wire, wait, partial: Vec::new(), streamed: VecDeque::new(), not_text: false }
    }

    /// Opens the address and finds out who is there.
    ///
    /// # Errors
    /// What is wrong, with what to do.
    pub fn open(address: &Address, wait: Duration) -> crate::failure::Outcome<(Self, Identity)> {
        let mut console = Console::new(address.open(wait)?, wait);
        let identity = console.hello().map_err(|trouble| trouble.at(address))?;
        Ok((console, identity))
    }

    /// Asks who is there, whatever was said before: half a line of somebody else's, answers that nobody waited for, a stream.
    ///
    /// # Errors
    /// [`Trouble`], never that the board said no.
    pub fn hello(&mut self) -> Result<Identity, Trouble> {
        self.partial.clear();
        self.streamed.clear();
        self.not_text = false;
        self.send("\nversion")?;
        let deadline = Instant::now() + self.wait;
        let mut foreign = None;
        loop {
            match self.reply_until(deadline, &mut foreign) {
                Ok(reply) => {
                    if let Some(identity) = Identity::of(&reply) {
                        return Ok(identity);
                    }
                    foreign.get_or_insert_with(|| reply.closing());
                }
                Err(Trouble::Silent(waited)) => {
                    return Err(match foreign {
                        Some(line) => Trouble::Foreign(line),
                        None if self.not_text => Trouble::NotText,
                        None => Trouble::Silent(waited),
                    });
                }
                Err(other) => return Err(other),
            }
        }
    }

    /// Sends one command and waits for its reply.
    ///
    /// # Errors
    /// [`Trouble`], never that the board said no.
    pub fn command(&mut self, line: &str) -> Result<Reply, Trouble> {
        self.send(line)?;
        self.reply_until(Instant::now() + self.wait, &mut None)
    }

    /// The same of a command that has to be answered `ok`.
    ///
    /// # Errors
    /// [`Trouble`].
    pub fn ok(&mut self, line: &str) -> Result<Reply, Trouble> {
        let reply = self.command(line)?;
        match &reply.outcome {
            Ok(_) => Ok(reply),
            Err(refusal) => Err(Trouble::Refused {
                command: line.to_string(),
                answer: format!("{} {}", refusal.code, refusal.text),
            }),
        }
    }

    /// The next line of a stream, waiting for at most `limit`; `None` where none came.
    ///
    /// # Errors
    /// The wire is gone.
    pub fn next_streamed(&mut self, limit: Duration) -> Result<Option<String>, Trouble> {
        if let Some(line) = self.streamed.pop_front() {
            return Ok(Some(line));
        }
        let deadline = Instant::now() + limit;
        loop {
            match self.line(deadline) {
                // Half a line, or the answer to something that was given up.
                Ok(line) => {
                    if let Said::Streamed(line) = Said::of(line) {
                        return Ok(Some(line));
                    }
                }
                Err(Trouble::Silent(_)) => return Ok(None),
                Err(other) => return Err(other),
            }
        }
    }

    fn send(&mut self, line: &str) -> Result<(), Trouble> {
        self.wire
            .write(format!("{line}\n").as_bytes(), self.wait)
            .map_err(|error| Trouble::Gone(error.to_string()))
    }

    /// The next reply; `foreign` becomes the first line that is none of a console's.
    fn reply_until(&mut self, deadline: Instant, foreign: &mut Option<String>) -> Result<Reply, Trouble> {
        let mut info = Vec::new();
        loop {
            match Said::of(self.line(deadline)?) {
                Said::Info(text) => info.push(text),
                Said::Last(outcome) => return Ok(Reply { info, outcome }),
                Said::Streamed(line) => self.streamed.push_back(line),
                // A stream that was cut by noise on the line, or not a board's console at all.
                Said::Foreign(line) => {
                    foreign.get_or_insert_with(|| line.chars().take(SHOWN).collect());
                }
            }
        }
    }

    /// One line of printable ASCII, without its end; others are passed over.
    fn line(&mut self, deadline: Instant) -> Result<String, Trouble> {
        loop {
            if let Some(end) = self.partial.iter().position(|&byte| byte == b'\n') {
                let line: Vec<u8> = self.partial.drain(..=end).collect();
                let line = line.trim_ascii_end();
                match std::str::from_utf8(line) {
                    Ok(text) if line.iter().all(|byte| (0x20..=0x7e).contains(byte)) => {
                        if text.is_empty() {
                            continue;
                        }
                        return Ok(text.to_string());
                    }
                    _ => {
                        self.not_text = true;
                        continue;
                    }
                }
            }
            if self.partial.len() > MAX_LINE {
                self.not_text = true;
                self.partial.clear();
            }
            let left = deadline.saturating_duration_since(Instant::now());
            if left.is_zero() {
                self.not_text |= self.partial.iter().any(|byte| !byte.is_ascii());
                return Err(Trouble::Silent(self.wait));
            }
            let mut chunk = [0; 4096];
            let count = self.wire.read(&mut chunk, left).map_err(|error| Trouble::Gone(error.to_string()))?;
            self.partial.extend_from_slice(chunk.get(..count).unwrap_or_default());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io;

    /// Says what it is told to, in these pieces, whatever it hears; then nothing.
    struct Script(VecDeque<Vec<u8>>);

    impl Wire for Script {
        fn read(&mut self, into: &mut [u8], _: Duration) -> io::Result<usize> {
            match self.0.pop_front() {
                Some(piece) if piece.is_empty() => Err(io::ErrorKind::UnexpectedEof.into()),
                Some(piece) => {
                    into[..piece.len()].copy_from_slice(&piece);
                    Ok(piece.len())
                }
                None => Ok(0),
            }
        }
        fn write(&mut self, _: &[u8], _: Duration) -> io::Result<()> {
            Ok(())
        }
    }

    fn console(pieces: &[&[u8]]) -> Console {
        let pieces = pieces.iter().map(|piece| piece.to_vec()).collect();
        Console::new(Box::new(Script(pieces)), Duration::from_millis(30))
    }

    const VERSION: &[u8] =
        b"+ slots=empty,empty\n+ ut_per_count=0.1,0.1,0.2\nok ironout=0.1.0 board=mps2 sensor=LSM303DLHC\n";

    #[test]
    fn a_board_is_known_after_half_a_line_a_stream_and_the_answers_to_others() {
        let mut console =
            console(&[b"0,3\nR,20,1,2,3\nerr unknown no su", b"ch command; try help\n", VERSION]);
        let identity = console.hello().unwrap();
        assert_eq!((identity.board.as_str(), identity.sensor.as_str()), ("mps2", "LSM303DLHC"));
        assert_eq!(identity.ut_per_count, Some([0.1_f32, 0.1, 0.2].map(f64::from)));
        assert_eq!(console.next_streamed(Duration::ZERO).unwrap().as_deref(), Some("R,20,1,2,3"));
    }

    #[test]
    fn a_reply_is_told_from_the_stream_around_it() {
        let mut console =
            console(&[b"R,20,1,2,3\n+ matrix=1,0,0\r\n+ matr", b"ix=0,1,0\nR,4", b"0,4,5,6\nok n=12\n"]);
        let reply = console.ok("cal show").unwrap();
        assert_eq!(reply.values("matrix").collect::<Vec<_>>(), ["1,0,0", "0,1,0"]);
        assert_eq!(
            (reply.value("n"), reply.value("rms"), reply.closing().as_str()),
            (Some("12"), None, "ok n=12")
        );
        let next = |console: &mut Console| console.next_streamed(Duration::ZERO).unwrap();
        assert_eq!(next(&mut console).as_deref(), Some("R,20,1,2,3"));
        assert_eq!(next(&mut console).as_deref(), Some("R,40,4,5,6"));
        assert_eq!(next(&mut console), None);
    }

    #[test]
    fn what_is_no_board_is_told_by_what_it_says() {
        let silent = console(&[]).hello().unwrap_err();
        assert_eq!(silent, Trouble::Silent(Duration::from_millis(30)));
        let baud = console(&[&[0xf8, 0x80, 0x00, 0xfe, b'\n', 0xc0]]).hello().unwrap_err();
        assert_eq!(baud, Trouble::NotText);
        let other = console(&[b"login: \nPassword:\n"]).hello().unwrap_err();
        assert_eq!(other, Trouble::Foreign("login:".into()));
        let ended = console(&[b"R,1", b""]).hello().unwrap_err();
        assert!(matches!(ended, Trouble::Gone(_)));
        // A console of another program that answers as this one does.
        let strange = console(&[b"ok hello\n"]).hello().unwrap_err();
        assert_eq!(strange, Trouble::Foreign("ok hello".into()));
    }

    #[test]
    fn a_refusal_keeps_its_code_and_words() {
        let trouble = console(&[b"err state nothing is being collected\n"]).ok("cal stop").unwrap_err();
        let failure = trouble.at(&Address::Tcp("localhost:1".into()));
        assert!(failure.message.contains("`cal stop` with: err state nothing"), "{failure}");
        assert_eq!(failure.exit, 1);
    }
}
