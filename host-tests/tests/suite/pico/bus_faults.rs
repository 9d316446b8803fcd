//! What goes wrong on the I²C bus is reported within a second, and healed when it ends.

use crate::pico::support::{ask, board, figure, ok};
use ironout_rig::chips::{Lis2mdlModel, Qmc5883pModel, RegisterChip};
use ironout_rig::pico::{self, CLOCK_PIN, DATA_PIN, Event, Fault, Pico};
use std::cell::RefCell;
use std::rc::Rc;

/// Whether the sensor works, by what `status` says.
fn complaint(board: &mut Pico) -> Option<String> {
    ok(board, "status").info.into_iter().find(|line| line.starts_with("sensor "))
}

#[test]
fn faults_of_the_bus_are_reported_within_a_second_and_healed() {
    if !pico::available("faults of the bus") {
        return;
    }
    let (mut board, chip) = board(10.0);
    board.run_ms(300).unwrap();
    assert_eq!(complaint(&mut board), None);
    type Setting = (&'static str, fn(&mut Pico), fn(&mut Pico));
    let lines_down: fn(&mut Pico) = |board| {
        board.set_faults(|_, _| Some(Fault::Hang));
        board.drive(DATA_PIN, Some(false)).unwrap();
    };
    let clock_down: fn(&mut Pico) = |board| {
        board.set_faults(|_, _| Some(Fault::Hang));
        board.drive(CLOCK_PIN, Some(false)).unwrap();
    };
    let let_go: fn(&mut Pico) = |board| {
        board.clear_faults();
        board.drive(DATA_PIN, None).unwrap();
        board.drive(CLOCK_PIN, None).unwrap();
    };
    let settings: [Setting; 6] = [
        ("nothing acknowledges", |b| b.set_faults(|_, _| Some(Fault::Nack)), let_go),
        (
            "data is not acknowledged",
            |b| {
                b.set_faults(|event, _| matches!(event, Event::Write(_)).then_some(Fault::Nack));
            },
            let_go,
        ),
        ("every byte hangs", |b| b.set_faults(|_, _| Some(Fault::Hang)), let_go),
        (
            "reading hangs",
            |b| {
                b.set_faults(|event, _| matches!(event, Event::Read).then_some(Fault::Hang));
            },
            let_go,
        ),
        ("the data line is held low", lines_down, let_go),
        ("the clock line is held low", clock_down, let_go),
    ];
    for (what, begin, end) in settings {
        begin(&mut board);
        board.run_ms(900).unwrap();
        let said = complaint(&mut board).unwrap_or_else(|| panic!("{what}: not reported within a second"));
        assert!(said.contains("does not answer on the bus"), "{what}: {said}");
        assert_eq!(ask(&mut board, "cal start").code(), Some("sensor"), "{what}");
        // The longest pause between two attempts is 3.2 s, the next after 0.9 s comes before 0.8 s more.
        end(&mut board);
        board.run_ms(1_500).unwrap();
        assert_eq!(complaint(&mut board), None, "{what}: not healed");
        ok(&mut board, "stream raw");
        board.next_streamed(200).unwrap_or_else(|error| panic!("{what}: {error}"));
        ok(&mut board, "stream off");
        board.take_streamed();
    }
    // The supply of the chip dips: it is configured afresh.
    chip.borrow_mut().power_cycle();
    board.run_ms(2_500).unwrap();
    assert_eq!(complaint(&mut board), None, "not configured afresh");
    ok(&mut board, "stream raw");
    board.next_streamed(200).unwrap();
    let state = board.state().unwrap();
    assert!(state.resets.is_empty(), "{state:?}");
}

#[test]
fn a_late_answer_and_a_single_fault_cost_no_restart() {
    if !pico::available("late answers") {
        return;
    }
    let (mut board, _chip) = board(10.0);
    board.run_ms(300).unwrap();
    // The clock is stretched by 0.2 ms now and then.
    let mut count = 0_u32;
    board.set_faults(move |_, _| {
        count += 1;
        count.is_multiple_of(40).then_some(Fault::Late { ns: 200_000 })
    });
    board.run_ms(1_000).unwrap();
    assert_eq!(figure(&ok(&mut board, "status"), "faults"), 0.0);
    // One transaction in fifty fails.
    let mut count = 0_u32;
    board.set_faults(move |event, _| {
        count += u32::from(matches!(event, Event::Start { .. }));
        (matches!(event, Event::Start { .. }) && count.is_multiple_of(50)).then_some(Fault::Nack)
    });
    board.run_ms(2_000).unwrap();
    let status = ok(&mut board, "status");
    assert!(figure(&status, "faults") >= 3.0, "{status}");
    assert_eq!(complaint(&mut board), None);
}

#[test]
fn a_sensor_that_comes_late_is_taken_up() {
    if !pico::available("late sensor") {
        return;
    }
    let mut board = Pico::start(crate::pico::support::firmware().path()).unwrap();
    board.run_ms(5_000).unwrap();
    assert!(complaint(&mut board).is_some());
    let chip = RegisterChip::new(0x1e, Lis2mdlModel { is_lsm303agr: false }, |_| [20.0, 0.0, 43.0]);
    board.attach(Rc::new(RefCell::new(chip)));
    board.run_ms(3_500).unwrap();
    assert_eq!(complaint(&mut board), None);
    assert_eq!(ok(&mut board, "version").value("sensor"), Some("LIS2MDL"));
    // Another chip in its place is found, and described as what it is.
    board.detach(0x1e);
    board.attach(Rc::new(RefCell::new(RegisterChip::new(0x2c, Qmc5883pModel, |_| [20.0, 0.0, 43.0]))));
    board.run_ms(3_500).unwrap();
    assert_eq!(complaint(&mut board), None);
    assert_eq!(ok(&mut board, "version").value("sensor"), Some("QMC5883P"));
}
