//! A stored calibration that carries effects, on the simulated board: applied once its columns are fed, and never guessed.

use crate::common::last;
use ironout::calibration::Calibration;
use ironout::effect::{BuiltIn, ColumnName, Drift, Gain, Offset, Past, Power};
use ironout::extended::{Conditions, Effects, ExtendedCalibration, FittedEffect};
use ironout::fit::{Method, Order};
use ironout::record::Record;
use ironout_rig::board::SimBoard;

fn fitted(effect: BuiltIn<f64>, theta: [f64; 3]) -> FittedEffect<f64> {
    let pad = |values: [f64; 3]| std::array::from_fn(|i| values.get(i).copied().unwrap_or(0.0));
    FittedEffect::new(effect, pad(theta), pad([0.001; 3]))
}

fn record(effects: &[FittedEffect<f64>]) -> Record {
    let mut list = Effects::none();
    for effect in effects {
        list.push(*effect).expect("four at most");
    }
    Record {
        sequence: 1,
        calibration: Calibration { offset_ut: [3.0, -2.0, 1.0], ..Calibration::identity(50.0) },
        effects: list,
        method: Method::Adjusted,
        model: Order::Ellipsoid,
        samples: 3000,
        noise_ut: 0.25,
        rms_ut: 0.25,
        axes: None,
        predicted_error: ironout::record::PredictedError::UNKNOWN,
        covariance: None,
        holds_for: None,
    }
}

/// A board with this record in its EEPROM.
fn board_with(record: &Record) -> SimBoard {
    // At rest and without noise: what changes in the stream is what was fed.
    let mut board = SimBoard::new(|_| [20.0, -10.0, 35.0], 0.0, 5);
    let bytes = record.encode().expect("it fits");
    board.eeprom.borrow_mut().memory[..bytes.as_bytes().len()].copy_from_slice(bytes.as_bytes());
    board.restart();
    board.run_ms(100);
    board
}

/// Some lines of the corrected stream.
fn stream_cal(board: &mut SimBoard) -> Vec<String> {
    last(board, "stream cal");
    board.run_ms(45);
    let lines = board.received();
    last(board, "stream off");
    lines.into_iter().filter(|line| line.starts_with("C,")).collect()
}

fn column(name: &str) -> ColumnName {
    ColumnName::new(name).expect("a name")
}

#[test]
fn effects_are_applied_once_their_columns_are_fed() {
    let temperature = BuiltIn::Offset(Offset::linear(column("case_c"), 25.0));
    let current = BuiltIn::Gain(Gain { column: column("current_a"), reference: 0.0 });
    let record = record(&[fitted(temperature, [1.0, -2.0, 0.5]), fitted(current, [0.01, 0.0, -0.01])]);
    let mut board = board_with(&record);

    let show = board.command("cal show");
    assert!(
        show.contains(
            &"+ effect=offset:case_c coefficients=1.0,-2.0,0.5 std_errors=0.0010000000474974513,0.0010000000474974513,\
             0.0010000000474974513 reference=25.0 range=-"
                .to_owned()
        ),
        "{show:?}"
    );
    assert!(board.command("status")[0].ends_with("the calibration needs: cov case_c=VALUE"));
    let unknown = stream_cal(&mut board);
    assert!(!unknown.is_empty() && unknown.iter().all(|line| line.ends_with(",-,-,-,-,-")), "{unknown:?}");

    assert_eq!(last(&mut board, "cov case_c=35"), "ok case_c=35.0 used=1 tested=1");
    assert!(board.command("status")[0].ends_with("the calibration needs: cov current_a=VALUE"));
    assert_eq!(last(&mut board, "cov current_a=4.5"), "ok current_a=4.5 used=1 tested=1");
    // Temperature of the chip, case and current: three are tested, and a fourth is refused, nothing lost.
    assert!(
        last(&mut board, "cov throttle=0.5")
            .starts_with("err state no room: 3 columns are tested at the same time")
    );
    assert_eq!(last(&mut board, "cov temp_c=- throttle=0.5"), "ok temp_c=- throttle=0.5 used=0 tested=1");
    assert!(last(&mut board, "cov throttle=-").starts_with("ok throttle=- "));
    let known = stream_cal(&mut board);
    assert!(
        !known.is_empty() && known.iter().all(|line| !line.contains('-') || line.contains('.')),
        "{known:?}"
    );

    // The host's correction of the counts that the board streams is what the board streams as corrected, whatever it is fed.
    // (In QEMU too: `qemu/effects.rs`.)
    last(&mut board, "stream raw");
    board.run_ms(45);
    let raw = board.received().pop().expect("a sample");
    last(&mut board, "stream off");
    let scale = board.device.session().config().ut_per_count;
    let counts = numbers(&raw);
    let measured: [f64; 3] = std::array::from_fn(|axis| counts[axis] * scale[axis]);
    let calibration: ExtendedCalibration = record.extended();
    let mut seen = Vec::new();
    for (temp_c, current_a) in [(35.0, 4.5), (15.0, 4.5), (15.0, -30.0), (25.0, 0.0)] {
        last(&mut board, &format!("cov case_c={temp_c}"));
        last(&mut board, &format!("cov current_a={current_a}"));
        let mut conditions = Conditions::unknown();
        (conditions.inputs[0][0], conditions.inputs[1][0]) = (temp_c, current_a);
        let here = calibration.apply(measured, &conditions).expect("all is known");
        let board = numbers(&stream_cal(&mut board).pop().expect("a sample"));
        for axis in 0..3 {
            assert!((here[axis] - board[axis]).abs() < 1e-3, "{here:?} against {board:?}");
        }
        seen.push(board[0]);
    }
    // 20 °C at 1 µT/°C, and a gain of a third: a board that ignores what it is fed would show one value.
    assert!((seen[1] - seen[0] - 20.0).abs() < 1.0 && (seen[2] - seen[1]).abs() > 5.0, "{seen:?}");
}

/// The numbers of a line of a stream, after its time.
fn numbers(line: &str) -> Vec<f64> {
    line.split(',').skip(2).map(|word| word.parse().expect("a number")).collect()
}

#[test]
fn effects_of_time_wait_for_the_clock_and_then_go_by_it() {
    let drift = BuiltIn::Drift(Drift { reference_s: 100.0 });
    let mut board = board_with(&record(&[fitted(drift, [1.0, 0.0, 0.0])]));
    assert!(board.command("status")[0].ends_with("the calibration needs: cov t_s=VALUE"));
    assert_eq!(last(&mut board, "cov t_s=100"), "ok t_s=100.0 used=1 tested=0");
    let at = |board: &mut SimBoard| -> f64 {
        let line = stream_cal(board).pop().expect("a sample");
        line.split(',').nth(2).and_then(|word| word.parse().ok()).unwrap_or_else(|| panic!("{line}"))
    };
    let before = at(&mut board);
    assert_eq!(last(&mut board, "cov t_s=130"), "ok t_s=130.0 used=1 tested=0");
    let after = at(&mut board);
    // Thirty seconds at 1 µT/s.
    assert!((before - after - 30.0).abs() < 0.5, "{before} {after}");
}

#[test]
fn a_late_column_is_known_after_its_delay() {
    let late = Offset {
        column: column("current_a"),
        reference: 0.0,
        power: Power::Linear,
        past: Past::Delayed(0.5),
    };
    let mut board = board_with(&record(&[fitted(BuiltIn::Offset(late), [1.0, 0.0, 0.0])]));
    last(&mut board, "cov current_a=2");
    board.run_ms(200);
    assert!(stream_cal(&mut board).iter().all(|line| line.ends_with(",-,-,-,-,-")));
    last(&mut board, "stream cal");
    board.run_ms(700);
    let lines = board.received();
    assert!(lines.last().is_some_and(|line| !line.ends_with(",-")), "{lines:?}");
}

#[test]
fn status_says_which_column_is_outside_its_range_and_by_how_much() {
    let temperature = BuiltIn::Offset(Offset::linear(column("temp_c"), 25.0));
    let current = BuiltIn::Gain(Gain { column: column("current_a"), reference: 0.0 });
    let drift = BuiltIn::Drift(Drift { reference_s: 100.0 });
    let mut board = board_with(&record(&[
        fitted(temperature, [1.0, -2.0, 0.5]).over([Some([10.0, 35.0]), None]),
        fitted(current, [0.01, 0.0, -0.01]).over([Some([-1.0, 4.5]), None]),
        fitted(drift, [0.001, 0.0, 0.0]).over([Some([90.0, 200.0]), None]),
    ]));
    let rows: Vec<String> =
        board.command("cal show").into_iter().filter(|line| line.contains(" range=")).collect();
    assert_eq!(rows.len(), 3, "{rows:?}");
    assert!(rows[0].ends_with(" reference=25.0 range=10.0,35.0"), "{rows:?}");
    assert!(rows[1].ends_with(" range=-1.0,4.5") && rows[2].ends_with(" range=90.0,200.0"), "{rows:?}");

    let outside = |board: &mut SimBoard| -> Vec<String> {
        board.command("status").into_iter().filter(|line| line.starts_with("+ outside ")).collect()
    };
    assert_eq!(outside(&mut board), [""; 0], "nothing is known yet");
    for line in ["cov temp_c=35", "cov current_a=4.5", "cov t_s=100"] {
        last(&mut board, line);
    }
    assert_eq!(outside(&mut board), [""; 0], "at the ends of the ranges");
    last(&mut board, "cov temp_c=60.5");
    // 0.001 µT/°C on each of three axes, 35 °C and 10 °C from the reference, and half a degree beyond 60 °C, where it is held.
    assert_eq!(
        outside(&mut board),
        [
            "+ outside temp_c=60.50 by=25.50 range=10.0,35.0 effect=offset:temp_c error_ut=1.147 error_at_range_ut=0.017"
        ]
    );
    last(&mut board, "cov temp_c=9.5");
    last(&mut board, "cov current_a=-3");
    let found = outside(&mut board);
    assert_eq!(found.len(), 2, "{found:?}");
    assert!(found[0].starts_with("+ outside temp_c=9.500 by=0.5000 range=10.0,35.0 "), "{found:?}");
    assert!(found[1].starts_with("+ outside current_a=-3.000 by=2.000 range=-1.0,4.5 "), "{found:?}");
    // What is extrapolated is corrected all the same, and the stream stays as it is.
    assert!(stream_cal(&mut board).iter().all(|line| !line.ends_with(",-") && line.split(',').count() == 7));
    // While a new calibration is collected, too, and in words where to turn next as ever.
    last(&mut board, "cal start");
    assert_eq!(outside(&mut board).len(), 2);
    for line in ["cov temp_c=20", "cov current_a=0", "cov t_s=190", "cal cancel"] {
        last(&mut board, line);
    }
    assert_eq!(outside(&mut board), [""; 0]);
    // The clock runs on, and in the recording's time.
    board.run_ms(20_000);
    let found = outside(&mut board);
    let after_s = |word: &str| -> f64 {
        let value = found[0].split(' ').find_map(|part| part.strip_prefix(word)).expect("a value");
        value.parse().expect("a number")
    };
    assert!((after_s("t_s=") - 210.0).abs() < 0.5 && (after_s("by=") - 10.0).abs() < 0.5, "{found:?}");
}

#[test]
fn a_late_column_is_outside_when_its_value_acts() {
    let late = Offset {
        column: column("current_a"),
        reference: 0.0,
        power: Power::Linear,
        past: Past::Delayed(0.5),
    };
    let late = fitted(BuiltIn::Offset(late), [1.0, 0.0, 0.0]).over([Some([0.0, 4.0]), None]);
    let mut board = board_with(&record(&[late]));
    let outside =
        |board: &mut SimBoard| board.command("status").iter().any(|line| line.starts_with("+ outside "));
    last(&mut board, "cov current_a=9");
    assert!(!outside(&mut board));
    board.run_ms(700);
    assert!(outside(&mut board), "{:?}", board.command("status"));
}
