//! One effect in a record.

use super::{Reader, Writer};
use crate::effect::{
    AmbientField, BuiltIn, ColumnName, CrossAxis, Drift, Eddy, Effect, Gain, Lag, MAX_COEFFICIENTS,
    Nonlinearity, Offset, Periodic, Power, Step,
};
use crate::extended::FittedEffect;

// The kinds. A number is never given to another one: records outlive programs.
const OFFSET: u8 = 1;
const OFFSET_SQUARED: u8 = 2;
const OFFSET_LATE: u8 = 3;
const OFFSET_SQUARED_LATE: u8 = 4;
const GAIN: u8 = 5;
const FIELD: u8 = 6;
const DRIFT: u8 = 7;
const STEP: u8 = 8;
const LAG: u8 = 9;
const EDDY: u8 = 10;
const NONLINEARITY: u8 = 11;
const CROSS_AXIS: u8 = 12;
const PERIODIC: u8 = 13;

pub(super) fn write(writer: &mut Writer, fitted: &FittedEffect<f64>, short_errors: bool) {
    let (kind, column, numbers) = match &fitted.effect {
        BuiltIn::Offset(Offset { column, reference, power, delay_s }) => {
            let kind = match (power, delay_s) {
                (Power::Linear, None) => OFFSET,
                (Power::Squared, None) => OFFSET_SQUARED,
                (Power::Linear, Some(_)) => OFFSET_LATE,
                (Power::Squared, Some(_)) => OFFSET_SQUARED_LATE,
            };
            (kind, Some(column), [Some(*reference), *delay_s])
        }
        BuiltIn::Gain(Gain { column, reference }) => (GAIN, Some(column), [Some(*reference), None]),
        BuiltIn::Field(AmbientField { column, reference }) => (FIELD, Some(column), [Some(*reference), None]),
        BuiltIn::Drift(Drift { reference_s }) => (DRIFT, None, [Some(*reference_s), None]),
        BuiltIn::Step(Step { at_s }) => (STEP, None, [None, Some(*at_s)]),
        BuiltIn::Lag(Lag) => (LAG, None, [None; 2]),
        BuiltIn::Eddy(Eddy) => (EDDY, None, [None; 2]),
        BuiltIn::Nonlinearity(Nonlinearity) => (NONLINEARITY, None, [None; 2]),
        BuiltIn::CrossAxis(CrossAxis) => (CROSS_AXIS, None, [None; 2]),
        BuiltIn::Periodic(Periodic { frequency_hz, reference_s }) => {
            (PERIODIC, None, [Some(*reference_s), Some(*frequency_hz)])
        }
    };
    let name = column.map_or("", ColumnName::as_str).as_bytes();
    writer.put(&[kind, name.len() as u8]);
    writer.put(name);
    numbers.into_iter().flatten().for_each(|number| writer.float(number));
    let k = fitted.effect.coefficients();
    fitted.coefficients.iter().take(k).for_each(|value| writer.float(*value));
    for value in fitted.std_errors.iter().take(k) {
        let single = (*value as f32).to_bits();
        if short_errors {
            // Rounded up: an error is rather told too large. A NaN stays one, infinity too.
            let up = if value.is_finite() { single.saturating_add(0xffff) } else { single };
            writer.put(&((up >> 16) as u16).to_le_bytes());
        } else {
            writer.put(&single.to_le_bytes());
        }
    }
}

/// `None` where the bytes are no effect.
pub(super) fn read(reader: &mut Reader<'_>, short_errors: bool) -> Option<FittedEffect<f64>> {
    let [kind, length] = reader.take().ok()?;
    let name = core::str::from_utf8(reader.slice(usize::from(length)).ok()?).ok()?;
    if !(OFFSET..=FIELD).contains(&kind) && !name.is_empty() {
        return None;
    }
    let column = || ColumnName::new(name).ok();
    let mut float = || reader.float().ok();
    let mut offset = |power, late: bool| {
        let (column, reference) = (column()?, float()?);
        let delay_s = if late { Some(float()?) } else { None };
        Some(BuiltIn::Offset(Offset { column, reference, power, delay_s }))
    };
    let effect = match kind {
        OFFSET => offset(Power::Linear, false)?,
        OFFSET_SQUARED => offset(Power::Squared, false)?,
        OFFSET_LATE => offset(Power::Linear, true)?,
        OFFSET_SQUARED_LATE => offset(Power::Squared, true)?,
        GAIN => BuiltIn::Gain(Gain { column: column()?, reference: float()? }),
        FIELD => BuiltIn::Field(AmbientField { column: column()?, reference: float()? }),
        DRIFT => BuiltIn::Drift(Drift { reference_s: float()? }),
        STEP => BuiltIn::Step(Step { at_s: float()? }),
        LAG => BuiltIn::Lag(Lag),
        EDDY => BuiltIn::Eddy(Eddy),
        NONLINEARITY => BuiltIn::Nonlinearity(Nonlinearity),
        CROSS_AXIS => BuiltIn::CrossAxis(CrossAxis),
        PERIODIC => {
            let (reference_s, frequency_hz) = (float()?, float()?);
            BuiltIn::Periodic(Periodic { frequency_hz, reference_s })
        }
        _ => return None,
    };
    let k = Effect::<f64>::coefficients(&effect);
    let (mut coefficients, mut std_errors) = ([0.0; MAX_COEFFICIENTS], [0.0; MAX_COEFFICIENTS]);
    for value in coefficients.iter_mut().take(k) {
        *value = reader.float().ok()?;
    }
    for value in std_errors.iter_mut().take(k) {
        let single = match short_errors {
            true => u32::from(u16::from_le_bytes(reader.take().ok()?)) << 16,
            false => u32::from_le_bytes(reader.take().ok()?),
        };
        *value = f64::from(f32::from_bits(single));
    }
    Some(FittedEffect { effect, coefficients, std_errors })
}
