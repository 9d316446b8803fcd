//! What is wrong is said, and what was there before stays.

use super::same_bits::{SENSOR, stopped};
use super::{expected, trace};
use ironout_c::*;
use std::ffi::CStr;
use std::mem::MaybeUninit;
use std::ptr;

/// A state as static memory begins: zeros.
fn zeros<T>() -> T {
    // SAFETY: the states are arrays of integers.
    unsafe { MaybeUninit::zeroed().assume_init() }
}

#[test]
fn null_misaligned_and_zeroed_states_are_refused() {
    let (counts, mut status) = ([1i16, 2, 3], MaybeUninit::uninit());
    let mut session: IronoutSession = zeros();
    let push = |session| ironout_session_push(session, counts.as_ptr(), 0, 0);
    assert_eq!(push(ptr::null_mut()), IronoutError::IRONOUT_BAD_POINTER);
    assert_eq!(push((&raw mut session).wrapping_byte_add(1)), IronoutError::IRONOUT_BAD_POINTER);
    assert_eq!(push(&mut session), IronoutError::IRONOUT_NOT_INITIALISED);
    let status_of = ironout_session_status(&session, status.as_mut_ptr());
    assert_eq!(status_of, IronoutError::IRONOUT_NOT_INITIALISED);
    let mut live: IronoutLive = zeros();
    let set = ironout_live_set(&mut live, c"temp_c".as_ptr(), 1.0);
    assert_eq!(set, IronoutError::IRONOUT_NOT_INITIALISED);
    assert_eq!(ironout_session_init(&mut session, ptr::null()), IronoutError::IRONOUT_BAD_POINTER);
    assert_eq!(ironout_session_init(&mut session, &SENSOR), IronoutError::IRONOUT_OK);
    assert_eq!(ironout_session_push(&mut session, ptr::null(), 0, 0), IronoutError::IRONOUT_BAD_POINTER);
    assert_eq!(ironout_session_push(&mut session, counts.as_ptr(), 0, 4), IronoutError::IRONOUT_BAD_ARGUMENT);
    let measured_ut = [1.0, f32::NAN, 0.0];
    let pushed = ironout_session_push_ut(&mut session, measured_ut.as_ptr(), 0, 0);
    assert_eq!(pushed, IronoutError::IRONOUT_BAD_ARGUMENT);
    let before = ironout_session_accept(&session, MaybeUninit::uninit().as_mut_ptr());
    assert_eq!(before, IronoutError::IRONOUT_WRONG_STATE);
}

#[test]
fn a_sensor_that_cannot_be_is_refused() {
    let mut session: IronoutSession = zeros();
    for wrong in [
        IronoutSensor { ut_per_count: [0.1, 0.0, 0.1], ..SENSOR },
        IronoutSensor { ut_per_count: [0.1, -0.1, 0.1], ..SENSOR },
        IronoutSensor { rate_hz: -1.0, ..SENSOR },
        IronoutSensor { field_ut: f32::NAN, ..SENSOR },
    ] {
        assert_eq!(ironout_session_init(&mut session, &wrong), IronoutError::IRONOUT_BAD_ARGUMENT);
    }
}

#[test]
fn too_few_samples_are_refused_with_their_number_and_the_old_calibration_stays() {
    let mut session: IronoutSession = zeros();
    assert_eq!(ironout_session_init(&mut session, &SENSOR), IronoutError::IRONOUT_OK);
    for row in &trace::rows()[..15] {
        ironout_session_push(&mut session, row.counts.as_ptr(), row.t_ms, 0);
    }
    let (mut outcome, mut status) = (MaybeUninit::uninit(), MaybeUninit::<IronoutStatus>::uninit());
    assert_eq!(ironout_session_status(&session, status.as_mut_ptr()), IronoutError::IRONOUT_OK);
    // SAFETY: written on success.
    let mut status = unsafe { status.assume_init() };
    assert_eq!(
        (status.state, status.hint),
        (IronoutState::IRONOUT_COLLECTING, IronoutHint::IRONOUT_HINT_MOVE)
    );
    let stopped = ironout_session_stop(&mut session, outcome.as_mut_ptr());
    // SAFETY: written on every refusal.
    let outcome = unsafe { outcome.assume_init() };
    assert_eq!(stopped, IronoutError::IRONOUT_TOO_FEW_SAMPLES);
    assert_eq!((outcome.accepted, outcome.reason_count), (0, 1));
    assert_eq!(outcome.reasons[0].code, IronoutError::IRONOUT_TOO_FEW_SAMPLES);
    assert!(outcome.reasons[0].value < 20.0);
    assert_eq!(ironout_session_stop(&mut session, ptr::null_mut()), IronoutError::IRONOUT_WRONG_STATE);
    let mut old: IronoutCalibration = zeros();
    old.field_ut = 12.0;
    assert_eq!(ironout_session_accept(&session, &mut old), IronoutError::IRONOUT_WRONG_STATE);
    assert_eq!(old.field_ut, 12.0);
    // The hint as a sentence, cut where the room ends.
    status.hint = IronoutHint::IRONOUT_HINT_TURN;
    (status.missing, status.now) = (1 | 8, 16);
    let mut text = [1; 100];
    assert_eq!(ironout_hint_text(&status, text.as_mut_ptr(), text.len()), IronoutError::IRONOUT_OK);
    // SAFETY: a zero byte is at its end.
    let sentence = unsafe { CStr::from_ptr(text.as_ptr()) };
    let right = c"keep turning; bring the front-left side to where the bottom side is now";
    assert_eq!(sentence, right);
    assert_eq!(ironout_hint_text(&status, text.as_mut_ptr(), 5), IronoutError::IRONOUT_OK);
    // SAFETY: as above.
    assert_eq!(unsafe { CStr::from_ptr(text.as_ptr()) }, c"keep");
}

#[test]
fn a_status_that_was_never_written_has_no_hint() {
    // As C may have it: zeros, where no hint is zero.
    let (words, mut text) = ([0u32; 12], [1; 100]);
    let said = ironout_hint_text(words.as_ptr().cast(), text.as_mut_ptr(), text.len());
    assert_eq!(said, IronoutError::IRONOUT_BAD_ARGUMENT);
    assert_eq!(ironout_hint_text(ptr::null(), text.as_mut_ptr(), 100), IronoutError::IRONOUT_BAD_POINTER);
}

#[test]
fn a_gap_in_time_is_a_gap_by_flag_and_changes_what_is_known_of_the_noise() {
    // All samples apart from each other: by flag, by time, and not at all.
    let error_ut = |flag: u32, period_ms: u32| {
        let (mut session, mut accepted): (IronoutSession, IronoutCalibration) = (zeros(), zeros());
        assert_eq!(ironout_session_init(&mut session, &SENSOR), IronoutError::IRONOUT_OK);
        for (i, row) in (0..).zip(trace::rows()) {
            let flags = flag | u32::from(row.out_of_range);
            ironout_session_push(&mut session, row.counts.as_ptr(), i * period_ms, flags);
        }
        assert_eq!(ironout_session_stop(&mut session, ptr::null_mut()), IronoutError::IRONOUT_OK);
        assert_eq!(ironout_session_accept(&session, &mut accepted), IronoutError::IRONOUT_OK);
        accepted.predicted_error_ut
    };
    assert_eq!(error_ut(2, 10), error_ut(0, 41));
    assert_ne!(error_ut(2, 10), error_ut(0, 10));
    assert_eq!(error_ut(0, 40), error_ut(0, 10));
}

#[test]
fn bytes_that_are_no_record_are_named_and_small_buffers_are_not_overrun() {
    let session = stopped(false);
    let (mut bytes, mut length) = ([0xffu8; 512], 0);
    let mut calibration: IronoutCalibration = zeros();
    let decode =
        |bytes: &[u8], to: &mut IronoutCalibration| ironout_record_decode(bytes.as_ptr(), bytes.len(), to);
    assert_eq!(decode(&bytes, &mut calibration), IronoutError::IRONOUT_RECORD_EMPTY);
    let encode = |bytes: &mut [u8], room, length: &mut usize| {
        ironout_record_encode(session.as_ptr(), 1, bytes.as_mut_ptr(), room, length)
    };
    assert_eq!(encode(&mut bytes, 100, &mut length), IronoutError::IRONOUT_TOO_LITTLE_ROOM);
    assert!(bytes.iter().all(|byte| *byte == 0xff) && length == 0);
    assert_eq!(encode(&mut bytes, 512, &mut length), IronoutError::IRONOUT_OK);
    assert_eq!(length, 328, "as the header says");
    assert_eq!(decode(&bytes, &mut calibration), IronoutError::IRONOUT_OK);
    assert_eq!((calibration.sequence, calibration.effects), (1, 0));
    bytes[60] ^= 1;
    assert_eq!(decode(&bytes, &mut calibration), IronoutError::IRONOUT_RECORD_TORN);
    let effects = trace::record_with_effects(expected::record(3)).encode().expect("two effects fit");
    assert_eq!(decode(effects.as_bytes(), &mut calibration), IronoutError::IRONOUT_RECORD_HAS_EFFECTS);
    assert_eq!(calibration.effects, 2);
}

#[test]
fn a_missing_column_is_named_and_nothing_is_corrected_without_it() {
    let record = trace::record_with_effects(expected::record(3)).encode().expect("two effects fit");
    let mut live: IronoutLive = zeros();
    let bytes = record.as_bytes();
    assert_eq!(ironout_live_init(&mut live, bytes.as_ptr(), bytes.len()), IronoutError::IRONOUT_OK);
    let (measured_ut, mut corrected_ut) = ([50.0f32, 1.0, 2.0], [7.0f32; 3]);
    let apply = |live: &mut IronoutLive, corrected: &mut [f32; 3]| {
        ironout_live_apply(live, 1010.0, measured_ut.as_ptr(), ptr::null(), corrected.as_mut_ptr())
    };
    assert_eq!(apply(&mut live, &mut corrected_ut), IronoutError::IRONOUT_COLUMN_UNKNOWN);
    assert_eq!(corrected_ut, [7.0; 3]);
    let mut column = [0; IRONOUT_COLUMN_BYTES];
    assert_eq!(ironout_live_missing(&live, column.as_mut_ptr()), IronoutError::IRONOUT_OK);
    // SAFETY: a zero byte is at its end.
    assert_eq!(unsafe { CStr::from_ptr(column.as_ptr()) }, c"temp_c");
    let other = ironout_live_set(&mut live, c"current_a".as_ptr(), 1.0);
    assert_eq!(other, IronoutError::IRONOUT_COLUMN_NOT_READ);
    assert_eq!(ironout_live_set(&mut live, c"temp_c".as_ptr(), 50.0), IronoutError::IRONOUT_OK);
    assert_eq!(apply(&mut live, &mut corrected_ut), IronoutError::IRONOUT_OK);
    assert_ne!(corrected_ut, [7.0; 3]);
    assert_eq!(ironout_live_missing(&live, column.as_mut_ptr()), IronoutError::IRONOUT_NO_MORE);
    let mut outside: IronoutOutside = zeros();
    assert_eq!(ironout_live_outside(&live, 0, &mut outside), IronoutError::IRONOUT_OK);
    assert_eq!((outside.value, outside.least, outside.greatest), (50.0, 10.0, 40.0));
    assert_eq!(ironout_live_outside(&live, 1, &mut outside), IronoutError::IRONOUT_NO_MORE);
}

#[test]
fn every_code_has_its_text() {
    let text = |code: i32| {
        // SAFETY: the library's own text.
        unsafe { CStr::from_ptr(ironout_error_text(code)) }.to_str().expect("ASCII")
    };
    let header = include_str!("../../include/ironout.h");
    let errors = header.split("enum ironout_error").nth(1).and_then(|rest| rest.split("};").next());
    let codes: Vec<i32> = errors
        .expect("the enum is in the header")
        .lines()
        .filter_map(|line| {
            line.trim().strip_prefix("IRONOUT_")?.trim_end_matches(',').split(" = ").nth(1)?.parse().ok()
        })
        .collect();
    assert_eq!(codes.len(), 31);
    for code in codes {
        assert!(text(code) != "unknown error" && text(code).len() <= 120, "{code}");
    }
    assert_eq!((text(-1), text(1000)), ("unknown error", "unknown error"));
}

#[test]
fn a_heading_and_a_watch() {
    let mut heading = 0.0f32;
    let force = [0.0f32, 0.0, -9.81];
    let east = ironout_heading([0.0f32, -20.0, 45.0].as_ptr(), force.as_ptr(), 3.5, &mut heading);
    assert_eq!(east, IronoutError::IRONOUT_OK);
    assert!((heading - 93.5).abs() < 1e-4);
    let steep =
        ironout_heading([20.0f32, 0.0, 40.0].as_ptr(), [9.81f32, 0.0, 0.0].as_ptr(), 0.0, &mut heading);
    assert_eq!(steep, IronoutError::IRONOUT_STEEP);
    let mut calibration: IronoutCalibration = zeros();
    let mut monitor: IronoutMonitor = zeros();
    let refused = ironout_monitor_init(&mut monitor, &calibration);
    assert_eq!(refused, IronoutError::IRONOUT_BAD_ARGUMENT);
    calibration.field_ut = 50.0;
    assert_eq!(ironout_monitor_init(&mut monitor, &calibration), IronoutError::IRONOUT_OK);
    let mut condition = IronoutCondition::IRONOUT_GOOD;
    let mut watch = |length: f32, t_ms: u32| {
        let corrected_ut = [length, 0.0, 0.0];
        let pushed =
            ironout_monitor_push(&mut monitor, t_ms, corrected_ut.as_ptr(), ptr::null(), &mut condition);
        assert_eq!(pushed, IronoutError::IRONOUT_OK);
        condition
    };
    for i in 0..500u32 {
        assert_eq!(watch(50.05, i * 20), IronoutCondition::IRONOUT_GOOD);
    }
    let disturbed = (500..1000u32).map(|i| watch(70.0, i * 20)).last();
    assert_eq!(disturbed, Some(IronoutCondition::IRONOUT_DISTURBED));
}
