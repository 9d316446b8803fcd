//! The board of the demo: emulated where QEMU is, simulated where it is not. Both run the same application.

use crate::failure::{Failure, Outcome};
use ironout_rig::board::SimBoard;
use std::cell::Cell;
use std::rc::Rc;

/// What a command was answered: the lines in between, and the closing `ok …` or `err …`.
#[derive(Debug, Clone, PartialEq)]
pub struct Answer {
    /// The lines that began with `+ `, without that mark.
    pub info: Vec<String>,
    /// The closing line.
    pub closing: String,
}

impl Answer {
    /// Whether it was `ok`.
    pub fn is_ok(&self) -> bool {
        self.closing == "ok" || self.closing.starts_with("ok ")
    }

    /// The values named `key`, in their order.
    pub fn values<'a>(&'a self, key: &'a str) -> impl Iterator<Item = &'a str> {
        std::iter::once(&self.closing)
            .chain(&self.info)
            .flat_map(|line| line.split(' '))
            .filter_map(move |word| word.strip_prefix(key)?.strip_prefix('='))
    }
}

/// A board on the bench.
pub trait Bench {
    /// Sends one command.
    fn command(&mut self, line: &str) -> Outcome<Answer>;
    /// Puts the sensor into this field (µT) and gives the last line of the stream about it.
    fn expose(&mut self, field_ut: [f64; 3]) -> Outcome<String>;
    /// The chip has this temperature from now on.
    fn warm(&mut self, temp_c: f64) -> Outcome<()>;
    /// Takes the power away in the middle of everything, and gives it back.
    fn power_cut(self: Box<Self>) -> Outcome<Box<dyn Bench>>;
    /// The sensor's scale, µT a count along each axis.
    fn ut_per_count(&self) -> [f64; 3] {
        ironout_drivers::lsm303dlhc::Range::Gauss1_9.ut_per_count().map(f64::from)
    }
}

/// The simulated board: the same drivers and application over a simulated I²C bus.
pub struct Simulated {
    board: SimBoard,
    field_ut: Rc<Cell<[f64; 3]>>,
}

impl Simulated {
    /// Powered up, in a field that [`Bench::expose`] sets.
    pub fn start() -> Self {
        let field_ut = Rc::new(Cell::new([93.0; 3]));
        let seen = Rc::clone(&field_ut);
        let mut board = SimBoard::new(move |_| seen.get(), 0.0, 1);
        board.run_ms(100);
        Simulated { board, field_ut }
    }
}

impl Bench for Simulated {
    fn command(&mut self, line: &str) -> Outcome<Answer> {
        let mut lines = self.board.command(line);
        let closing = lines.pop().unwrap_or_default();
        let info = lines.iter().filter_map(|line| line.strip_prefix("+ ")).map(String::from).collect();
        Ok(Answer { info, closing })
    }

    fn expose(&mut self, field_ut: [f64; 3]) -> Outcome<String> {
        self.field_ut.set(field_ut);
        // The chip measures 75 times a second, the board looks 50 times: the second look has seen the new field.
        self.board.received();
        self.board.run_ms(40);
        let lines = self.board.received();
        lines.last().cloned().ok_or_else(|| Failure::refused("the simulated board sends no samples"))
    }

    fn warm(&mut self, temp_c: f64) -> Outcome<()> {
        self.board.mag.borrow_mut().temperature_c = temp_c;
        Ok(())
    }

    fn power_cut(mut self: Box<Self>) -> Outcome<Box<dyn Bench>> {
        self.board.restart();
        self.board.run_ms(100);
        Ok(self)
    }
}

#[cfg(unix)]
pub use emulated::Emulated;

#[cfg(unix)]
mod emulated {
    use super::{Answer, Bench};
    use crate::failure::{Failure, Outcome};
    use ironout_rig::qemu::{Emulator, Error, Firmware, Options};

    /// The firmware in QEMU.
    pub struct Emulated(Emulator);

    impl Emulated {
        /// Power on.
        pub fn start(firmware: &Firmware) -> Result<Self, Error> {
            Emulator::start(firmware, &Options::default()).map(Self)
        }
    }

    fn failed(error: Error) -> Failure {
        Failure::usage(format!("the emulated board: {error}"))
    }

    impl Bench for Emulated {
        fn command(&mut self, line: &str) -> Outcome<Answer> {
            let reply = self.0.console.command(line).map_err(failed)?;
            let text = reply.to_string();
            let closing = text.lines().last().unwrap_or_default().to_string();
            Ok(Answer { info: reply.info, closing })
        }

        fn expose(&mut self, field_ut: [f64; 3]) -> Outcome<String> {
            let lines = self.0.expose(field_ut).map_err(failed)?;
            lines.last().cloned().ok_or_else(|| Failure::refused("the emulated board sends no samples"))
        }

        fn warm(&mut self, temp_c: f64) -> Outcome<()> {
            self.0.set_temperature_c(temp_c).map_err(failed)
        }

        fn power_cut(self: Box<Self>) -> Outcome<Box<dyn Bench>> {
            Ok(Box::new(Self(self.0.power_cut().and_then(|off| off.start()).map_err(failed)?)))
        }
    }
}
