//! The board's I²C bus: simulated chips on it, and what goes wrong on the wire.

use crate::bus::{Chip, Clock, Direction};
use serde_json::{Value, json};
use std::cell::RefCell;
use std::rc::Rc;

/// What happens on the wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    /// A (repeated) start with an address.
    Start {
        /// The chip's.
        address: u8,
        /// What is wanted of it.
        direction: Direction,
    },
    /// A byte to the chip.
    Write(u8),
    /// A byte from the chip.
    Read,
    /// A stop.
    Stop,
}

/// What goes wrong with an event.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// It is not acknowledged.
    Nack,
    /// It comes so much later: a chip stretches the clock.
    Late {
        /// Nanoseconds.
        ns: u64,
    },
    /// It never comes to its end: a chip holds the clock.
    Hang,
}

type Script = Box<dyn FnMut(Event, u64) -> Option<Fault>>;

/// The bus.
pub struct Wire {
    clock: Clock,
    chips: Vec<Rc<RefCell<dyn Chip>>>,
    addressed: Option<Rc<RefCell<dyn Chip>>>,
    /// Decides about each event, at its time in nanoseconds.
    pub script: Script,
}

impl Wire {
    pub fn new() -> Self {
        Self { clock: Clock::default(), chips: Vec::new(), addressed: None, script: Box::new(|_, _| None) }
    }

    pub fn attach(&mut self, chip: Rc<RefCell<dyn Chip>>) {
        self.chips.push(chip);
    }

    pub fn detach(&mut self, address: u8) {
        self.chips.retain(|chip| chip.borrow().address() != address);
    }

    /// Lets the chips' time come to the board's.
    pub fn time(&self, ns: u64) {
        self.clock.advance_ns(ns.saturating_sub(self.clock.ns()));
    }

    /// The time.
    pub fn clock(&self) -> &Clock {
        &self.clock
    }

    /// Answers a question of the emulator.
    pub fn answer(&mut self, question: &Value) -> Value {
        let ns = question["ns"].as_f64().unwrap_or_default() as u64;
        self.time(ns);
        let byte = |key: &str| question[key].as_u64().unwrap_or_default() as u8;
        let event = match question["i2c"].as_str().unwrap_or_default() {
            "start" => {
                let is_read = question["read"].as_bool().unwrap_or_default();
                let direction = if is_read { Direction::Read } else { Direction::Write };
                Event::Start { address: byte("address"), direction }
            }
            "write" => Event::Write(byte("value")),
            "read" => Event::Read,
            _ => Event::Stop,
        };
        // The sensors are on the first bus; on the second there is nobody.
        let is_first = question["bus"].as_u64() == Some(0);
        match (self.script)(event, ns) {
            Some(Fault::Hang) => json!({ "hang": true }),
            Some(Fault::Nack) => {
                self.addressed = None;
                json!({ "ack": false })
            }
            Some(Fault::Late { ns }) => {
                let mut answer = self.carry_out(event, is_first);
                answer["lateNs"] = ns.into();
                answer
            }
            None => self.carry_out(event, is_first),
        }
    }

    fn carry_out(&mut self, event: Event, is_first: bool) -> Value {
        let Self { clock, chips, addressed, .. } = self;
        match event {
            Event::Start { address, direction } => {
                let chip = chips.iter().find(|chip| is_first && chip.borrow().address() == address).cloned();
                *addressed = chip.filter(|chip| chip.borrow_mut().start(direction, clock));
                json!({ "ack": addressed.is_some() })
            }
            Event::Write(byte) => {
                json!({ "ack": addressed.as_ref().is_some_and(|chip| chip.borrow_mut().write(byte)) })
            }
            Event::Read => {
                // Nobody pulls the line down.
                json!({ "value": addressed.as_ref().map_or(0xFF, |chip| chip.borrow_mut().read()) })
            }
            Event::Stop => {
                if let Some(chip) = addressed.take() {
                    chip.borrow_mut().stop(clock);
                }
                json!({})
            }
        }
    }
}
