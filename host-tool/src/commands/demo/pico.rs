//! The demo's board as a Raspberry Pi Pico: the image that one flashes, in an emulated RP2040.

use crate::commands::demo::bench::{Answer, Bench};
use crate::failure::{Failure, Outcome};
use ironout_rig::chips::{Lis2mdlModel, RegisterChip};
use ironout_rig::pico::{Error, Pico, missing};
use ironout_rig::qemu::Firmware;
use std::cell::{Cell, RefCell};
use std::rc::Rc;

/// The address of a LIS2MDL.
const ADDRESS: u8 = 0x1e;
/// Its scale, which is fixed.
const UT_PER_COUNT: f64 = 0.15;
/// One of its conversions and a little, board time: what is streamed of later was measured in the new field.
const EXPOSURE_MS: u64 = 12;
/// A board that is computing streams its samples later.
const PATIENCE_MS: u64 = 400;
/// Until the sensor works after the start.
const START_MS: u64 = 200;

/// Builds the firmware and puts the power on.
pub fn start(tell: &dyn Fn(&str)) -> Outcome<Box<dyn Bench>> {
    if let Some(missing) = missing() {
        return Err(Failure::usage(missing));
    }
    tell("Building the firmware for the Raspberry Pi Pico (cargo fw-pico; some minutes the first time) …");
    let firmware = Firmware::build_for("board-pico").map_err(|error| Failure::usage(error.to_string()))?;
    tell(
        "Booting it in an emulated RP2040, as it is flashed, with a simulated LIS2MDL on its I²C bus and its console on UART 0.",
    );
    let field_ut = Rc::new(Cell::new([93.0; 3]));
    let seen = Rc::clone(&field_ut);
    let mut board = Pico::start(firmware.path()).map_err(failed)?;
    let model = Lis2mdlModel { is_lsm303agr: false };
    let chip = Rc::new(RefCell::new(RegisterChip::new(ADDRESS, model, move |_| seen.get())));
    board.attach(chip.clone());
    board.run_ms(START_MS).map_err(failed)?;
    Ok(Box::new(OnBench { board, chip, field_ut, on_ms: 0 }))
}

struct OnBench {
    board: Pico,
    chip: Rc<RefCell<RegisterChip<Lis2mdlModel>>>,
    field_ut: Rc<Cell<[f64; 3]>>,
    /// When its power came on, on the emulator's clock.
    on_ms: u64,
}

fn failed(error: Error) -> Failure {
    Failure::usage(format!("the emulated Pico: {error}"))
}

impl Bench for OnBench {
    fn command(&mut self, line: &str) -> Outcome<Answer> {
        let reply = self.board.command(line).map_err(failed)?;
        let text = reply.to_string();
        let closing = text.lines().last().unwrap_or_default().to_string();
        Ok(Answer { info: reply.info, closing })
    }

    fn expose(&mut self, field_ut: [f64; 3]) -> Outcome<String> {
        self.field_ut.set(field_ut);
        self.board.take_streamed();
        let from_ms = self.board.clock().ms() - self.on_ms + EXPOSURE_MS;
        for _ in 0..PATIENCE_MS / EXPOSURE_MS {
            self.board.run_ms(EXPOSURE_MS).map_err(failed)?;
            let t_ms = |line: &String| line.split(',').nth(1)?.parse::<u64>().ok();
            let new = |line: &String| t_ms(line).is_some_and(|t_ms| t_ms >= from_ms);
            if let Some(line) = self.board.take_streamed().into_iter().find(new) {
                return Ok(line);
            }
        }
        Err(Failure::refused("the emulated Pico sends no samples"))
    }

    fn warm(&mut self, temp_c: f64) -> Outcome<()> {
        self.chip.borrow_mut().temperature_c = temp_c;
        Ok(())
    }

    fn power_cut(mut self: Box<Self>) -> Outcome<Box<dyn Bench>> {
        self.board.power_cycle().map_err(failed)?;
        self.on_ms = self.board.clock().ms();
        self.board.run_ms(START_MS).map_err(failed)?;
        Ok(self)
    }

    fn ut_per_count(&self) -> [f64; 3] {
        [UT_PER_COUNT; 3]
    }
}
