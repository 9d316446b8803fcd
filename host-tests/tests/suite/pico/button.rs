//! A calibration without a console: button and light.

use crate::pico::support::{board, ok};
use ironout_rig::pico::{self, LIGHT_PIN, Pico};

/// How often the light goes on in the next two seconds.
fn flashes(board: &mut Pico) -> usize {
    board.take_pins();
    board.run_ms(2_000).unwrap();
    let pins = board.take_pins();
    pins.iter().filter(|change| change.pin == LIGHT_PIN && change.level == Some(true)).count()
}

#[test]
fn the_button_calibrates_and_the_light_shows_each_state() {
    if !pico::available("button") {
        return;
    }
    let (mut board, _chip) = board(6.0);
    board.run_ms(200).unwrap();
    assert_eq!(flashes(&mut board), 1, "uncalibrated");
    board.press_ms(80).unwrap();
    assert_eq!(flashes(&mut board), 8, "collecting");
    // A second of turning is no calibration.
    board.press_ms(80).unwrap();
    board.run_ms(2_000).unwrap();
    assert_eq!(flashes(&mut board), 4, "refused");
    // Bounces are no presses: it goes on collecting.
    board.press_ms(80).unwrap();
    for _ in 0..5 {
        board.press_ms(4).unwrap();
        board.run_ms(3).unwrap();
    }
    assert_eq!(flashes(&mut board), 8, "collecting again");
    board.run_ms(6_000).unwrap();
    board.press_ms(80).unwrap();
    board.run_ms(1_000).unwrap();
    assert_eq!(flashes(&mut board), 0, "calibrated: on");
    assert_eq!(ok(&mut board, "status").value("calibrated"), Some("1"));
    board.power_cycle().unwrap();
    board.run_ms(300).unwrap();
    assert_eq!(ok(&mut board, "status").value("calibrated"), Some("1"));
    board.detach(0x1e);
    board.run_ms(500).unwrap();
    assert_eq!(flashes(&mut board), 3, "sensor fault");
}
