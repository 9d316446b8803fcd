//! A stored calibration that carries effects: the board corrects as the host does, and follows the columns it is fed.

use crate::qemu::support::{board_with, bytes, eeprom, numbers, ok, record};
use ironout::effect::{BuiltIn, ColumnName, Gain, Offset};
use ironout::extended::{Effects, FittedEffect, Live};
use ironout::record::Record;
use ironout_drivers::lsm303dlhc::Range;
use ironout_rig::qemu::{self, Emulator, Options};

/// Values of the last of two lines of the stream, of which the first may be of the sample before.
fn streamed(board: &mut Emulator, stream: &str) -> Vec<f64> {
    ok(board, &format!("stream {stream}"));
    board.console.take_streamed();
    board.console.next_streamed(qemu::SAMPLE_LIMIT).unwrap();
    let line = board.console.next_streamed(qemu::SAMPLE_LIMIT).unwrap();
    ok(board, "stream off");
    numbers(&line, 2)
}

#[test]
fn the_board_corrects_as_the_host_does_and_follows_its_columns() {
    let Some(_turn) = qemu::turn("effects") else { return };
    let column = |name| ColumnName::new(name).expect("a name");
    let fitted = |effect, theta: [f64; 3]| {
        let coefficients = std::array::from_fn(|i| theta.get(i).copied().unwrap_or(0.0));
        FittedEffect::new(effect, coefficients, [0.001; 9])
    };
    let mut effects = Effects::none();
    for effect in [
        fitted(BuiltIn::Offset(Offset::linear(column("temp_c"), 25.0)), [1.0, -2.0, 0.5]),
        fitted(BuiltIn::Gain(Gain { column: column("current_a"), reference: 0.0 }), [0.01, 0.0, -0.01]),
    ] {
        effects.push(effect).expect("four at most");
    }
    let mut stored = Record { effects, ..record(1, 80.0) };
    stored.calibration.matrix = [[1.05, 0.02, -0.03], [0.0, 0.97, 0.04], [0.0, 0.0, 0.93]];
    let mut board = board_with(&eeprom([&bytes(&stored), &[]]), &Options::default());
    ok(&mut board, "stream raw");
    board.expose([110.0, 70.0, 125.0]).unwrap();
    ok(&mut board, "stream off");

    let mut live = Live::new(&stored.extended().cast::<f32>()).unwrap();
    let raw = streamed(&mut board, "raw");
    let scale = Range::Gauss1_9.ut_per_count();
    let measured = std::array::from_fn(|axis| raw[axis] as f32 * scale[axis]);
    let mut shown = Vec::new();
    for (temp_c, current_a) in [(35.0_f32, 4.5_f32), (35.0, -4.5), (15.5, 0.0), (25.0, 0.0)] {
        for (name, fed) in [("temp_c", temp_c), ("current_a", current_a)] {
            assert_eq!(ok(&mut board, &format!("cov {name}={fed}")).value("used"), Some("1"));
            live.set(name, fed);
        }
        let on_board = streamed(&mut board, "cal");
        let on_host = live.apply(measured, None).unwrap();
        for axis in 0..3 {
            let digits = format!("{:.3}", on_host[axis]).parse::<f64>().unwrap();
            assert_eq!(on_board[axis], digits, "{temp_c} {current_a}: {on_board:?} {on_host:?}");
        }
        shown.push(on_board[0]);
    }
    // 20 °C at 1 µT/°C, less the matrix: a board that does not follow what it is fed would show one value.
    assert!(shown[3] - shown[0] > 5.0 && (shown[0] - shown[1]).abs() > 5.0, "{shown:?}");
}
