//! Following a board's stream, through pulled cables and restarts.

use super::rows::Rows;
use crate::board::{Address, Console, Identity, Streamed, Trouble};
use crate::failure::{Failure, Outcome};
use crate::interrupt::Interrupt;
use crate::progress::Counting;
use std::io::Write;
use std::time::{Duration, Instant};

/// How long a line is waited for before Ctrl-C is looked at again.
const GLANCE: Duration = Duration::from_millis(200);
/// Pause between two attempts to find a disconnected board.
const PAUSE: Duration = Duration::from_millis(300);

/// Why it ended.
#[derive(Debug, Clone, PartialEq)]
pub enum End {
    /// As long as asked for, or Ctrl-C.
    Asked,
    /// The board was gone for longer than the patience.
    Gone(Failure),
}

/// How long, and how patient.
#[derive(Debug, Clone, Copy)]
pub struct Plan {
    /// Seconds of the board's clock; without end where there are none.
    pub seconds: Option<f64>,
    /// How long to wait for a disconnected board.
    pub patience: Duration,
    /// How long an answer, or the next sample, may take.
    pub wait: Duration,
}

/// A board that is followed.
pub struct Follower<'a> {
    /// Where it is.
    pub address: &'a Address,
    /// Who it is: another one is not taken for it.
    pub identity: &'a Identity,
    /// How long.
    pub plan: Plan,
    /// Ctrl-C.
    pub interrupt: Interrupt,
    /// A sign of life.
    pub progress: Counting,
    /// How often the board was found again.
    pub reconnects: u32,
}

/// What ended a stretch of the stream.
enum Stretch {
    Asked,
    Lost(Trouble),
}

impl Follower<'_> {
    /// Writes rows until there are enough.
    ///
    /// # Errors
    /// The rows cannot be written; the first answer to `stream log` was no; another board answers.
    pub fn follow(&mut self, mut console: Console, rows: &mut Rows, out: &mut impl Write) -> Outcome<End> {
        let mut last_seen = Instant::now();
        // Refused at once: the sensor does not work, or the firmware does not know this stream.
        console.ok("stream log").map_err(|trouble| trouble.at(self.address))?;
        loop {
            let trouble = match self.stretch(&mut console, rows, out, &mut last_seen)? {
                Stretch::Asked => {
                    // A courtesy: whoever is gone streams no more.
                    let _ = console.command("stream off");
                    return Ok(End::Asked);
                }
                Stretch::Lost(trouble) => trouble,
            };
            self.progress.note(&format!("{}; waiting for it", trouble.at(self.address).message));
            match self.again(console, last_seen, trouble)? {
                Ok(found) => console = found,
                Err(end) => return Ok(end),
            }
            self.reconnects += 1;
            self.progress.note(&format!("{}: the board is back", self.address));
        }
    }

    /// Reads the stream for as long as it comes.
    fn stretch(
        &mut self,
        console: &mut Console,
        rows: &mut Rows,
        out: &mut impl Write,
        last_seen: &mut Instant,
    ) -> Outcome<Stretch> {
        let mut silent_since = Instant::now();
        loop {
            if self.interrupt.is_asked() {
                return Ok(Stretch::Asked);
            }
            let line = match console.next_streamed(GLANCE.min(self.plan.wait)) {
                Ok(Some(line)) => line,
                Ok(None) if silent_since.elapsed() >= self.plan.wait => {
                    return Ok(Stretch::Lost(Trouble::Silent(self.plan.wait)));
                }
                Ok(None) => continue,
                Err(trouble) => return Ok(Stretch::Lost(trouble)),
            };
            match Streamed::parse(&line) {
                Some(Streamed::Columns(columns)) => rows.columns(columns),
                Some(Streamed::Row(row)) => {
                    let away_ms = u64::try_from(last_seen.elapsed().as_millis()).unwrap_or(u64::MAX);
                    let written = rows.row(&row, away_ms, out);
                    written.map_err(|error| Failure::usage(format!("cannot write the log: {error}")))?;
                    *last_seen = Instant::now();
                }
                // Cut on its way: missed by its number.
                None => {}
            }
            silent_since = Instant::now();
            let tally = rows.tally();
            let seconds = tally.length_ms as f64 / 1000.0;
            if self.plan.seconds.is_some_and(|enough| seconds >= enough) {
                return Ok(Stretch::Asked);
            }
            self.progress.say(&format!(
                "{} samples, {seconds:.1} s of the board's clock, {} lost (Ctrl-C ends)",
                tally.samples, tally.lost
            ));
        }
    }

    /// Finds the board again; the end where the patience or the user gives up first.
    fn again(&self, console: Console, since: Instant, trouble: Trouble) -> Outcome<Result<Console, End>> {
        // A wire that is only silent may be spoken to again, and a serial port is opened by one at a time.
        let mut open = (!matches!(trouble, Trouble::Gone(_))).then_some(console);
        let mut last = trouble;
        loop {
            if self.interrupt.is_asked() {
                return Ok(Err(End::Asked));
            }
            let console = match open.take() {
                Some(console) => Some(console),
                None => self.address.open(self.plan.wait).ok().map(|wire| Console::new(wire, self.plan.wait)),
            };
            if let Some(mut console) = console {
                match console.hello() {
                    Ok(who) if who != *self.identity => return Err(self.another(&who)),
                    Ok(_) => match console.ok("stream log") {
                        Ok(_) => return Ok(Ok(console)),
                        // The sensor does not work just now.
                        Err(trouble) => last = trouble,
                    },
                    Err(trouble) => last = trouble,
                }
                open = (!matches!(last, Trouble::Gone(_))).then_some(console);
            }
            if since.elapsed() >= self.plan.patience {
                return Ok(Err(End::Gone(last.at(self.address))));
            }
            std::thread::sleep(PAUSE);
        }
    }

    fn another(&self, who: &Identity) -> Failure {
        Failure::usage(format!(
            "{}: another board answers: {} ({}) instead of {} ({}), or its firmware or scale has changed",
            self.address, who.board, who.sensor, self.identity.board, self.identity.sensor
        ))
    }
}
