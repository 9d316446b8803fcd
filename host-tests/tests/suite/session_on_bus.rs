//! The main job on the simulated bus: the unchanged driver, EEPROM driver and application calibrate, keep and apply.

use crate::common::{accepted_board, calibrate, last, value, world_board};
use ironout::device::{ButtonEvent, Light, SensorFault};
use ironout::sensor::Sample;
use ironout::session::Session;
use ironout_rig::board::SimBoard;
use ironout_simulation::Motion;

/// The magnitudes of the corrected field over `seconds`, and how many samples there were.
fn streamed_norms(board: &mut SimBoard, seconds: u64) -> Vec<f64> {
    assert_eq!(board.command("stream cal"), ["ok stream=cal"]);
    board.run_ms(1000 * seconds);
    let lines = board.received();
    board.command("stream off");
    let norm = |line: &String| -> f64 { line.split(',').nth(5).unwrap().parse().unwrap() };
    assert!(lines.iter().all(|line| line.starts_with("C,")), "only the stream is sent unasked");
    lines.iter().map(norm).collect()
}

fn rms_about(values: &[f64], centre: f64) -> f64 {
    (values.iter().map(|v| (v - centre).powi(2)).sum::<f64>() / values.len() as f64).sqrt()
}

#[test]
fn calibrate_accept_restart_and_it_is_still_applied() {
    let mut board = world_board(Motion::Sphere, 1);
    assert_eq!(board.device.light(), Light::SensorFault, "the sensor was not started yet");
    board.run_ms(100);
    assert_eq!(board.device.light(), Light::Uncalibrated);
    assert_eq!(board.command("field 50"), ["ok field_ut=50.0"]);

    let verdict = calibrate(&mut board, 60);
    assert!(verdict.starts_with("ok verdict=accepted method=adjusted model=ellipsoid n="), "{verdict}");
    assert_eq!(board.device.light(), Light::Solved);
    assert_eq!(value(&last(&mut board, "status"), "calibrated"), "0", "solved is not accepted");
    assert_eq!(last(&mut board, "cal accept"), "ok calibrated=1 slot=0 sequence=1");
    assert_eq!(board.device.light(), Light::Calibrated);

    let offset = board.device.calibration().unwrap().offset_ut;
    for (axis, offset) in offset.into_iter().enumerate() {
        assert!((offset - crate::common::HARD_IRON_UT[axis]).abs() < 0.1, "axis {axis}: {offset}");
    }
    let norms = streamed_norms(&mut board, 20);
    assert!((999..=1001).contains(&norms.len()), "50 a second: {}", norms.len());
    let rms = rms_about(&norms, 50.0);
    assert!(rms < 0.003 * 50.0, "rms of the corrected magnitude {rms} uT");

    let shown = board.command("cal show");
    board.restart();
    board.run_ms(100);
    assert_eq!(board.command("cal show"), shown);
    let status = board.command("status");
    assert_eq!(status[0], "+ hint a calibration is in use; start another one with: cal start");
    assert_eq!(value(status.last().unwrap(), "calibrated"), "1");
    let rms = rms_about(&streamed_norms(&mut board, 20), 50.0);
    assert!(rms < 0.003 * 50.0, "after the restart {rms} uT");
}

#[test]
fn what_cal_show_prints_reads_back_to_the_same_bits() {
    let mut board = accepted_board(2);
    let shown = board.command("cal show");
    let calibration = *board.device.calibration().unwrap();
    let row = |line: &str, key: &str| -> Vec<u64> {
        let numbers = line.strip_prefix(key).unwrap_or_else(|| panic!("{line}"));
        numbers.split(',').map(|number| number.parse::<f64>().unwrap().to_bits()).collect()
    };
    let bits = |numbers: &[f64; 3]| -> Vec<u64> { numbers.iter().map(|n| n.to_bits()).collect() };
    assert_eq!(row(&shown[0], "+ offset_ut="), bits(&calibration.offset_ut));
    for (line, expected) in shown[1..4].iter().zip(&calibration.matrix) {
        assert_eq!(row(line, "+ matrix="), bits(expected));
    }
    assert_eq!(
        value(&shown[4], "field_ut").parse::<f64>().unwrap().to_bits(),
        calibration.field_ut.to_bits()
    );
}

#[test]
fn status_tells_how_far_it_is_and_where_to_turn_next() {
    let mut board = world_board(Motion::Sphere, 3);
    board.run_ms(100);
    let idle = board.command("status");
    assert_eq!(idle[0], "+ hint start a calibration with: cal start");
    assert_eq!(
        idle[1],
        "ok state=idle n=0 skipped=0 coverage=0.000 gap_deg=180.0 rms_ut=- noise_ut=- calibrated=0 faults=0"
    );
    board.command("cal start");
    board.run_ms(3000);
    let early = board.command("status");
    assert!(early[0].starts_with("+ hint keep rotating; bring the "), "{early:?}");
    assert_eq!(value(&early[1], "state"), "collecting");
    board.run_ms(57_000);
    let late = board.command("status");
    assert_eq!(late[0], "+ hint enough directions covered; solve with: cal stop");
    let figure = |answer: &[String], key: &str| value(&answer[1], key).parse::<f64>().unwrap();
    assert!(figure(&late, "coverage") > figure(&early, "coverage") && figure(&late, "coverage") > 0.8);
    assert!(figure(&late, "gap_deg") < figure(&early, "gap_deg"));
    assert!((2900.0..=3000.0).contains(&figure(&late, "n")), "{late:?}");
}

#[test]
fn a_refused_calibration_leaves_the_good_one_in_use() {
    let mut board = accepted_board(4);
    let good = board.command("cal show");
    let flat = crate::common::world(Motion::Planar, 5);
    board.mag.borrow_mut().set_field(move |t_s| flat.sensor_ut(t_s));
    let verdict = calibrate(&mut board, 30);
    assert!(verdict.starts_with("err refused planar "), "{verdict}");
    assert_eq!(board.device.light(), Light::Refused);
    assert!(last(&mut board, "cal accept").starts_with("err refused planar "));
    assert_eq!(board.command("cal show"), good);
    board.restart();
    assert_eq!(board.command("cal show"), good);
}

#[test]
fn a_board_at_rest_is_refused_for_too_few_samples() {
    let mut board = world_board(Motion::Rest, 6);
    board.run_ms(100);
    let verdict = calibrate(&mut board, 30);
    assert!(verdict.starts_with("err refused too-few-samples "), "{verdict}");
    let status = last(&mut board, "status");
    assert!(value(&status, "skipped").parse::<u32>().unwrap() > 1400, "{status}");
}

#[test]
fn samples_out_of_range_are_counted_left_out_and_refused_when_many() {
    let mut board = world_board(Motion::Sphere, 7);
    let strong = crate::common::world_with_hard_iron([215.0, -20.0, 10.0], Motion::Sphere, 7);
    board.mag.borrow_mut().set_field(move |t_s| strong.sensor_ut(t_s));
    board.run_ms(100);
    let verdict = calibrate(&mut board, 40);
    assert!(verdict.starts_with("err refused saturated "), "{verdict}");
    let status = last(&mut board, "status");
    let faults: u32 = value(&status, "faults").parse().unwrap();
    assert!(faults > 20, "{status}");
    assert_eq!(value(&status, "calibrated"), "0");
}

#[test]
fn an_absent_sensor_is_said_and_works_once_it_is_there() {
    let mut board = world_board(Motion::Sphere, 8);
    board.bus.detach(0x1e);
    board.run_ms(5000);
    assert_eq!(board.device.sensor_fault(), Some(SensorFault::NoAnswer));
    for command in ["cal start", "stream raw", "stream cal"] {
        let answer = board.command(command);
        assert!(
            answer.len() == 1 && answer[0].starts_with("err sensor LSM303DLHC does not answer"),
            "{answer:?}"
        );
    }
    let status = board.command("status");
    assert!(status[0].starts_with("+ sensor LSM303DLHC does not answer"), "{status:?}");
    assert_ne!(value(&status[1], "faults"), "0");
    assert!(matches!(board.press(), ButtonEvent::NoSensor(SensorFault::NoAnswer)));
    board.bus.attach(board.mag.clone());
    board.run_ms(3300);
    assert_eq!(board.device.sensor_fault(), None);
    assert!(calibrate(&mut board, 60).starts_with("ok verdict=accepted"));
}

#[test]
fn another_chip_at_the_address_is_named() {
    let mut board = world_board(Motion::Sphere, 9);
    board.mag.borrow_mut().set_identity(*b"H55");
    board.run_ms(500);
    let answer = last(&mut board, "cal start");
    assert!(answer.contains("identity [48, 35, 35] instead of [48, 34, 33]"), "{answer}");
}

#[test]
fn a_sensor_that_goes_and_comes_back_is_configured_afresh_while_collecting() {
    let mut board = world_board(Motion::Sphere, 10);
    board.run_ms(100);
    board.command("cal start");
    board.run_ms(30_000);
    // A dip of its supply: it answers, asleep, and has nothing new. After a second that is noticed.
    board.mag.borrow_mut().power_cycle();
    board.run_ms(1500);
    board.command("stream raw");
    board.run_ms(1000);
    assert!(board.received().len() >= 49, "it measures again");
    board.command("stream off");
    // Off the bus, and back with the defaults of power-up.
    board.bus.detach(0x1e);
    board.run_ms(2000);
    assert_eq!(board.device.light(), Light::SensorFault);
    board.mag.borrow_mut().power_cycle();
    board.bus.attach(board.mag.clone());
    // The lines are held down for a while.
    board.run_ms(4000);
    board.sensor_faults.hold_bus();
    board.run_ms(700);
    board.sensor_faults.clear();
    board.run_ms(30_000);
    let verdict = last(&mut board, "cal stop");
    assert!(verdict.starts_with("ok verdict=accepted"), "{verdict}");
    let offset = board.device.session().solution().unwrap().calibration.offset_ut;
    for (axis, offset) in offset.into_iter().enumerate() {
        assert!((offset - crate::common::HARD_IRON_UT[axis]).abs() < 0.1, "axis {axis}: {offset}");
    }
}

#[test]
fn a_fault_at_any_byte_of_a_sample_costs_that_sample_and_nothing_else() {
    let mut board = accepted_board(11);
    let good = board.command("cal show");
    // The question for data ready has four bytes on the wire, the reading nine.
    for (transaction, bytes) in [(0, 4), (1, 9)] {
        for byte in 0..bytes {
            board.command("stream raw");
            let before = last(&mut board, "status");
            board.sensor_faults.nack_at(transaction, byte);
            board.run_ms(200);
            let lines = board.received();
            let after = last(&mut board, "status");
            let faults = |status: &str| value(status, "faults").parse::<u32>().unwrap();
            assert_eq!(faults(&after), faults(&before) + 1, "transaction {transaction} byte {byte}");
            assert_eq!(lines.len(), 9, "one of ten samples is lost");
            assert_eq!(board.command("cal show"), good);
        }
    }
}

#[test]
fn random_faults_on_the_bus_do_not_spoil_a_calibration() {
    let mut board = world_board(Motion::Sphere, 12);
    board.sensor_faults.nack_randomly(12, 0.01);
    board.run_ms(5000);
    let verdict = calibrate(&mut board, 80);
    assert!(verdict.starts_with("ok verdict=accepted"), "{verdict}");
    let status = last(&mut board, "status");
    assert!(value(&status, "faults").parse::<u32>().unwrap() > 100, "{status}");
    let offset = board.device.session().solution().unwrap().calibration.offset_ut;
    for (axis, offset) in offset.into_iter().enumerate() {
        assert!((offset - crate::common::HARD_IRON_UT[axis]).abs() < 0.1, "axis {axis}: {offset}");
    }
}

#[test]
fn the_button_starts_stops_and_accepts_without_a_word() {
    let mut board = world_board(Motion::Sphere, 13);
    board.run_ms(100);
    assert_eq!(board.press(), ButtonEvent::Started);
    assert_eq!(board.device.light(), Light::Collecting);
    board.run_ms(60_000);
    assert!(matches!(board.press(), ButtonEvent::Accepted(_)));
    assert_eq!(board.device.light(), Light::Calibrated);
    assert_eq!(board.press(), ButtonEvent::Started);
    board.run_ms(200);
    assert_eq!(board.press(), ButtonEvent::Refused, "too few samples");
    assert_eq!(board.received(), [""; 0]);
    let good = board.command("cal show");
    board.restart();
    assert_eq!(board.command("cal show"), good);
}

#[test]
fn the_method_and_the_field_of_the_console_are_those_of_the_fit() {
    let mut board = world_board(Motion::Sphere, 14);
    board.run_ms(100);
    for method in ["adjusted", "trace", "constant"] {
        assert_eq!(last(&mut board, &format!("cal method {method}")), format!("ok method={method}"));
        assert_eq!(last(&mut board, "field 41.25"), "ok field_ut=41.25");
        let verdict = calibrate(&mut board, 60);
        assert!(verdict.starts_with(&format!("ok verdict=accepted method={method} ")), "{verdict}");
        last(&mut board, "cal accept");
        let show = last(&mut board, "cal show");
        assert!(show.starts_with(&format!("ok field_ut=41.25 method={method} ")), "{show}");
    }
}

#[test]
fn the_raw_stream_calibrates_a_host_to_the_same_bits() {
    let mut board = world_board(Motion::Hand, 16);
    board.run_ms(100);
    board.command("stream raw");
    last(&mut board, "cal start");
    board.run_ms(80_000);
    board.send(b"cal stop\n");
    // What came before the reply is what the board has used.
    let mut streamed = board.received();
    let verdict = streamed.pop().unwrap();
    assert!(verdict.starts_with("ok verdict=accepted"), "{verdict}");
    let mut host = Session::new(*board.device.session().config());
    host.start();
    for line in &streamed {
        let numbers: Vec<i64> = line[2..].split(',').map(|number| number.parse().unwrap()).collect();
        let counts = [1, 2, 3].map(|place| i16::try_from(numbers[place]).unwrap());
        host.push(if counts.contains(&-4096) { Sample::out_of_range(counts) } else { Sample::valid(counts) });
    }
    host.stop().unwrap();
    assert_eq!(host.solution(), board.device.session().solution());
    let status = last(&mut board, "status");
    assert_ne!(value(&status, "skipped"), "0", "a hand rests now and then: {status}");
}

#[test]
fn cancelling_forgets_what_was_collected_and_commands_out_of_place_say_so() {
    let mut board = accepted_board(15);
    let good = board.command("cal show");
    for command in ["cal stop", "cal accept", "cal cancel"] {
        assert!(last(&mut board, command).starts_with("err state "), "{command}");
    }
    assert_eq!(last(&mut board, "cal start"), "ok state=collecting");
    assert!(last(&mut board, "cal start").starts_with("err state already collecting"));
    assert!(last(&mut board, "cal accept").starts_with("err state "));
    board.run_ms(5000);
    assert_eq!(last(&mut board, "cal cancel"), "ok state=idle");
    assert_eq!(value(&last(&mut board, "status"), "n"), "0");
    assert_eq!(board.command("cal show"), good);
}
