//! The main job, end to end: the board is turned, calibrates itself, keeps the calibration over a power cut.

use crate::qemu::support::{FIELD_UT, attitudes, board, log, numbers, ok, start};
use ironout::gate::block_samples;
use ironout::sensor::Sample;
use ironout::session::{Session, SessionConfig};
use ironout_drivers::lsm303dlhc::{Range, register::OVERFLOW};
use ironout_rig::qemu::{self, Emulator, Reply};

/// The range that the board's firmware configures.
const RANGE: Range = Range::Gauss1_9;

/// The offset and the matrix that `cal show` prints, as bits.
fn shown_bits(reply: &Reply) -> Vec<u64> {
    let rows = reply.values("offset_ut").chain(reply.values("matrix"));
    rows.flat_map(|row| numbers::<f64>(row, 0)).map(f64::to_bits).collect()
}

/// The rms of (magnitude − F) over F in a turn through `count` attitudes, from the board's corrected stream.
fn corrected_error(board: &mut Emulator, count: usize) -> f64 {
    let mut squares = 0.0;
    for field_ut in attitudes(count) {
        let lines = board.expose(field_ut).unwrap();
        let [x, y, z, norm_ut, residual_ut]: [f64; 5] =
            numbers(lines.last().unwrap(), 2).try_into().expect("five numbers after the time");
        assert!((x.hypot(y).hypot(z) - norm_ut).abs() < 0.002, "{lines:?}");
        assert!((norm_ut - FIELD_UT - residual_ut).abs() < 0.002, "{lines:?}");
        squares += (norm_ut - FIELD_UT).powi(2);
    }
    (squares / count as f64).sqrt() / FIELD_UT
}

#[test]
fn turned_calibrated_cut_from_power_and_still_calibrated() {
    let Some(_turn) = qemu::turn("calibration") else { return };
    let mut board = board();
    ok(&mut board, &format!("field {FIELD_UT}"));
    ok(&mut board, "stream raw");
    // The emulated sensor starts without any field at all, which is no attitude.
    board.expose(attitudes(400).next().unwrap()).unwrap();
    ok(&mut board, "cal start");
    board.console.take_streamed(); // of before the start
    let mut raw = Vec::new();
    for field_ut in attitudes(400) {
        raw.extend(board.expose(field_ut).unwrap());
    }
    let stopped = ok(&mut board, "cal stop");
    // What came before the reply to `cal stop` is what the board has used.
    raw.extend(board.console.take_streamed());
    assert_eq!(stopped.value("verdict"), Some("accepted"), "{stopped}");
    ok(&mut board, "cal accept");
    let shown = ok(&mut board, "cal show");

    // The host, from the same counts: the same bits.
    let mut session = Session::new(SessionConfig {
        ut_per_count: RANGE.ut_per_count().map(f64::from),
        field_ut: Some(FIELD_UT),
        method: Default::default(),
        samples_per_block: block_samples(50.0),
        axes: None,
    });
    session.start();
    let mut raw_squares = 0.0;
    for line in &raw {
        let counts: [i16; 3] = numbers(line, 2).try_into().expect("three counts after the time");
        let sample = if counts.contains(&OVERFLOW) { Sample::out_of_range } else { Sample::valid };
        session.push(sample(counts));
        let scale = RANGE.ut_per_count();
        let norm_ut =
            counts.iter().zip(scale).map(|(&n, s)| (f64::from(n) * f64::from(s)).powi(2)).sum::<f64>().sqrt();
        raw_squares += (norm_ut - FIELD_UT).powi(2);
    }
    let outcome = session.stop().unwrap();
    assert!(outcome.verdict.accepted, "{:?}", outcome.verdict);
    let calibration = outcome.report.as_ref().expect("an accepted calibration has a report").calibration;
    let on_host: Vec<u64> = calibration
        .offset_ut
        .into_iter()
        .chain(calibration.matrix.into_iter().flatten())
        .map(f64::to_bits)
        .collect();
    assert_eq!(shown_bits(&shown), on_host, "{shown}\n{calibration:?}");

    // Applied at once, in other attitudes than those it was made from.
    ok(&mut board, "stream cal");
    let before = (raw_squares / raw.len() as f64).sqrt() / FIELD_UT;
    let after = corrected_error(&mut board, 151);
    println!("error of the magnitude: {:.1} % before, {:.3} % after", 100.0 * before, 100.0 * after);
    assert!(before > 1.0, "the raw magnitude is off by more than the field itself: {before}");
    assert!(after <= 0.003, "rms of the corrected magnitude {after}");
    let stack = board.stack_used().unwrap();
    println!("stack used: {stack} bytes");
    assert!(stack < 80 * 1024, "{stack} bytes of stack used: too close to the region's 96 KiB");
    assert!(log(&board).iter().any(|line| line == "sensor: works"), "{:?}", log(&board));

    // Still applied after a power cut, from the first sample on.
    let mut board = start(board.power_cut().unwrap());
    assert_eq!(ok(&mut board, "status").value("calibrated"), Some("1"));
    assert_eq!(shown_bits(&ok(&mut board, "cal show")), on_host);
    ok(&mut board, "stream cal");
    let restarted = corrected_error(&mut board, 53);
    assert!(restarted <= 0.003, "rms of the corrected magnitude after the restart {restarted}");
}

#[test]
fn samples_are_taken_fifty_times_a_second_of_the_board() {
    let Some(_turn) = qemu::turn("sample rate") else { return };
    // Its time goes by its instructions: a busy host makes it slower, and no step longer.
    let options = qemu::Options { counted: true, ..qemu::Options::default() };
    let mut board = start(qemu::PoweredOff::new(crate::qemu::support::firmware(), &options).unwrap());
    ok(&mut board, "stream raw");
    let times: Vec<u64> = (0..60)
        .map(|_| {
            let line = board.console.next_streamed(qemu::SAMPLE_LIMIT).unwrap();
            numbers::<i64>(&line, 1)[0] as u64
        })
        .collect();
    let mut steps: Vec<u64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
    steps.sort_unstable();
    assert_eq!(steps[steps.len() / 2], 20, "{times:?}");
}

#[test]
fn turned_about_one_axis_only_it_is_refused_and_keeps_its_calibration() {
    let Some(_turn) = qemu::turn("refusal") else { return };
    let image = crate::qemu::support::eeprom([
        &crate::qemu::support::bytes(&crate::qemu::support::record(1, 12.5)),
        &[],
    ]);
    let mut board = crate::qemu::support::board_with(&image, &qemu::Options::default());
    let before = ok(&mut board, "cal show");
    ok(&mut board, "stream raw");
    board.expose([93.0; 3]).unwrap();
    ok(&mut board, "cal start");
    for step in 0..60 {
        // The field stays in a plane, which lies across all three axes.
        let (sin, cos) = (f64::from(step) * 0.21).sin_cos();
        let (a, b) = (FIELD_UT * cos / 2f64.sqrt(), FIELD_UT * sin / 6f64.sqrt());
        board.expose([93.0 + a + b, 93.0 - a + b, 93.0 - 2.0 * b]).unwrap();
    }
    let stopped = crate::qemu::support::ask(&mut board, "cal stop");
    assert_eq!(stopped.code(), Some("refused"), "{stopped}");
    let refusal = stopped.outcome.clone().unwrap_err();
    assert!(refusal.text.starts_with("planar "), "a reason and what to do: {stopped}");
    assert_eq!(crate::qemu::support::ask(&mut board, "cal accept").code(), Some("refused"));
    assert_eq!(ok(&mut board, "cal show"), before);
}
