//! What the tests share: the built firmware, a board with its chip, a motion, stored calibrations.

use ironout::calibration::Calibration;
use ironout::extended::Effects;
use ironout::fit::{Method, Order};
use ironout::record::Record;
use ironout::sensor::Sample;
use ironout::session::{Session, SessionConfig};
use ironout_drivers::Magnetometer;
use ironout_drivers::lis2mdl::{Config, Lis2mdl, Model};
use ironout_rig::bus::{Clock, SimBus};
use ironout_rig::chips::{Lis2mdlModel, RegisterChip};
use ironout_rig::pico::{Pico, SLOT_STRIDE, SLOTS};
use ironout_rig::qemu::Firmware;
use ironout_rig::reply::Reply;
use nalgebra::{Matrix3, Rotation3, Vector3};
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use std::cell::RefCell;
use std::rc::Rc;
use std::sync::OnceLock;

/// The Earth's field of these tests, µT.
pub const FIELD_UT: f64 = 50.0;
/// Hard iron, µT.
pub const HARD_IRON_UT: [f64; 3] = [18.0, -31.0, 12.0];
/// Noise of the sensor on each axis, µT.
pub const NOISE_UT: f64 = 0.15;

/// The firmware, built once.
pub fn firmware() -> &'static Firmware {
    static BUILT: OnceLock<Firmware> = OnceLock::new();
    BUILT.get_or_init(|| Firmware::build_for("board-pico").unwrap_or_else(|error| panic!("{error}")))
}

/// What the sensor measures at `t_s`, µT: the board is turned through all directions once in `period_s`, with hard iron, and soft
/// iron of 10 % in directions of its own.
pub fn turning(t_s: f64, period_s: f64) -> [f64; 3] {
    let turn = Rotation3::from_euler_angles(0.4, -0.7, 1.1).into_inner();
    let soft_iron = turn * Matrix3::from_diagonal(&Vector3::new(1.10, 1.0, 0.90)) * turn.transpose();
    // From pole to pole and back with equal areas between the turns.
    let phase = (t_s / period_s).rem_euclid(1.0);
    let z = if phase < 0.5 { 1.0 - 4.0 * phase } else { 4.0 * phase - 3.0 };
    let (sin, cos) = (phase * 2.0 * std::f64::consts::PI * 21.3).sin_cos();
    let across = (1.0 - z * z).sqrt();
    (soft_iron * (FIELD_UT * Vector3::new(across * cos, across * sin, z)) + Vector3::from(HARD_IRON_UT))
        .into()
}

/// The sensor of most tests.
pub type Lis2mdlChip = RegisterChip<Lis2mdlModel>;

/// [`turning`] with the sensor's noise, the same in every run.
pub fn noisy(period_s: f64) -> impl FnMut(f64) -> [f64; 3] {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    move |t_s| {
        turning(t_s, period_s).map(|axis| {
            let noise: f64 = StandardNormal.sample(&mut rng);
            axis + NOISE_UT * noise
        })
    }
}

/// A board that has this image in its flash, with a sensor that is turned once in `period_s`.
pub fn board_of(image: &std::path::Path, period_s: f64) -> (Pico, Rc<RefCell<Lis2mdlChip>>) {
    let mut board = Pico::start(image).unwrap_or_else(|error| panic!("{error}"));
    let model = Lis2mdlModel { is_lsm303agr: false };
    let chip = Rc::new(RefCell::new(RegisterChip::new(0x1e, model, noisy(period_s))));
    board.attach(chip.clone());
    (board, chip)
}

/// A new board with the firmware.
pub fn board(period_s: f64) -> (Pico, Rc<RefCell<Lis2mdlChip>>) {
    board_of(firmware().path(), period_s)
}

/// A command that has to be answered at all.
pub fn ask(board: &mut Pico, command: &str) -> Reply {
    board.command(command).unwrap_or_else(|error| panic!("{command}: {error}"))
}

/// A command that has to be answered `ok`.
pub fn ok(board: &mut Pico, command: &str) -> Reply {
    let reply = ask(board, command);
    assert!(reply.is_ok(), "{command}: {reply}");
    reply
}

/// The numbers of a line, separated by commas, from the `skip`th on.
pub fn numbers<T: std::str::FromStr>(line: &str, skip: usize) -> Vec<T> {
    let number = |word: &str| word.parse().unwrap_or_else(|_| panic!("{word:?} in {line:?} is no number"));
    line.split(',').skip(skip).map(number).collect()
}

/// The offset and the matrix that `cal show` prints, as bits.
pub fn shown_bits(reply: &Reply) -> Vec<u64> {
    let rows = reply.values("offset_ut").chain(reply.values("matrix"));
    rows.flat_map(|row| numbers::<f64>(row, 0)).map(f64::to_bits).collect()
}

/// A stored record whose offset tells it from others.
pub fn record(sequence: u32, offset_ut: f64) -> Vec<u8> {
    let record = Record {
        sequence,
        calibration: Calibration { offset_ut: [offset_ut; 3], ..Calibration::identity(FIELD_UT) },
        effects: Effects::none(),
        method: Method::Adjusted,
        model: Order::Ellipsoid,
        samples: 400,
        noise_ut: 0.05,
        rms_ut: 0.05,
        axes: None,
        predicted_error: ironout::record::PredictedError::UNKNOWN,
        covariance: None,
        holds_for: None,
    };
    record.encode().expect("it fits").as_bytes().to_vec()
}

/// Puts a record into a slot of the flash.
pub fn store(board: &mut Pico, slot: u32, record: &[u8]) {
    board.set_flash(SLOTS + slot * SLOT_STRIDE, record).unwrap();
}

/// The figure named `key` of a reply.
pub fn figure(reply: &Reply, key: &str) -> f64 {
    let text = reply.value(key).unwrap_or_else(|| panic!("no {key} in {reply}"));
    text.parse().unwrap_or_else(|_| panic!("{key} in {reply} is no number"))
}

/// Bytes that the stack has reached.
pub fn stack_used(board: &mut Pico) -> u64 {
    let bottom = firmware().symbol("_stack_end").unwrap();
    let region = firmware().symbol("_stack_start").unwrap() - bottom;
    // The emulated memory starts as zeros.
    region - board.memory(bottom, region).unwrap().iter().take_while(|&&byte| byte == 0).count() as u64
}

/// What the host's session makes of a raw stream: offset and matrix, as bits.
pub fn host_bits(raw: &[String], field_ut: f64) -> Vec<u64> {
    let driver = Lis2mdl::new(SimBus::new(Clock::default()), Config::of(Model::Lis2mdl));
    let sensor = driver.describe();
    let mut session = Session::new(SessionConfig { field_ut: Some(field_ut), ..SessionConfig::of(&sensor) });
    session.start();
    for line in raw {
        let counts: [i16; 3] = numbers(line, 2).try_into().expect("three counts after the time");
        session.push(Sample::valid(counts));
    }
    let outcome = session.stop().unwrap();
    let calibration = outcome.report.as_ref().expect("a report").calibration;
    let values = calibration.offset_ut.into_iter().chain(calibration.matrix.into_iter().flatten());
    values.map(f64::to_bits).collect()
}
