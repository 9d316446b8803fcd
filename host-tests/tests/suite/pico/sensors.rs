//! Every magnetometer that a Pico may find on its bus, calibrated over the console.

use crate::pico::support::{FIELD_UT, firmware, noisy, numbers, ok};
use ironout_drivers::Kind;
use ironout_rig::bus::{Chip, Clock, Direction};
use ironout_rig::chips::{
    Ak09916Model, Bmm150Model, Bmm350Model, Hmc5883lModel, Icm20948Model, Ist8310Model, Lis2mdlModel,
    Lis3mdlModel, Lsm303dlhcChip, Mmc5603Model, Mmc5983maModel, Model, OtpMemory, Qmc5883lModel,
    Qmc5883pModel, Qmc6309Model, Qmc6310Model, RegisterChip, Rm3100Model, Trimming,
};
use ironout_rig::pico::{self, Pico};
use std::cell::RefCell;
use std::rc::Rc;

const PERIOD_S: f64 = 5.0;

#[test]
fn each_chip_is_found_by_probing_and_calibrates() {
    if !pico::available("sensors") {
        return;
    }
    // All that `probe` knows; an IIS2MDC is the same registers as a LIS2MDL, and is told as that.
    let kinds = [
        Kind::Lis2mdl,
        Kind::Lsm303agr,
        Kind::Lis3mdl,
        Kind::Lsm303dlhc,
        Kind::Hmc5883l,
        Kind::Qmc5883l,
        Kind::Qmc5883p,
        Kind::Qmc6309,
        Kind::Qmc6310,
        Kind::Mmc5603,
        Kind::Mmc5983ma,
        Kind::Bmm150,
        Kind::Bmm350,
        Kind::Ak09916,
        Kind::Icm20948,
        Kind::Ist8310,
        Kind::Rm3100,
    ];
    for kind in kinds {
        let name = kind.name();
        let mut board = Pico::start(firmware().path()).unwrap_or_else(|error| panic!("{error}"));
        attach(&mut board, kind);
        board.run_ms(200).unwrap();
        let version = ok(&mut board, "version");
        assert_eq!(version.value("sensor"), Some(name), "{version}");
        ok(&mut board, &format!("field {FIELD_UT}"));
        ok(&mut board, "cal start");
        board.run_ms((PERIOD_S * 1000.0) as u64).unwrap();
        let stopped = ok(&mut board, "cal stop");
        assert_eq!(stopped.value("verdict"), Some("accepted"), "{name}: {stopped}");
        ok(&mut board, "cal accept");
        ok(&mut board, "stream cal");
        board.run_ms(1_000).unwrap();
        ok(&mut board, "stream off");
        let residuals: Vec<f64> =
            board.take_streamed().iter().map(|line| numbers::<f64>(line, 2)[4]).collect();
        let rms = (residuals.iter().map(|r| r * r).sum::<f64>() / residuals.len() as f64).sqrt() / FIELD_UT;
        println!("{name}: rms of the corrected magnitude {:.3} % of {}", 100.0 * rms, residuals.len());
        assert!(residuals.len() > 5 && rms < 0.02, "{name}: {rms} of {}", residuals.len());
    }
}

/// Puts the chip on the bus, at the address that it has when nobody has chosen another.
fn attach(board: &mut Pico, kind: Kind) {
    match kind {
        Kind::Lis2mdl | Kind::Iis2mdc => put(board, 0x1e, Lis2mdlModel { is_lsm303agr: false }),
        Kind::Lsm303agr => {
            put(board, 0x1e, Lis2mdlModel { is_lsm303agr: true });
            board.attach(Rc::new(RefCell::new(Accelerometer { identity: 0x33 })));
        }
        Kind::Lis3mdl => put(board, 0x1c, Lis3mdlModel),
        Kind::Lsm303dlhc => {
            board.attach(Rc::new(RefCell::new(Lsm303dlhcChip::new(noisy(PERIOD_S), 0.0, 1))));
            // The magnetic half has the registers of an HMC5883L.
            board.attach(Rc::new(RefCell::new(Accelerometer { identity: 0 })));
        }
        Kind::Hmc5883l => put(board, 0x1e, Hmc5883lModel::default()),
        Kind::Qmc5883l => put(board, 0x0d, Qmc5883lModel),
        Kind::Qmc5883p => put(board, 0x2c, Qmc5883pModel),
        Kind::Qmc6309 => put(board, 0x7c, Qmc6309Model::default()),
        Kind::Qmc6310 => put(board, 0x1c, Qmc6310Model),
        Kind::Mmc5603 => put(board, 0x30, Mmc5603Model::new([35.0, -20.0, 50.0])),
        Kind::Mmc5983ma => put(board, 0x30, Mmc5983maModel::new([35.0, -20.0, 50.0])),
        Kind::Bmm150 => put(board, 0x10, Bmm150Model::new(Trimming::default())),
        Kind::Bmm350 => {
            put(board, 0x14, Bmm350Model::new(OtpMemory::default(), [60.0, -45.0, 80.0]));
        }
        Kind::Ak09916 => put(board, 0x0c, Ak09916Model::default()),
        Kind::Icm20948 => {
            let host = Icm20948Model::default();
            let connected = host.bypass.clone();
            put(board, 0x68, host);
            put(board, 0x0c, Ak09916Model { connected });
        }
        Kind::Ist8310 => put(board, 0x0e, Ist8310Model { offset_ut: [0.0; 3] }),
        Kind::Rm3100 => put(board, 0x20, Rm3100Model),
    }
}

fn put<M: Model + 'static>(board: &mut Pico, address: u8, model: M) {
    board.attach(Rc::new(RefCell::new(RegisterChip::new(address, model, noisy(PERIOD_S)))));
}

/// The other half of an LSM303, by which `probe` tells the two from chips of the same registers: whatever is read is its identity.
struct Accelerometer {
    identity: u8,
}

impl Chip for Accelerometer {
    fn address(&self) -> u8 {
        0x19
    }

    fn start(&mut self, _direction: Direction, _clock: &Clock) -> bool {
        true
    }

    fn write(&mut self, _byte: u8) -> bool {
        true
    }

    fn read(&mut self) -> u8 {
        self.identity
    }

    fn stop(&mut self, _clock: &Clock) {}
}
