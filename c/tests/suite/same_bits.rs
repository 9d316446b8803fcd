//! The C interface gives the bits of the Rust library.

use super::{expected, trace};
use ironout_c::{
    IronoutCalibration, IronoutError, IronoutSensor, IronoutSession, ironout_apply_counts, ironout_apply_ut,
    ironout_record_decode, ironout_record_encode, ironout_session_accept, ironout_session_init,
    ironout_session_push, ironout_session_push_ut, ironout_session_stop,
};
use std::mem::MaybeUninit;
use std::ptr;

pub const SENSOR: IronoutSensor =
    IronoutSensor { ut_per_count: trace::UT_PER_COUNT, rate_hz: trace::RATE_HZ, field_ut: trace::FIELD_UT };

/// A session that was stopped at the end of the trace.
pub fn stopped(in_ut: bool) -> MaybeUninit<IronoutSession> {
    let mut session = MaybeUninit::uninit();
    assert_eq!(ironout_session_init(session.as_mut_ptr(), &SENSOR), IronoutError::IRONOUT_OK);
    for row in trace::rows() {
        let flags = u32::from(row.out_of_range);
        let pushed = if in_ut {
            ironout_session_push_ut(
                session.as_mut_ptr(),
                expected::measured_ut(&row).as_ptr(),
                row.t_ms,
                flags,
            )
        } else {
            ironout_session_push(session.as_mut_ptr(), row.counts.as_ptr(), row.t_ms, flags)
        };
        assert_eq!(pushed, IronoutError::IRONOUT_OK);
    }
    assert_eq!(ironout_session_stop(session.as_mut_ptr(), ptr::null_mut()), IronoutError::IRONOUT_OK);
    session
}

#[test]
fn a_session_of_counts_or_of_microtesla_gives_the_record_of_rust() {
    let kept = expected::record(7).encode().expect("a record without effects fits");
    for in_ut in [false, true] {
        let session = stopped(in_ut);
        let (mut bytes, mut length) = ([0u8; 512], 0);
        let room = bytes.len();
        let encoded = ironout_record_encode(session.as_ptr(), 7, bytes.as_mut_ptr(), room, &mut length);
        assert_eq!(encoded, IronoutError::IRONOUT_OK);
        assert!(bytes[..length] == *kept.as_bytes(), "in µT: {in_ut}");
    }
}

#[test]
fn an_accepted_calibration_and_a_decoded_one_correct_as_rust_does() {
    let single = expected::report().calibration.cast::<f32>();
    let mut accepted = MaybeUninit::<IronoutCalibration>::uninit();
    let session = stopped(false);
    assert_eq!(ironout_session_accept(session.as_ptr(), accepted.as_mut_ptr()), IronoutError::IRONOUT_OK);
    let mut decoded = MaybeUninit::<IronoutCalibration>::uninit();
    let record = expected::record(1).encode().expect("a record without effects fits");
    let bytes = record.as_bytes();
    let read = ironout_record_decode(bytes.as_ptr(), bytes.len(), decoded.as_mut_ptr());
    assert_eq!(read, IronoutError::IRONOUT_OK);
    for row in trace::rows() {
        let measured_ut = expected::measured_ut(&row);
        let right = single.apply(measured_ut);
        for calibration in [&accepted, &decoded] {
            let (mut counted, mut applied) = ([0.0f32; 3], [0.0f32; 3]);
            let by_counts = ironout_apply_counts(
                calibration.as_ptr(),
                &SENSOR,
                row.counts.as_ptr(),
                counted.as_mut_ptr(),
            );
            let by_ut = ironout_apply_ut(calibration.as_ptr(), measured_ut.as_ptr(), applied.as_mut_ptr());
            assert_eq!((by_counts, by_ut), (IronoutError::IRONOUT_OK, IronoutError::IRONOUT_OK));
            assert_eq!(counted.map(f32::to_bits), right.map(f32::to_bits));
            assert_eq!(applied.map(f32::to_bits), right.map(f32::to_bits));
        }
    }
}

/// Writes what `c/check` compares the C programs with.
#[test]
fn the_trace_and_what_c_has_to_print_of_it() {
    let text = expected::text();
    assert!(text.lines().filter(|line| line.starts_with("live ")).any(|line| line.ends_with(" temp_c t_s")));
    assert!(text.lines().filter(|line| line.starts_with("sample ")).any(|line| !line.contains("none")));
    let Some(folder) = std::env::var_os("IRONOUT_C_TRACE") else { return };
    let folder = std::path::Path::new(&folder);
    let record = trace::record_with_effects(expected::record(3)).encode().expect("two effects fit");
    std::fs::write(folder.join("trace.txt"), trace::text()).expect("the folder is there");
    std::fs::write(folder.join("effects.rec"), record.as_bytes()).expect("the folder is there");
    std::fs::write(folder.join("expected.txt"), text).expect("the folder is there");
}
