//! Boards that are not there: the firmware in QEMU, and a simulated board in the field of a log.

#[cfg(unix)]
use crate::board::Address;
use crate::board::Wire;
use crate::cli::{HiddenArg, LogArgs};
use crate::commands::live::link::Link;
use crate::failure::{Failure, Outcome};
use crate::input::Log;
use crate::plausible::Known;
use crate::source;
use ironout_rig::board::SimBoard;
use std::any::Any;
use std::io;
use std::path::Path;
#[cfg(unix)]
use std::sync::Arc;
#[cfg(unix)]
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender};
#[cfg(unix)]
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// The board's time between two samples.
const SAMPLE_MS: u64 = 20;
/// How often the log's columns are fed.
const FEED_MS: u64 = 100;
/// The columns that a board tests at once.
const MOST_COLUMNS: usize = 3;

/// An emulator in its thread: hung up on and switched off when this goes.
#[cfg(unix)]
struct Running {
    link: Link,
    address: String,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

#[cfg(unix)]
impl Drop for Running {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        self.link.end();
        // It may be waiting for a client.
        drop(std::net::TcpStream::connect(&self.address));
        if let Some(thread) = self.thread.take() {
            // A board that has failed has said so.
            let _ = thread.join();
        }
    }
}

/// The firmware in QEMU; its sensor turns with every sample that it streams.
#[cfg(unix)]
pub fn emulated(wait: Duration, hidden: Option<HiddenArg>) -> Outcome<(Link, Box<dyn Any>)> {
    use crate::turned::Turned;
    use ironout_rig::qemu::{self, Emulator, Error, Firmware, Options};
    use ironout_simulation::{World, WorldOptions};
    /// The world's time between two samples, s: twice as fast as by hand.
    const STEP_S: f64 = 0.04;
    let failed = |error: Error| Failure::usage(error.to_string());
    if hidden == Some(HiddenArg::Current) {
        return Err(Failure::usage(
            "--hidden current: the emulated board does not know its current. Use temperature or step, or --replay a log \
             that has the column",
        ));
    }
    let mut turned = hidden.map(Turned::new).transpose()?;
    if !qemu::installed() {
        return Err(failed(Error::NotInstalled));
    }
    eprintln!("Building the firmware for the emulated board (cargo fw-mps2; a minute the first time) …");
    let firmware = Firmware::build().map_err(failed)?;
    let options = Options {
        temperature_c: turned.as_ref().map_or(25.0, |turned| turned.column("temp_c")),
        ..Options::default()
    };
    let mut board = Emulator::start(&firmware, &options).map_err(failed)?;
    board.wait_for_samples().map_err(failed)?;
    // The emulated sensor knows no negative fields, so all of them are lifted above zero.
    let world = World::new(WorldOptions {
        seed: 2014,
        field_ut: 48.0,
        hard_iron_ut: Some([93.0; 3]),
        soft_iron: Some([[1.10, 0.04, -0.03], [0.02, 0.96, 0.05], [-0.04, 0.03, 0.92]]),
        seconds: 600.0,
        ..WorldOptions::default()
    });
    let first = turned.as_ref().map_or_else(|| world.sensor_ut(0.0), Turned::field_ut);
    board.set_field_ut(first).map_err(failed)?;
    let io = |error: io::Error| Failure::usage(format!("no port for the emulated board: {error}"));
    let listener = std::net::TcpListener::bind("127.0.0.1:0").map_err(io)?;
    let address = listener.local_addr().map_err(io)?.to_string();
    let stop = Arc::new(AtomicBool::new(false));
    let stopped = Arc::clone(&stop);
    let thread = std::thread::spawn(move || {
        let mut turn = |board: &mut Emulator, line: &str, sample: u64| {
            let Some(turned) = &mut turned else {
                return board.set_field_ut(world.sensor_ut((sample as f64 * STEP_S) % 600.0));
            };
            if line.starts_with("C,") {
                // What is corrected was calibrated in peace.
                turned.work();
            }
            turned.turn(1);
            board.pause()?;
            board.put_field_ut(turned.field_ut())?;
            board.set_temperature_c(turned.column("temp_c"))?;
            board.resume()
        };
        while !stopped.load(Ordering::Relaxed) && board.serve(&listener, &mut turn).is_ok() {}
    });
    let tcp = Address::Tcp(address.clone());
    let link = Link::keep("the board in QEMU".into(), wait, move || tcp.open(wait));
    let running = Running { link: link.clone(), address, stop, thread: Some(thread) };
    Ok((link, Box::new(running)))
}

/// There is no such board.
#[cfg(not(unix))]
pub fn emulated(_wait: Duration, _hidden: Option<HiddenArg>) -> Outcome<(Link, Box<dyn Any>)> {
    Err(Failure::usage("the emulated board runs on Unix only"))
}

/// A simulated board in the field of a log, fed its columns, at so many times the log's own pace.
pub fn replay(path: &Path, speed: f64) -> Outcome<Link> {
    let arguments = LogArgs::of(path);
    let (log, _) = source::read_held(&arguments, None, &Known::Earth, false)?;
    if log.time_s.is_none() || log.rows == 0 {
        return Err(Failure::usage("a log without a time column cannot be replayed").in_file(path));
    }
    let name = format!("the replay of {}", path.display());
    Ok(Link::keep(name, Duration::from_secs(10), move || {
        let (to_board, heard) = mpsc::channel();
        let (says, from_board) = mpsc::channel();
        let log = log.clone();
        std::thread::spawn(move || play(log, speed, &heard, &says));
        Ok(Box::new(Played { to_board, from_board, rest: Vec::new() }))
    }))
}

/// The row of a log at a time since its beginning.
fn row_at(time_s: &[f64], t_s: f64) -> usize {
    let first = time_s.first().copied().unwrap_or(0.0);
    time_s.partition_point(|time| time - first <= t_s).saturating_sub(1)
}

/// Runs the board until nobody listens. At its end the log begins again: the board goes on, and keeps what it has learned.
fn play(log: Log, speed: f64, heard: &Receiver<Vec<u8>>, says: &Sender<Vec<u8>>) {
    let time_s = log.time_s.clone().unwrap_or_default();
    let length_s = time_s.first().zip(time_s.last()).map_or(0.0, |(first, last)| last - first);
    let (own_time, field) = (time_s.clone(), log.field_ut.clone());
    let mut board = SimBoard::new(
        move |t_s: f64| {
            let row = row_at(&own_time, t_s % length_s);
            field.each_ref().map(|axis| axis.get(row).copied().unwrap_or(0.0))
        },
        0.0,
        1,
    );
    let columns: Vec<_> = log.covariates.iter().take(MOST_COLUMNS).collect();
    let begun = Instant::now();
    let mut now_ms = 0;
    loop {
        if now_ms % FEED_MS == 0 && !columns.is_empty() {
            let row = row_at(&time_s, (now_ms as f64 / 1000.0) % length_s);
            for column in &columns {
                let value = column.values.get(row).copied().filter(|value| value.is_finite());
                let value = value.map_or("-".to_string(), |value| format!("{value:.4}"));
                // Its answers are nobody's; the samples of that moment go on.
                for line in board.command(&format!("cov {}={value}", column.name)) {
                    if ["R,", "C,", "L,", "H,"].iter().any(|mark| line.starts_with(mark))
                        && says.send(format!("{line}\n").into_bytes()).is_err()
                    {
                        return;
                    }
                }
            }
        }
        board.run_ms(SAMPLE_MS);
        now_ms += SAMPLE_MS;
        loop {
            let text: String = board.received().iter().map(|line| format!("{line}\n")).collect();
            if !text.is_empty() && says.send(text.into_bytes()).is_err() {
                return;
            }
            let left = (begun + Duration::from_millis(now_ms).div_f64(speed))
                .saturating_duration_since(Instant::now());
            match heard.recv_timeout(left) {
                Ok(bytes) => board.send(&bytes),
                Err(RecvTimeoutError::Timeout) => break,
                Err(RecvTimeoutError::Disconnected) => return,
            }
        }
    }
}

/// The wire to a board that is played.
struct Played {
    to_board: Sender<Vec<u8>>,
    from_board: Receiver<Vec<u8>>,
    rest: Vec<u8>,
}

impl Wire for Played {
    fn read(&mut self, into: &mut [u8], limit: Duration) -> io::Result<usize> {
        if self.rest.is_empty() {
            match self.from_board.recv_timeout(limit) {
                Ok(bytes) => self.rest = bytes,
                Err(RecvTimeoutError::Timeout) => return Ok(0),
                Err(RecvTimeoutError::Disconnected) => {
                    return Err(io::Error::other("the replay has stopped and restarts"));
                }
            }
        }
        let count = self.rest.len().min(into.len());
        into.iter_mut().zip(self.rest.drain(..count)).for_each(|(slot, byte)| *slot = byte);
        Ok(count)
    }

    fn write(&mut self, bytes: &[u8], _: Duration) -> io::Result<()> {
        self.to_board.send(bytes.to_vec()).map_err(|_| io::Error::other("the replay has stopped"))
    }
}
