//! The stored record, in bytes that can be torn and flipped.

use crate::common::records::{all_effects, bytes, fitted, record, with, with_crc, with_ranges};
use ironout::effect::{
    AmbientField, Bends, BuiltIn, ColumnName, CrossAxis, Drift, Eddy, Effect, Gain, Lag, Nonlinearity,
    Offset, Past, Periodic, Power, Step,
};
use ironout::extended::Effects;
use ironout::fit::{Method, Order};
use ironout::record::{
    COVARIANCE_BYTES, Covariance, HOLDS_FOR_BYTES, HoldsFor, MAX_RECORD_BYTES, RECORD_BYTES, Record,
    RecordError, VERSION, VERSION_SHORT_ERRORS, VERSION_WITH_EFFECTS, VERSION_WITH_RANGES,
    VERSION_WITH_RANGES_SHORT_ERRORS, WITH_COVARIANCE, WITH_HOLDS_FOR, is_newer,
};
use ironout::sensor::AxisMap;
use proptest::collection::vec;
use proptest::prelude::*;

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
        for bends in [Bends::Reading, Bends::Field] {
            let mut written = with(&[]);
            written.effects.push(fitted(effect).bending(bends)).expect("room for one");
            assert_eq!(Record::decode(&bytes(&written)), Ok(written), "{effect:?}");
            assert_eq!(bytes(&written)[4], VERSION_WITH_EFFECTS);
        }
    }
    let usual = &all_effects()[..4];
    assert_eq!(Record::decode(&bytes(&with(usual))), Ok(with(usual)), "four of the usual kind fit");
}

#[test]
fn a_record_without_effects_is_one_that_older_firmware_reads() {
    let plain = bytes(&record(93.25));
    assert_eq!((plain.len(), plain[4], plain[7]), (RECORD_BYTES, VERSION, 0));
}

/// The tilts of a vehicle.
const TILTS: HoldsFor =
    HoldsFor { tilt_deg: 7.0, down: [0.0, -0.6, 0.8], heading_errors_deg: [0.3, 1.9, 3.75, 8.0] };

#[test]
fn the_tilts_that_a_calibration_holds_for_read_back_with_all_else() {
    let plain = record(93.25);
    let covariance = Some(covariance());
    let effects = with(&all_effects()[..2]);
    for (without, version) in [
        (plain, VERSION),
        (Record { covariance, ..plain }, VERSION + WITH_COVARIANCE),
        (effects, VERSION_WITH_EFFECTS),
        (with_ranges(&effects), VERSION_WITH_RANGES),
    ] {
        let written = Record { holds_for: Some(TILTS), ..without };
        let (before, after) = (bytes(&without), bytes(&written));
        assert_eq!((before[4], after[4]), (version, version + WITH_HOLDS_FOR));
        assert_eq!(after.len(), before.len() + HOLDS_FOR_BYTES);
        assert_eq!(Record::decode(&after), Ok(written));
    }
}

#[test]
fn tilts_that_are_none_are_unsound() {
    for tilts in [
        HoldsFor { tilt_deg: 0.0, ..TILTS },
        HoldsFor { tilt_deg: f32::NAN, ..TILTS },
        HoldsFor { down: [0.0; 3], ..TILTS },
        HoldsFor { heading_errors_deg: [0.3, -1.0, 2.0, 3.0], ..TILTS },
    ] {
        let written = bytes(&Record { sequence: 5, holds_for: Some(tilts), ..record(1.0) });
        assert_eq!(Record::decode(&written), Err(RecordError::Unsound { sequence: 5 }), "{tilts:?}");
    }
}

/// A covariance whose numbers all differ.
fn covariance() -> Covariance {
    let entry = |i: usize, k: usize| {
        let (low, high) = (i.min(k), i.max(k));
        1e-6 * (low * 9 + high) as f64 + if i == k { 1.0 / (1.0 + i as f64) } else { 0.0 }
    };
    Covariance::of(&std::array::from_fn(|i| std::array::from_fn(|k| entry(i, k)))).expect("it is one")
}

#[test]
fn a_covariance_reads_back_where_there_is_room_for_it() {
    let plain = Record { covariance: Some(covariance()), ..record(93.25) };
    let written = bytes(&plain);
    assert_eq!((written.len(), written[4]), (RECORD_BYTES + COVARIANCE_BYTES, VERSION + WITH_COVARIANCE));
    assert_eq!(Record::decode(&written), Ok(plain));
    for bit in 0..written.len() * 8 {
        let mut bad = written.clone();
        bad[bit / 8] ^= 1 << (bit % 8);
        assert_eq!(Record::decode(&bad), Err(RecordError::Torn), "bit {bit}");
    }
    // Beside an effect and its range too.
    let one = Record { covariance: Some(covariance()), ..with_ranges(&with(&all_effects()[..1])) };
    assert_eq!(bytes(&one)[4], VERSION_WITH_RANGES + WITH_COVARIANCE);
    assert_eq!(Record::decode(&bytes(&one)), Ok(one));
    // Beside four there is none: nothing else is given up for it.
    let four = with_ranges(&with(&all_effects()[..4]));
    let kept = Record { covariance: Some(covariance()), ..four };
    assert_eq!(bytes(&kept), bytes(&four));
    // What is none is unsound, and a record cut where it begins is torn.
    let variance_at = RECORD_BYTES - 4;
    for value in [f32::NAN, f32::INFINITY, 0.0, -1.0] {
        let mut bad = written.clone();
        bad[variance_at..variance_at + 4].copy_from_slice(&value.to_le_bytes());
        assert_eq!(Record::decode(&with_crc(bad)), Err(RecordError::Unsound { sequence: 0 }), "{value}");
    }
    let mut short = written.clone();
    short.truncate(RECORD_BYTES);
    assert_eq!(Record::decode(&short), Err(RecordError::Torn));
}

#[test]
fn a_covariance_that_no_single_precision_holds_is_none() {
    let unit = |value: f64| -> [[f64; 9]; 9] {
        std::array::from_fn(|i| std::array::from_fn(|k| if i == k { value } else { 0.0 }))
    };
    assert!(Covariance::of(&unit(1e-12)).is_some());
    for value in [0.0, -1.0, 1e-60, 1e60, f64::NAN] {
        assert_eq!(Covariance::of(&unit(value)), None, "{value}");
    }
    assert_eq!(covariance().rows().map(<[f32]>::len).collect::<Vec<_>>(), [9, 8, 7, 6, 5, 4, 3, 2, 1]);
    let matrix = covariance().matrix();
    assert!((0..9).all(|i| (0..9).all(|k| matrix[i][k].to_bits() == matrix[k][i].to_bits())));
    assert_eq!(Covariance::of(&matrix), Some(covariance()));
}

#[test]
fn any_four_different_effects_fit_whatever_their_columns_are_called() {
    let name = |n: usize| ColumnName::new(&format!("{n:032}")).unwrap();
    // What is in a record at most once, and what may be there for several columns, steps or tones.
    let of_column = |n: usize| {
        let late = |power| {
            BuiltIn::Offset(Offset { column: name(n), reference: 0.1, power, past: Past::Delayed(0.3) })
        };
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
                    let record = with_ranges(&with(&[choices[a], choices[b], choices[c], choices[d]]));
                    let bytes = bytes(&record);
                    longest = longest.max(bytes.len());
                    let back = Record::decode(&bytes).unwrap();
                    if bytes[4] == VERSION_WITH_RANGES_SHORT_ERRORS {
                        short += 1;
                        for (kept, written) in back.effects.iter().zip(record.effects.iter()) {
                            assert_eq!(kept.coefficients, written.coefficients);
                            assert_eq!(kept.ranges, written.ranges);
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
fn ranges_read_back_and_older_layouts_are_written_where_there_is_none() {
    for effect in all_effects() {
        let written = with_ranges(&with(&[effect]));
        let version = if effect.columns()[0].is_some() { VERSION_WITH_RANGES } else { VERSION_WITH_EFFECTS };
        assert_eq!(bytes(&written)[4], version, "{effect:?}");
        assert_eq!(Record::decode(&bytes(&written)), Ok(written), "{effect:?}");
    }
    // Of one effect the range is known, of the other not.
    let mut one = with(&all_effects()[..1]);
    let [known, ..] = all_effects();
    one.effects.push(fitted(known).over([Some([-3.5, 60.25]), None])).unwrap();
    assert_eq!(Record::decode(&bytes(&one)), Ok(one));
    // Too long with whole standard errors: without ranges the layout that firmware of before them reads.
    let [.., tone] = all_effects();
    let long = with(&[BuiltIn::Eddy(Eddy), tone, tone, tone]);
    assert_eq!(bytes(&long)[4], VERSION_SHORT_ERRORS);
    assert_eq!(bytes(&with_ranges(&long))[4], VERSION_WITH_RANGES_SHORT_ERRORS);
}

#[test]
fn a_range_is_rounded_outward_and_one_that_ends_before_it_begins_is_unsound() {
    let kept = |least: f64, most: f64| {
        let mut record = record(1.0);
        record.effects.push(fitted(all_effects()[0]).over([Some([least, most]), None])).unwrap();
        Record::decode(&bytes(&record)).map(|record| record.effects.iter().next().unwrap().ranges[0])
    };
    for ends @ [least, most] in
        [[0.1, 0.7], [-0.7, -0.1], [1.7e9 + 1.0, 1.7e9 + 61.0], [1e300, 2e300], [0.0, 1e-60]]
    {
        let [low, high] = kept(least, most).unwrap().unwrap();
        assert!(low <= least && most <= high, "{ends:?}: {low} {high}");
        let step = |value: f64| 2e-7 * value.abs() + 1e-44;
        assert!(
            least > 1e38 || (least - low <= step(least) && high - most <= step(most)),
            "{ends:?}: {low} {high}"
        );
    }
    let unsound = Err(RecordError::Unsound { sequence: 0 });
    for (least, most) in [(1.0, 0.5), (f64::NAN, 1.0), (1.0, f64::NAN)] {
        assert_eq!(kept(least, most), unsound, "{least} {most}");
    }
    assert_eq!(kept(f64::NAN, f64::NAN), Ok(None), "it is not known");
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
    let good = bytes(&with_ranges(&with(&all_effects()[2..5])));
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
    (longer[4], longer[7]) = (11, 1);
    longer[12..14].copy_from_slice(&236_u16.to_le_bytes());
    let newer = RecordError::Unsupported { version: 11, sequence: 9 };
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
                let mut bytes = bytes(&with_ranges(&with(&all_effects()[..2])));
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
