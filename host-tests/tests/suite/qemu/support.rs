//! What the tests share: the built firmware, a field to turn in, stored calibrations, the decoded log.

use defmt_decoder::{DecodeError, Table};
use ironout::calibration::Calibration;
use ironout::extended::Effects;
use ironout::fit::{Method, Order};
use ironout::record::{MAX_RECORD_BYTES, Record};
use ironout_rig::qemu::{Emulator, Firmware, Options, PoweredOff, Reply};
use nalgebra::{Matrix3, Vector3};
use std::sync::OnceLock;

/// The Earth's field of these tests, µT.
pub const FIELD_UT: f64 = 50.0;

/// Hard iron on every axis, µT.
pub const HARD_IRON_UT: f64 = 93.0;

/// The firmware, built once.
pub fn firmware() -> &'static Firmware {
    static BUILT: OnceLock<Firmware> = OnceLock::new();
    BUILT.get_or_init(|| Firmware::build().unwrap_or_else(|error| panic!("{error}")))
}

/// A new board with power on.
pub fn board() -> Emulator {
    start(PoweredOff::new(firmware(), &Options::default()).unwrap())
}

/// Power on, with the reason where that fails.
pub fn start(board: PoweredOff) -> Emulator {
    board.start().unwrap_or_else(|error| panic!("{error}"))
}

/// A command that has to be answered at all.
pub fn ask(board: &mut Emulator, command: &str) -> Reply {
    board.console.command(command).unwrap_or_else(|error| panic!("{command}: {error}"))
}

/// A command that has to be answered `ok`.
pub fn ok(board: &mut Emulator, command: &str) -> Reply {
    let reply = ask(board, command);
    assert!(reply.is_ok(), "{command}: {reply}");
    reply
}

/// What the sensor measures, µT, in `count` attitudes whose field directions cover the sphere evenly: hard iron, and soft
/// iron of 10 % in directions of its own.
pub fn attitudes(count: usize) -> impl Iterator<Item = [f64; 3]> {
    let turn = nalgebra::Rotation3::from_euler_angles(0.4, -0.7, 1.1).into_inner();
    let soft_iron = turn * Matrix3::from_diagonal(&Vector3::new(1.10, 1.0, 0.90)) * turn.transpose();
    (0..count).map(move |i| {
        // A spiral with equal areas between its turns.
        let z = 1.0 - (2 * i + 1) as f64 / count as f64;
        let (sin, cos) = (i as f64 * 2.399_963_229_728_653).sin_cos();
        let across = (1.0 - z * z).sqrt();
        let field = FIELD_UT * Vector3::new(across * cos, across * sin, z);
        (soft_iron * field).add_scalar(HARD_IRON_UT).into()
    })
}

/// The numbers of a line, separated by commas, from the `skip`th on.
pub fn numbers<T: std::str::FromStr>(line: &str, skip: usize) -> Vec<T> {
    line.split(',')
        .skip(skip)
        .map(|word| word.parse().unwrap_or_else(|_| panic!("{word:?} in {line:?} is no number")))
        .collect()
}

/// A stored record whose offset tells it from others.
pub fn record(sequence: u32, offset_ut: f64) -> Record {
    Record {
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
    }
}

/// Its bytes.
pub fn bytes(record: &Record) -> Vec<u8> {
    record.encode().expect("it fits").as_bytes().to_vec()
}

/// An EEPROM with these bytes at the beginning of its slots.
pub fn eeprom(slots: [&[u8]; 2]) -> Vec<u8> {
    let mut image = vec![0xFF; 4096];
    for (bytes, begin) in slots.into_iter().zip([0, MAX_RECORD_BYTES]) {
        image[begin..begin + bytes.len()].copy_from_slice(bytes);
    }
    image
}

/// A board that has `image` in its EEPROM, with power on.
pub fn board_with(image: &[u8], options: &Options) -> Emulator {
    let board = PoweredOff::new(firmware(), options).unwrap();
    board.set_eeprom(image).unwrap();
    start(board)
}

/// The firmware's log as text. A frame cut off by a reset is passed over.
pub fn log(board: &Emulator) -> Vec<String> {
    let elf = firmware().bytes().unwrap();
    let table = Table::parse(&elf).unwrap().expect("the ELF holds the log's texts");
    let mut decoder = table.new_stream_decoder();
    decoder.received(&board.log().unwrap());
    let mut lines = Vec::new();
    loop {
        match decoder.decode() {
            Ok(frame) => lines.push(frame.display_message().to_string()),
            Err(DecodeError::UnexpectedEof) => return lines,
            Err(DecodeError::Malformed) => {}
        }
    }
}
