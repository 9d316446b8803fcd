//! Whether a record has room for the effects that a calibration may carry.

use ironout::calibration::Calibration;
use ironout::effect::{
    AmbientField, BuiltIn, ColumnName, CrossAxis, Drift, Eddy, Effect, Gain, Lag, Nonlinearity, Offset,
    Periodic, Power, Step,
};
use ironout::extended::{Effects, FittedEffect};
use ironout::fit::{Method, Model};
use ironout::record::{MAX_RECORD_BYTES, Record, VERSION_SHORT_ERRORS};

/// A record with these effects, their coefficients and errors all different.
fn with(chosen: [BuiltIn<f64>; 4]) -> Record {
    let mut effects = Effects::none();
    for effect in chosen {
        let k = Effect::<f64>::coefficients(&effect);
        let value = |scale: f64| move |i: usize| if i < k { scale * (i as f64 + 1.5) } else { 0.0 };
        let fitted = FittedEffect {
            effect,
            coefficients: std::array::from_fn(value(-1.0 / 3.0)),
            std_errors: std::array::from_fn(value(0.001)).map(|error| f64::from(error as f32)),
        };
        effects.push(fitted).expect("four at most");
    }
    Record {
        sequence: 7,
        calibration: Calibration::identity(48.0),
        effects,
        method: Method::Adjusted,
        model: Model::Ellipsoid,
        samples: 3000,
        noise_ut: 0.25,
        rms_ut: 0.26,
        axes: None,
    }
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
                    let record = with([choices[a], choices[b], choices[c], choices[d]]);
                    let encoded = record.encode().expect("any four fit");
                    let bytes = encoded.as_bytes();
                    longest = longest.max(bytes.len());
                    let back = Record::decode(bytes).unwrap();
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
