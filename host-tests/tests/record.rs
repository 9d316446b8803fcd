//! The stored record, in bytes that can be torn and flipped.

#[path = "common/records.rs"]
mod records;

use ironout::effect::{
    AmbientField, BuiltIn, ColumnName, CrossAxis, Drift, Eddy, Gain, Lag, Nonlinearity, Offset, Periodic,
    Power, Step,
};
use ironout::extended::Effects;
use ironout::fit::{Method, Order};
use ironout::record::{
    MAX_RECORD_BYTES, RECORD_BYTES, Record, RecordError, VERSION, VERSION_SHORT_ERRORS, VERSION_WITH_EFFECTS,
    is_newer,
};
use ironout::sensor::AxisMap;
use proptest::collection::vec;
use proptest::prelude::*;
use records::{all_effects, bytes, fitted, record, with, with_crc};

#[test]
fn a_record_reads_back_to_the_same_bits() {
    let written = Record { sequence: 7, ..record(93.25) };
    let read = Record::decode(&bytes(&written)).unwrap();
    assert_eq!(read, written);
    assert_eq!(read.calibration.offset_ut[1].to_bits(), (-1.0_f64 / 3.0).to_bits());
    for method in [Method::Adjusted, Method::Trace, Method::Constant] {
        for model in [Order::Ellipsoid, Order::AxisAligned, Order::Sphere] {
            let written = Record { method, model, ..written };
            assert_eq!(Record::decode(&bytes(&written)), Ok(written));
        }
    }
}

#[test]
fn effects_read_back_to_the_same_bits() {
    for effect in all_effects() {
        let written = with(&[effect]);
        assert_eq!(Record::decode(&bytes(&written)), Ok(written), "{effect:?}");
        assert_eq!(bytes(&written)[4], VERSION_WITH_EFFECTS);
    }
    let usual = &all_effects()[..4];
    assert_eq!(Record::decode(&bytes(&with(usual))), Ok(with(usual)), "four of the usual kind fit");
}

#[test]
fn a_record_without_effects_is_one_that_older_firmware_reads() {
    let plain = bytes(&record(93.25));
    assert_eq!((plain.len(), plain[4], plain[7]), (RECORD_BYTES, VERSION, 0));
}

#[test]
fn any_four_different_effects_fit_whatever_their_columns_are_called() {
    let name = |n: usize| ColumnName::new(&format!("{n:032}")).unwrap();
    // What is in a record at most once, and what may be there for several columns, steps or tones.
    let of_column = |n: usize| {
        let late =
            |power| BuiltIn::Offset(Offset { column: name(n), reference: 0.1, power, delay_s: Some(0.3) });
        [
            late(Power::Linear),
            late(Power::Squared),
            BuiltIn::Gain(Gain { column: name(n), reference: 25.0 }),
            BuiltIn::Field(AmbientField { column: name(n), reference: 0.5 }),
            BuiltIn::Step(Step { at_s: n as f64 }),
            BuiltIn::Periodic(Periodic { frequency_hz: 1.0 + n as f64, reference_s: 0.1 }),
        ]
    };
    let mut choices: Vec<BuiltIn<f64>> = (0..4).flat_map(of_column).collect();
    choices.extend([
        BuiltIn::Drift(Drift { reference_s: 0.3 }),
        BuiltIn::Lag(Lag),
        BuiltIn::Eddy(Eddy),
        BuiltIn::Nonlinearity(Nonlinearity),
        BuiltIn::CrossAxis(CrossAxis),
    ]);
    let (mut longest, mut short) = (0, 0);
    for a in 0..choices.len() {
        for b in a + 1..choices.len() {
            for c in b + 1..choices.len() {
                for d in c + 1..choices.len() {
                    let record = with(&[choices[a], choices[b], choices[c], choices[d]]);
                    let bytes = bytes(&record);
                    longest = longest.max(bytes.len());
                    let back = Record::decode(&bytes).unwrap();
                    if bytes[4] == VERSION_SHORT_ERRORS {
                        short += 1;
                        for (kept, written) in back.effects.iter().zip(record.effects.iter()) {
                            assert_eq!(kept.coefficients, written.coefficients);
                            for (kept, written) in kept.std_errors.iter().zip(written.std_errors) {
                                assert!((written..=1.01 * written).contains(kept), "{kept} for {written}");
                            }
                        }
                    } else {
                        assert_eq!(back, record);
                    }
                }
            }
        }
    }
    assert!(longest <= MAX_RECORD_BYTES && short > 0, "{longest} bytes, {short} with short errors");
}

#[test]
fn how_the_sensor_was_mounted_is_kept_and_a_mounting_that_is_none_is_unsound() {
    for code in 0..=48 {
        let written = Record { axes: AxisMap::of_code(code), ..record(1.0) };
        assert_eq!(bytes(&written)[14], code);
        assert_eq!(Record::decode(&bytes(&written)), Ok(written));
    }
    let mut odd = bytes(&record(1.0));
    odd[14] = 49;
    assert_eq!(Record::decode(&with_crc(odd)), Err(RecordError::Unsound { sequence: 0 }));
}

#[test]
fn a_record_with_effects_cut_or_flipped_anywhere_is_torn() {
    let good = bytes(&with(&all_effects()[2..5]));
    for bit in 0..good.len() * 8 {
        let mut bad = good.clone();
        bad[bit / 8] ^= 1 << (bit % 8);
        assert_eq!(Record::decode(&bad), Err(RecordError::Torn), "bit {bit}");
    }
    for length in 1..good.len() {
        assert_eq!(Record::decode(&good[..length]), Err(RecordError::Torn), "{length} bytes");
    }
    let sound = with(&all_effects()[..1]);
    let mut nan = sound;
    nan.effects = Effects::none();
    let mut broken = fitted(all_effects()[0]);
    broken.coefficients[1] = f64::NAN;
    nan.effects.push(broken).unwrap();
    assert_eq!(Record::decode(&bytes(&nan)), Err(RecordError::Unsound { sequence: 0 }));
}

#[test]
fn every_single_flipped_bit_is_noticed() {
    let good = bytes(&record(93.25));
    for bit in 0..RECORD_BYTES * 8 {
        let mut bad = good.clone();
        bad[bit / 8] ^= 1 << (bit % 8);
        assert_eq!(Record::decode(&bad), Err(RecordError::Torn), "bit {bit}");
    }
}

#[test]
fn a_record_cut_short_is_torn_and_nothing_is_empty() {
    let good = bytes(&record(93.25));
    for length in 1..RECORD_BYTES {
        assert_eq!(Record::decode(&good[..length]), Err(RecordError::Torn), "{length} bytes");
        let mut half = [0xff; MAX_RECORD_BYTES];
        half[..length].copy_from_slice(&good[..length]);
        assert_eq!(Record::decode(&half), Err(RecordError::Torn), "{length} bytes in erased memory");
    }
    for blank in [0x00, 0xff] {
        assert_eq!(Record::decode(&[blank; MAX_RECORD_BYTES]), Err(RecordError::Empty));
    }
}

#[test]
fn a_newer_layout_is_told_from_damage_and_unsound_numbers_are_refused() {
    let good = bytes(&Record { sequence: 9, ..record(1.0) });
    assert_eq!(with_crc(good.clone()), good, "the test's own checksum agrees with the record's");

    let mut longer = good.clone();
    longer.splice(144..144, [7; 88]);
    (longer[4], longer[7]) = (4, 1);
    longer[12..14].copy_from_slice(&236_u16.to_le_bytes());
    let newer = RecordError::Unsupported { version: 4, sequence: 9 };
    assert_eq!(Record::decode(&with_crc(longer)), Err(newer));

    for (at, value) in [(16, f64::NAN), (16, -48.0), (24, f64::INFINITY), (48, 0.0), (128, f64::NAN)] {
        let mut bad = good.clone();
        bad[at..at + 8].copy_from_slice(&value.to_le_bytes());
        assert_eq!(
            Record::decode(&with_crc(bad)),
            Err(RecordError::Unsound { sequence: 9 }),
            "{value} at {at}"
        );
    }
    let mut bad = good.clone();
    bad[5] = 99;
    assert_eq!(Record::decode(&with_crc(bad)), Err(RecordError::Unsound { sequence: 9 }));
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_bytes_are_refused_by_name_or_read(
        bytes in prop_oneof![
            vec(any::<u8>(), 0..600),
            // A record with a few bytes changed and its checksum made right again.
            vec((0..200_usize, any::<u8>()), 0..6).prop_map(|changes| {
                let mut bytes = bytes(&with(&all_effects()[..2]));
                changes.into_iter().for_each(|(at, byte)| bytes[at] = byte);
                with_crc(bytes)
            }),
        ]
    ) {
        if let Ok(record) = Record::decode(&bytes) {
            // The reserved bytes are written as 0 whatever they were.
            let again = Record::decode(record.encode().expect("it fits").as_bytes());
            prop_assert_eq!(again, Ok(record));
            prop_assert!(record.calibration.is_sound());
        }
    }
}

#[test]
fn sequence_numbers_are_compared_on_the_circle() {
    assert!(is_newer(2, 1) && !is_newer(1, 2) && !is_newer(1, 1));
    assert!(is_newer(0, u32::MAX) && !is_newer(u32::MAX, 0));
}
