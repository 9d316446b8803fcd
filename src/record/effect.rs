//! One effect in a record.
//!
//! Which number stands for which form of effect, and what of it is written, the effect's own file says
//! ([`crate::effect::Form`]).

use super::layout::{Reader, Writer};
use crate::effect::{BuiltIn, ColumnName, Effect, MAX_COEFFICIENTS, Parts};
use crate::extended::FittedEffect;

pub(super) fn write(writer: &mut Writer, fitted: &FittedEffect<f64>, short_errors: bool) {
    let parts = fitted.effect.parts();
    let name = parts.column.as_str().as_bytes();
    writer.put(&[parts.form.tag, name.len() as u8]);
    writer.put(name);
    let numbers = [parts.reference(), parts.parameter().map(|(_, value)| value)];
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
    let [tag, length] = reader.take().ok()?;
    let form = BuiltIn::<f64>::form(tag)?;
    let name = core::str::from_utf8(reader.slice(usize::from(length)).ok()?).ok()?;
    let mut parts = Parts::<ColumnName>::of(form);
    if form.column {
        parts.column = ColumnName::new(name).ok()?;
    } else if !name.is_empty() {
        return None;
    }
    if parts.reference().is_some() {
        parts.reference = reader.float().ok()?;
    }
    if parts.parameter().is_some() {
        parts.parameter = reader.float().ok()?;
    }
    let effect = BuiltIn::of(&parts)?;
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
