//! A board that is spoken to while somebody watches.

use crate::cli::{BoardArg, DemoArgs};
use crate::commands::demo::bench::{self, Answer, Bench, Simulated};
use crate::failure::{Failure, Outcome};
use crate::output::line;

/// The board of a story.
pub struct Talk {
    /// The board.
    pub board: Box<dyn Bench>,
    /// Whether it is in QEMU.
    pub emulated: bool,
    /// Whether nothing is said but the figures at the end.
    pub json: bool,
}

impl Talk {
    /// Switches a board on.
    pub fn start(arguments: &DemoArgs, json: bool) -> Outcome<Self> {
        let tell = |text: &str| {
            if !json {
                line(text);
            }
        };
        let (board, emulated) = power_up(arguments, &tell)?;
        Ok(Talk { board, emulated, json })
    }

    /// The power is cut and comes back.
    pub fn power_cut(self) -> Outcome<Self> {
        let Talk { board, emulated, json } = self;
        Ok(Talk { board: board.power_cut()?, emulated, json })
    }

    /// Says something.
    pub fn say(&self, text: &str) {
        if !self.json {
            line(text);
        }
    }

    /// A command and its answer, both shown.
    pub fn ask(&mut self, command: &str) -> Outcome<Answer> {
        let answer = self.board.command(command)?;
        self.show(command, &answer);
        Ok(answer)
    }

    /// Shows a command and its answer.
    pub fn show(&self, command: &str, answer: &Answer) {
        self.say(&format!("  > {command}"));
        answer.info.iter().for_each(|info| self.say(&format!("    + {info}")));
        self.say(&format!("    {}", answer.closing));
    }

    /// A command that has to be answered `ok`.
    pub fn ok(&mut self, command: &str) -> Outcome<Answer> {
        let answer = self.ask(command)?;
        if answer.is_ok() {
            return Ok(answer);
        }
        Err(Failure::refused(format!("the board answered `{command}` with: {}", answer.closing)))
    }

    /// The same without showing it.
    pub fn quiet(&mut self, command: &str) -> Outcome<()> {
        let answer = self.board.command(command)?;
        if answer.is_ok() {
            return Ok(());
        }
        Err(Failure::refused(format!("the board answered `{command}` with: {}", answer.closing)))
    }
}

#[cfg(unix)]
fn power_up(arguments: &DemoArgs, tell: &dyn Fn(&str)) -> Outcome<(Box<dyn Bench>, bool)> {
    use ironout_rig::qemu::{self, Error, Firmware};
    if arguments.board == BoardArg::Pico {
        return Ok((crate::commands::demo::pico::start(tell)?, true));
    }
    if arguments.no_qemu {
        return Ok((simulated(tell), false));
    }
    if !qemu::installed() {
        tell(&format!("{}\nUntil then, the same session on the simulated bus.\n", Error::NotInstalled));
        return Ok((simulated(tell), false));
    }
    tell("Building the firmware for the emulated board (cargo fw-mps2; a minute the first time) …");
    let firmware = match Firmware::build() {
        Ok(firmware) => firmware,
        Err(error @ (Error::NoTarget { .. } | Error::NoSource(_))) => {
            tell(&format!("{error}\nUntil then, the same session on the simulated bus.\n"));
            return Ok((simulated(tell), false));
        }
        Err(error) => return Err(Failure::usage(error.to_string())),
    };
    if let Ok(footprint) = firmware.footprint() {
        let kilo = |bytes: u64| bytes as f64 / 1024.0;
        tell(&format!(
            "  flash {:.1} KB, RAM {:.1} KB with its stack",
            kilo(footprint.flash()),
            kilo(footprint.ram())
        ));
    }
    tell(
        "Booting it in QEMU: a Cortex-M4F with an LSM303DLHC and an EEPROM on its I²C bus, and a serial console.",
    );
    let board = bench::Emulated::start(&firmware).map_err(|error| Failure::usage(error.to_string()))?;
    Ok((Box::new(board), true))
}

#[cfg(not(unix))]
fn power_up(arguments: &DemoArgs, tell: &dyn Fn(&str)) -> Outcome<(Box<dyn Bench>, bool)> {
    if arguments.board == BoardArg::Pico {
        return Err(Failure::usage("the emulated Pico runs on Unix only. Omit --board"));
    }
    Ok((simulated(tell), false))
}

fn simulated(tell: &dyn Fn(&str)) -> Box<dyn Bench> {
    tell("A simulated LSM303DLHC and EEPROM on a simulated I²C bus, under the same drivers and application.");
    Box::new(Simulated::start())
}

/// The numbers of a comma-separated line, from the `skip`th on; what is none is left out.
pub fn numbers(text: &str, skip: usize) -> Vec<f64> {
    text.split(',').skip(skip).filter_map(|word| word.trim().parse().ok()).collect()
}
