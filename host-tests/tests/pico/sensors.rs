//! Every magnetometer that a Pico may find on its bus, calibrated over the console.

use crate::support::{FIELD_UT, firmware, noisy, numbers, ok};
use ironout_rig::bus::Chip;
use ironout_rig::chips::{
    Hmc5883lModel, Ist8310Model, Lis2mdlModel, Lis3mdlModel, Qmc5883lModel, Qmc5883pModel, RegisterChip,
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
    type Made = (&'static str, fn() -> Rc<RefCell<dyn Chip>>);
    let chips: [Made; 6] = [
        ("LIS2MDL", || of(0x1e, Lis2mdlModel { is_lsm303agr: false })),
        ("LIS3MDL", || of(0x1c, Lis3mdlModel)),
        ("HMC5883L", || of(0x1e, Hmc5883lModel::default())),
        ("QMC5883L", || of(0x0d, Qmc5883lModel)),
        ("QMC5883P", || of(0x2c, Qmc5883pModel)),
        ("IST8310", || of(0x0e, Ist8310Model { offset_ut: [0.0; 3] })),
    ];
    for (name, chip) in chips {
        let mut board = Pico::start(firmware().path()).unwrap_or_else(|error| panic!("{error}"));
        board.attach(chip());
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

fn of<M: ironout_rig::chips::Model + 'static>(address: u8, model: M) -> Rc<RefCell<dyn Chip>> {
    Rc::new(RefCell::new(RegisterChip::new(address, model, noisy(PERIOD_S))))
}
