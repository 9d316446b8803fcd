//! One effect in a record.
//!
//! Which number stands for which form of effect, and what of it is written, the effect's own file says
//! ([`crate::effect::Form`]).

use super::layout::{EffectLayout, Reader, Writer};
use crate::effect::{Bends, BuiltIn, ColumnName, Effect, MAX_COEFFICIENTS, MAX_INPUTS, Parts};
use crate::extended::FittedEffect;

/// The bit beside a form's number of an effect that bends the field.
const BENDS_FIELD: u8 = 0x80;

pub(super) fn write(writer: &mut Writer, fitted: &FittedEffect<f64>, layout: EffectLayout) {
    let parts = fitted.effect.parts();
    let name = parts.column.as_str().as_bytes();
    let bends = if fitted.bends == Bends::Field { BENDS_FIELD } else { 0 };
    writer.put(&[parts.form.tag | bends, name.len() as u8]);
    writer.put(name);
    let numbers = [parts.reference(), parts.parameter().map(|(_, value)| value)];
    numbers.into_iter().flatten().for_each(|number| writer.float(number));
    let k = fitted.effect.coefficients();
    fitted.coefficients.iter().take(k).for_each(|value| writer.float(*value));
    for value in fitted.std_errors.iter().take(k) {
        let single = (*value as f32).to_bits();
        if layout.short_errors {
            // Rounded up: an error is rather told too large. A NaN stays one, infinity too.
            let up = if value.is_finite() { single.saturating_add(0xffff) } else { single };
            writer.put(&((up >> 16) as u16).to_le_bytes());
        } else {
            writer.put(&single.to_le_bytes());
        }
    }
    if layout.ranges {
        for (range, column) in fitted.ranges.iter().zip(fitted.effect.columns()) {
            if column.is_some() {
                let ends = range.map_or([f32::NAN; 2], outward);
                ends.into_iter().for_each(|end| writer.put(&end.to_le_bytes()));
            }
        }
    }
}

/// A range in single precision: no value that lies inside is outside of it.
fn outward([least, most]: [f64; 2]) -> [f32; 2] {
    let (low, high) = (least as f32, most as f32);
    [
        if f64::from(low) > least { low.next_down() } else { low },
        if f64::from(high) < most { high.next_up() } else { high },
    ]
}

/// `None` where the bytes are no effect.
pub(super) fn read(reader: &mut Reader<'_>, layout: EffectLayout) -> Option<FittedEffect<f64>> {
    let [tag, length] = reader.take().ok()?;
    let bends = if tag & BENDS_FIELD == 0 { Bends::Reading } else { Bends::Field };
    let form = BuiltIn::<f64>::form(tag & !BENDS_FIELD)?;
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
        let single = match layout.short_errors {
            true => u32::from(u16::from_le_bytes(reader.take().ok()?)) << 16,
            false => reader.single().ok()?.to_bits(),
        };
        *value = f64::from(f32::from_bits(single));
    }
    let mut ranges = [None; MAX_INPUTS];
    if layout.ranges {
        for (range, column) in ranges.iter_mut().zip(effect.columns()) {
            if column.is_some() {
                let [least, most] = [reader.single().ok()?, reader.single().ok()?];
                *range = (!(least.is_nan() && most.is_nan())).then_some([least, most].map(f64::from));
            }
        }
    }
    Some(FittedEffect::new(effect, coefficients, std_errors).over(ranges).bending(bends))
}
