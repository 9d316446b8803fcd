//! The simulated board behind a TCP port, for programs that speak to a board.
//!
//! Its clock is virtual and goes by what is said: each command takes it [`SAMPLE_MS`], and while it streams it runs for as
//! long as somebody reads. What it says does not depend on how fast the machine is.

use crate::board::SimBoard;
use std::collections::VecDeque;
use std::io::{self, ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::sync::mpsc::{self, Receiver, Sender, TryRecvError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

/// The board's time between two samples, ms: how long it runs for each command, and at a time while it streams.
pub const SAMPLE_MS: u64 = 20;
/// As much of a stream waits for a slow reader; then the board's clock does.
const MOST_WAITING: usize = 4096;
/// How long the thread sleeps where there is nothing to do.
const NAP: Duration = Duration::from_millis(1);

/// Something to be done to the board, in its own thread.
type Hand = Box<dyn FnOnce(&mut Bench) + Send>;

/// The board and its cable.
pub struct Bench {
    /// The board.
    pub board: SimBoard,
    client: Option<TcpStream>,
    plugged: bool,
    waiting: Vec<u8>,
    /// How often the clock's seconds go into one of the world's while it streams, since when, and from what time on.
    pace: Option<(f64, Instant, u64)>,
    deaf: bool,
    /// What is to be done once the board's clock shows so many ms, in that order.
    planned: VecDeque<(u64, Hand)>,
}

impl Bench {
    /// Does this once the board's clock ([`SimBoard::clock`]) shows `ms`: in the board's own time, however busy the machine is.
    /// Plans are carried out in the order in which they were made.
    pub fn plan(&mut self, ms: u64, hand: impl FnOnce(&mut Bench) + Send + 'static) {
        self.planned.push_back((ms, Box::new(hand)));
    }

    fn carry_out_plans(&mut self) {
        while self.planned.front().is_some_and(|(ms, _)| self.board.clock.ms() >= *ms) {
            if let Some((_, hand)) = self.planned.pop_front() {
                hand(self);
            }
        }
    }

    /// From now on the board streams at so many of its seconds in one of the world's: for whoever looks at it meanwhile.
    pub fn pace(&mut self, times: f64) {
        self.pace = Some((times, Instant::now(), self.board.clock.ms()));
    }

    /// As if its program had stopped: it neither hears nor speaks, and the cable is in.
    pub fn deafen(&mut self, deaf: bool) {
        self.deaf = deaf;
    }

    /// Whether the next sample is due.
    fn is_due(&self) -> bool {
        self.pace.is_none_or(|(times, since, from_ms)| {
            let run_ms = self.board.clock.ms().saturating_sub(from_ms);
            (run_ms as f64) < since.elapsed().as_secs_f64() * 1e3 * times
        })
    }

    /// Pulls the cable: the connection ends, and no other one is taken until it is plugged in.
    pub fn pull(&mut self) {
        self.plugged = false;
        self.client = None;
        self.waiting.clear();
    }

    /// Plugs it in again.
    pub fn plug(&mut self) {
        self.plugged = true;
    }
}

/// A board that is served.
pub struct Served {
    address: SocketAddr,
    hands: Option<Sender<Hand>>,
    thread: Option<JoinHandle<()>>,
}

impl Served {
    /// Serves the board that `make` gives, at a port of its own.
    ///
    /// # Errors
    /// There is no port.
    pub fn start(make: impl FnOnce() -> SimBoard + Send + 'static) -> io::Result<Self> {
        let listener = TcpListener::bind("127.0.0.1:0")?;
        listener.set_nonblocking(true)?;
        let address = listener.local_addr()?;
        let (hands, asked) = mpsc::channel();
        let thread = thread::spawn(move || {
            let bench = Bench {
                board: make(),
                client: None,
                plugged: true,
                waiting: Vec::new(),
                pace: None,
                deaf: false,
                planned: VecDeque::new(),
            };
            serve(bench, &listener, &asked);
        });
        Ok(Self { address, hands: Some(hands), thread: Some(thread) })
    }

    /// `HOST:PORT`.
    pub fn address(&self) -> String {
        self.address.to_string()
    }

    /// Does something to the board between two of its turns; `None` where the board has ended.
    pub fn with<R: Send + 'static>(&self, hand: impl FnOnce(&mut Bench) -> R + Send + 'static) -> Option<R> {
        let (done, result) = mpsc::channel();
        let hand: Hand = Box::new(move |bench| {
            // Whoever asked waits for it.
            let _ = done.send(hand(bench));
        });
        self.hands.as_ref()?.send(hand).ok()?;
        result.recv().ok()
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        self.hands = None;
        if let Some(thread) = self.thread.take() {
            // A board that has failed has said so.
            let _ = thread.join();
        }
    }
}

fn serve(mut bench: Bench, listener: &TcpListener, asked: &Receiver<Hand>) {
    loop {
        match asked.try_recv() {
            Ok(hand) => hand(&mut bench),
            Err(TryRecvError::Disconnected) => return,
            Err(TryRecvError::Empty) => {}
        }
        if bench.plugged
            && let Ok((client, _)) = listener.accept()
            && client.set_nonblocking(true).is_ok()
        {
            bench.client = Some(client);
            bench.waiting.clear();
        }
        bench.carry_out_plans();
        let busy = turn(&mut bench).unwrap_or_else(|_| {
            // The other side is gone.
            bench.client = None;
            bench.waiting.clear();
            false
        });
        if !busy {
            thread::sleep(NAP);
        }
    }
}

/// Whether there was something to do.
fn turn(bench: &mut Bench) -> io::Result<bool> {
    if bench.deaf {
        return Ok(false);
    }
    let due = bench.is_due();
    let Bench { board, client: Some(client), waiting, .. } = bench else { return Ok(false) };
    let mut chunk = [0; 512];
    let heard = match client.read(&mut chunk) {
        Ok(0) => return Err(ErrorKind::UnexpectedEof.into()),
        Ok(count) => &chunk[..count],
        Err(error) if error.kind() == ErrorKind::WouldBlock => &[],
        Err(error) => return Err(error),
    };
    for byte in heard {
        board.send(std::slice::from_ref(byte));
        if *byte == b'\n' {
            board.run_ms(SAMPLE_MS);
        }
    }
    if heard.is_empty() && due && board.device.streams() && waiting.len() < MOST_WAITING {
        board.run_ms(SAMPLE_MS);
    }
    for line in board.received() {
        waiting.extend_from_slice(line.as_bytes());
        waiting.push(b'\n');
    }
    let mut written = false;
    while !waiting.is_empty() {
        match client.write(waiting) {
            Ok(0) => return Err(ErrorKind::WriteZero.into()),
            Ok(count) => {
                waiting.drain(..count);
                written = true;
            }
            Err(error) if error.kind() == ErrorKind::WouldBlock => break,
            Err(error) => return Err(error),
        }
    }
    Ok(written || !heard.is_empty())
}
