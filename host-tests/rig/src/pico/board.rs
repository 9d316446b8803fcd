//! The Pico as a board on the bench.

use super::error::Error;
use super::node::Node;
use super::wire::{Event, Fault, Wire};
use crate::bus::{Chip, Clock};
use crate::reply::{Line, Reply};
use serde_json::{Value, json};
use std::cell::RefCell;
use std::collections::{BTreeMap, VecDeque};
use std::path::Path;
use std::rc::Rc;

/// How long a reply may take: the contract's 2 s, by the board's own clock.
const REPLY_LIMIT_MS: u64 = 2_000;

/// Cycles of the core in a microsecond.
pub const CYCLES_PER_US: f64 = 125.0;
/// The button, to ground.
pub const BUTTON_PIN: u8 = 15;
/// The light.
pub const LIGHT_PIN: u8 = 25;
/// The I²C bus' data.
pub const DATA_PIN: u8 = 4;
/// The I²C bus' clock.
pub const CLOCK_PIN: u8 = 5;
/// Where in the flash the slots of the calibration begin, and bytes from one to the next.
pub const SLOTS: u32 = 2 * 1024 * 1024 - 2 * SLOT_STRIDE;
/// A sector.
pub const SLOT_STRIDE: u32 = 4096;

/// An end of the console.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Port {
    /// UART 0.
    Uart,
    /// The serial port on USB.
    Usb,
}

impl Port {
    const fn name(self) -> &'static str {
        match self {
            Port::Uart => "uart",
            Port::Usb => "usb",
        }
    }
}

/// Why a run came to its end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// The time was over, or what was waited for has come.
    Time,
    /// The power failed in the middle of an operation of the flash ([`Pico::cut_power_in_flash`]).
    Power,
}

/// A change of a pin that the board drives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PinChange {
    /// The pin's number.
    pub pin: u8,
    /// Its level; `None` where the board lets it go.
    pub level: Option<bool>,
    /// When.
    pub ms: f64,
}

/// What the emulator counts.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    /// Time since the board was made.
    pub ms: f64,
    /// Cycles in which the core did not sleep.
    pub cycles: f64,
    /// Instructions executed.
    pub instructions: f64,
    /// The causes of the resets, in their order.
    pub resets: Vec<String>,
    /// The last hard fault.
    pub fault: Option<String>,
    /// Bytes that the UART lost because nobody fetched them.
    pub overruns: u64,
    /// Sectors erased and pages programmed.
    pub flash_operations: u64,
}

/// Calls of a function that was watched.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Calls {
    /// How many.
    pub count: u64,
    /// Cycles of one in the mean, those of interrupts in it too.
    pub mean_cycles: f64,
    /// Of the longest.
    pub worst_cycles: f64,
}

/// What has come on a port.
#[derive(Default)]
struct Received {
    partial: String,
    lines: VecDeque<String>,
    streamed: Vec<String>,
}

/// A Pico with power on.
pub struct Pico {
    node: Node,
    wire: Wire,
    received: BTreeMap<Port, Received>,
    pins: Vec<PinChange>,
    /// The port that [`Self::command`] uses.
    pub port: Port,
}

impl Pico {
    /// A new board with this image (ELF or UF2) in its flash, and the power on. Nothing has run yet.
    pub fn start(image: &Path) -> Result<Self, Error> {
        let node = Node::start(image)?;
        let received = BTreeMap::from([(Port::Uart, Received::default()), (Port::Usb, Received::default())]);
        Ok(Self { node, wire: Wire::new(), received, pins: Vec::new(), port: Port::Uart })
    }

    fn request(&mut self, request: &Value) -> Result<Value, Error> {
        let Self { node, wire, .. } = self;
        node.ask(request, |question| wire.answer(question))
    }

    /// Puts a chip on the I²C bus; the caller may keep a handle to it.
    pub fn attach(&mut self, chip: Rc<RefCell<dyn Chip>>) {
        self.wire.attach(chip);
    }

    /// Takes the chip at `address` off the bus.
    pub fn detach(&mut self, address: u8) {
        self.wire.detach(address);
    }

    /// The time that the chips see.
    pub fn clock(&self) -> &Clock {
        self.wire.clock()
    }

    /// From now on `script` decides what goes wrong on the I²C bus, given the event and its time in nanoseconds.
    pub fn set_faults(&mut self, script: impl FnMut(Event, u64) -> Option<Fault> + 'static) {
        self.wire.script = Box::new(script);
    }

    /// Nothing goes wrong on the bus any more.
    pub fn clear_faults(&mut self) {
        self.set_faults(|_, _| None);
    }

    /// Lets the board run.
    ///
    /// # Errors
    /// [`Error::Stopped`] where the core has locked up.
    pub fn run_ms(&mut self, ms: u64) -> Result<Ended, Error> {
        self.run(ms * 1_000_000, None)
    }

    fn run(&mut self, ns: u64, lines: Option<u64>) -> Result<Ended, Error> {
        let run = self.request(&json!({ "do": "run", "ns": ns, "lines": lines }))?;
        self.wire.time(run["ns"].as_f64().unwrap_or_default() as u64);
        for (port, received) in &mut self.received {
            received.partial.push_str(run[port.name()].as_str().unwrap_or_default());
            while let Some(end) = received.partial.find('\n') {
                let rest = received.partial.split_off(end + 1);
                let line = std::mem::replace(&mut received.partial, rest);
                received.lines.push_back(line.trim_end_matches(['\n', '\r']).to_owned());
            }
        }
        self.pins.extend(run["pins"].as_array().into_iter().flatten().map(|change| PinChange {
            pin: change[0].as_u64().unwrap_or_default() as u8,
            level: change[1].as_bool(),
            ms: change[2].as_f64().unwrap_or_default() / 1e6,
        }));
        match run["ended"].as_str() {
            Some("power") => Ok(Ended::Power),
            Some("lockup") => Err(Error::Stopped("a fault in the handler of a fault locks the core up")),
            _ => Ok(Ended::Time),
        }
    }

    /// Sends bytes as they are.
    pub fn send(&mut self, port: Port, bytes: &[u8]) -> Result<(), Error> {
        let text: String = bytes.iter().map(|&byte| char::from(byte)).collect();
        self.request(&json!({ "do": "send", "port": port.name(), "text": text })).map(drop)
    }

    /// Sends one command and waits for its reply.
    ///
    /// # Errors
    /// [`Error::Timeout`] without a complete reply within the contract's 2 s of the board; [`Error::Protocol`] for a line that is
    /// neither reply nor stream; [`Error::Stopped`] where the power failed.
    pub fn command(&mut self, command: &str) -> Result<Reply, Error> {
        self.send(self.port, format!("{command}\n").as_bytes())?;
        self.reply(command)
    }

    /// Waits for the reply to what was sent with [`Self::send`]; `sent` is for the error message.
    pub fn reply(&mut self, sent: &str) -> Result<Reply, Error> {
        let mut info = Vec::new();
        let end_ns = self.clock().ns() + REPLY_LIMIT_MS * 1_000_000;
        loop {
            let line = self.line(end_ns, &format!("the reply to `{sent}`"))?;
            match Line::of(&line) {
                Line::Streamed => self.at_port().streamed.push(line),
                Line::Info(text) => info.push(text.to_owned()),
                Line::Closing(outcome) => return Ok(Reply { info, outcome }),
                Line::Unknown => return Err(Error::Protocol(line)),
            }
        }
    }

    /// The next unasked line, waiting for it if there is none yet.
    pub fn next_streamed(&mut self, limit_ms: u64) -> Result<String, Error> {
        if !self.at_port().streamed.is_empty() {
            return Ok(self.at_port().streamed.remove(0));
        }
        let line = self.line(self.clock().ns() + limit_ms * 1_000_000, "a line of the stream")?;
        if Line::of(&line) == Line::Streamed { Ok(line) } else { Err(Error::Protocol(line)) }
    }

    /// The unasked lines that have come, oldest first.
    pub fn take_streamed(&mut self) -> Vec<String> {
        let received = self.at_port();
        let mut lines = std::mem::take(&mut received.streamed);
        lines.extend(received.lines.drain(..));
        lines
    }

    fn at_port(&mut self) -> &mut Received {
        self.received.entry(self.port).or_default()
    }

    fn line(&mut self, end_ns: u64, expected: &str) -> Result<String, Error> {
        let begun_ns = self.clock().ns();
        loop {
            if let Some(line) = self.at_port().lines.pop_front() {
                return Ok(line);
            }
            let now_ns = self.clock().ns();
            if now_ns >= end_ns {
                return Err(Error::Timeout {
                    expected: expected.to_owned(),
                    limit_ms: (end_ns - begun_ns.min(end_ns)) / 1_000_000,
                    received: self.at_port().partial.clone(),
                });
            }
            if self.run(end_ns - now_ns, Some(1))? == Ended::Power {
                return Err(Error::Stopped("its power failed"));
            }
        }
    }

    /// Sets what the converter finds at a channel, 0 to 4095 counts of 3.3 V: channel 0 is GP26, channel 4 the processor's temperature.
    pub fn set_analog(&mut self, channel: u8, counts: u16) -> Result<(), Error> {
        self.request(&json!({ "do": "analog", "channel": channel, "counts": counts })).map(drop)
    }

    /// Sets a pin from outside; `None` lets it go, and its pull-up raises it.
    pub fn drive(&mut self, pin: u8, level: Option<bool>) -> Result<(), Error> {
        self.request(&json!({ "do": "pin", "pin": pin, "level": level })).map(drop)
    }

    /// Presses the button for so long.
    pub fn press_ms(&mut self, ms: u64) -> Result<(), Error> {
        self.drive(BUTTON_PIN, Some(false))?;
        self.run_ms(ms)?;
        self.drive(BUTTON_PIN, None)
    }

    /// The changes of pins since this was asked last.
    pub fn take_pins(&mut self) -> Vec<PinChange> {
        std::mem::take(&mut self.pins)
    }

    /// The power fails during flash operation number `after` from now (0: the next), at a point in it that `seed` decides.
    pub fn cut_power_in_flash(&mut self, after: u64, seed: u32) -> Result<(), Error> {
        self.request(&json!({ "do": "cut", "after": after, "seed": seed })).map(drop)
    }

    /// Power off and on: the flash keeps what it held, and nothing else does.
    pub fn power_cycle(&mut self) -> Result<(), Error> {
        self.received.values_mut().for_each(|received| *received = Received::default());
        self.request(&json!({ "do": "power" })).map(drop)
    }

    /// What the emulator counts.
    pub fn state(&mut self) -> Result<State, Error> {
        let state = self.request(&json!({ "do": "state" }))?;
        let number = |key: &str| state[key].as_f64().unwrap_or_default();
        let resets = state["resets"].as_array().into_iter().flatten();
        Ok(State {
            ms: number("ns") / 1e6,
            cycles: number("cycles"),
            instructions: number("instructions"),
            resets: resets.filter_map(|reset| reset["cause"].as_str().map(str::to_owned)).collect(),
            fault: state["fault"].as_str().map(str::to_owned),
            overruns: number("overruns") as u64,
            flash_operations: number("operations") as u64,
        })
    }

    /// Counts the calls of the function at `address` from now on, until another one is watched.
    pub fn watch(&mut self, address: u64) -> Result<(), Error> {
        self.request(&json!({ "do": "watch", "address": address })).map(drop)
    }

    /// The calls of the function that is watched, so far.
    pub fn watched(&mut self) -> Result<Calls, Error> {
        let state = self.request(&json!({ "do": "state" }))?;
        let number = |key: &str| state["watched"][key].as_f64().unwrap_or_default();
        let count = number("calls");
        let mean_cycles = number("cycles") / count.max(1.0);
        Ok(Calls { count: count as u64, mean_cycles, worst_cycles: number("worst") })
    }

    /// Copies bytes of the board's memory.
    pub fn memory(&mut self, address: u64, length: u64) -> Result<Vec<u8>, Error> {
        let hex = self.request(&json!({ "do": "memory", "address": address, "length": length }))?;
        let hex = hex.as_str().unwrap_or_default().as_bytes();
        let nibble = |digit: u8| char::from(digit).to_digit(16).unwrap_or_default() as u8;
        Ok(hex.chunks_exact(2).map(|pair| nibble(pair[0]) << 4 | nibble(pair[1])).collect())
    }

    /// Overwrites bytes of the board's memory.
    pub fn set_memory(&mut self, address: u64, bytes: &[u8]) -> Result<(), Error> {
        self.request(&json!({ "do": "poke", "address": address, "bytes": hex(bytes) })).map(drop)
    }

    /// Overwrites bytes of the flash, from `at` on from its beginning.
    pub fn set_flash(&mut self, at: u32, bytes: &[u8]) -> Result<(), Error> {
        self.request(&json!({ "do": "flash", "at": at, "bytes": hex(bytes) })).map(drop)
    }

    /// Sets the core's program counter, or its stack pointer, as a fault of the program would.
    pub fn jump(&mut self, pc: Option<u32>, sp: Option<u32>) -> Result<(), Error> {
        self.request(&json!({ "do": "jump", "pc": pc, "sp": sp })).map(drop)
    }
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}
