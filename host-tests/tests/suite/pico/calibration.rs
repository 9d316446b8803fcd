//! The main job, end to end, on the image that one flashes: turned, calibrated over the console, kept over a power cycle.

use crate::pico::support::{FIELD_UT, board_of, firmware, host_bits, numbers, ok, shown_bits};
use ironout_rig::pico::{self, uf2};
use std::path::Path;

const PERIOD_S: f64 = 8.0;

fn calibrates(image: &Path) {
    let (mut board, _chip) = board_of(image, PERIOD_S);
    board.run_ms(100).unwrap();
    ok(&mut board, &format!("field {FIELD_UT}"));
    ok(&mut board, "stream raw");
    ok(&mut board, "cal start");
    board.take_streamed(); // of before the start
    board.run_ms((PERIOD_S * 1000.0) as u64).unwrap();
    let stopped = ok(&mut board, "cal stop");
    assert_eq!(stopped.value("verdict"), Some("accepted"), "{stopped}");
    // Those that came before the reply are those that the board has used.
    let raw = board.take_streamed();
    ok(&mut board, "stream off");
    assert_eq!(ok(&mut board, "version").value("samples_lost"), Some("0"));
    ok(&mut board, "cal accept");
    let shown = ok(&mut board, "cal show");

    let on_host = host_bits(&raw, FIELD_UT);
    assert_eq!(shown_bits(&shown), on_host, "{shown}\n{} samples", raw.len());
    // No conversion is missing: 100 a second, their times in order.
    let times: Vec<i64> = raw.iter().map(|line| numbers::<i64>(line, 1)[0]).collect();
    let steps: Vec<i64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
    assert!(steps.iter().all(|step| (9..=11).contains(step)), "{steps:?}");
    assert!(raw.len() as f64 >= 100.0 * PERIOD_S - 2.0, "{} samples", raw.len());

    // Applied at once, and after a power cycle from the first sample on.
    for power in 0..2 {
        if power > 0 {
            board.power_cycle().unwrap();
            board.run_ms(100).unwrap();
            assert_eq!(ok(&mut board, "status").value("calibrated"), Some("1"));
            assert_eq!(shown_bits(&ok(&mut board, "cal show")), on_host);
        }
        board.take_streamed(); // of the raw stream
        ok(&mut board, "stream cal");
        board.run_ms(2_000).unwrap();
        ok(&mut board, "stream off");
        let residuals: Vec<f64> =
            board.take_streamed().iter().map(|line| numbers::<f64>(line, 2)[4]).collect();
        let rms = (residuals.iter().map(|r| r * r).sum::<f64>() / residuals.len() as f64).sqrt() / FIELD_UT;
        println!("rms of the corrected magnitude: {:.3} % of {} samples", 100.0 * rms, residuals.len());
        assert!(residuals.len() > 190 && rms < 0.006, "{rms} over {}", residuals.len());
    }
}

#[test]
fn the_elf_calibrates_keeps_it_and_gives_the_host_s_bits() {
    if pico::available("calibration") {
        calibrates(firmware().path());
    }
}

#[test]
fn the_uf2_image_of_it_does_the_same() {
    if !pico::available("calibration from UF2") {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let image = folder.path().join("firmware.uf2");
    std::fs::write(&image, uf2(firmware().path()).unwrap()).unwrap();
    calibrates(&image);
}
