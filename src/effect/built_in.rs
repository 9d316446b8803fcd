//! Every effect of the catalogue in one type that owns what it needs.

use super::{
    AmbientField, Coefficients, Column, ColumnName, CrossAxis, Drift, Eddy, Effect, Gain, Lag, MAX_INPUTS,
    Nonlinearity, Offset, Periodic, Quantities, Shape, Step,
};
use crate::math::Real;
use core::fmt;

/// An effect of the catalogue, with the name of its column in fixed memory: what a calibration carries and stores.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(missing_docs)] // each variant is the effect of that name
pub enum BuiltIn<T> {
    Offset(Offset<ColumnName, T>),
    Gain(Gain<ColumnName, T>),
    Field(AmbientField<ColumnName, T>),
    Drift(Drift<T>),
    Step(Step<T>),
    Lag(Lag),
    Eddy(Eddy),
    Nonlinearity(Nonlinearity),
    CrossAxis(CrossAxis),
    /// Its sine and cosine in double precision cost thousands of instructions where there is no double-precision FPU.
    Periodic(Periodic),
}

/// Does the same with the effect of every variant.
macro_rules! each {
    ($built_in:expr, $effect:ident => $call:expr) => {
        match $built_in {
            BuiltIn::Offset($effect) => $call,
            BuiltIn::Gain($effect) => $call,
            BuiltIn::Field($effect) => $call,
            BuiltIn::Drift($effect) => $call,
            BuiltIn::Step($effect) => $call,
            BuiltIn::Lag($effect) => $call,
            BuiltIn::Eddy($effect) => $call,
            BuiltIn::Nonlinearity($effect) => $call,
            BuiltIn::CrossAxis($effect) => $call,
            BuiltIn::Periodic($effect) => $call,
        }
    };
}

impl<T: Real> BuiltIn<T> {
    /// The same effect in another precision.
    pub fn cast<U: Real>(&self) -> BuiltIn<U> {
        let to = |value: T| U::of(value.as_f64());
        match *self {
            Self::Offset(Offset { column, reference, power, delay_s }) => {
                BuiltIn::Offset(Offset { column, reference: to(reference), power, delay_s: delay_s.map(to) })
            }
            Self::Gain(Gain { column, reference }) => {
                BuiltIn::Gain(Gain { column, reference: to(reference) })
            }
            Self::Field(AmbientField { column, reference }) => {
                BuiltIn::Field(AmbientField { column, reference: to(reference) })
            }
            Self::Drift(Drift { reference_s }) => BuiltIn::Drift(Drift { reference_s: to(reference_s) }),
            Self::Step(Step { at_s }) => BuiltIn::Step(Step { at_s: to(at_s) }),
            Self::Lag(lag) => BuiltIn::Lag(lag),
            Self::Eddy(eddy) => BuiltIn::Eddy(eddy),
            Self::Nonlinearity(nonlinearity) => BuiltIn::Nonlinearity(nonlinearity),
            Self::CrossAxis(cross_axis) => BuiltIn::CrossAxis(cross_axis),
            Self::Periodic(periodic) => BuiltIn::Periodic(periodic),
        }
    }

    /// When the effect has its own zero of time, s; `None` for an effect that does not read the time.
    pub fn time_reference_s(&self) -> Option<f64> {
        match self {
            Self::Drift(Drift { reference_s }) => Some(reference_s.as_f64()),
            Self::Step(Step { at_s }) => Some(at_s.as_f64()),
            Self::Periodic(Periodic { reference_s, .. }) => Some(*reference_s),
            _ => None,
        }
    }

    /// The same effect on a clock that shows zero when the other one shows `origin_s`.
    pub fn on_clock_from(&self, origin_s: f64) -> Self {
        let moved = |time: T| T::of(time.as_f64() - origin_s);
        match *self {
            Self::Drift(Drift { reference_s }) => Self::Drift(Drift { reference_s: moved(reference_s) }),
            Self::Step(Step { at_s }) => Self::Step(Step { at_s: moved(at_s) }),
            Self::Periodic(Periodic { frequency_hz, reference_s }) => {
                Self::Periodic(Periodic { frequency_hz, reference_s: reference_s - origin_s })
            }
            other => other,
        }
    }

    /// Whether every number in it is finite, and no delay or frequency negative.
    pub fn is_sound(&self) -> bool {
        let zero = T::zero();
        match self {
            Self::Offset(Offset { reference, delay_s, .. }) => {
                reference.is_finite() && delay_s.is_none_or(|delay| delay.is_finite() && delay >= zero)
            }
            Self::Gain(Gain { reference, .. }) | Self::Field(AmbientField { reference, .. }) => {
                reference.is_finite()
            }
            Self::Drift(Drift { reference_s }) => reference_s.is_finite(),
            Self::Step(Step { at_s }) => at_s.is_finite(),
            Self::Periodic(Periodic { frequency_hz, reference_s }) => {
                frequency_hz.is_finite() && *frequency_hz >= 0.0 && reference_s.is_finite()
            }
            Self::Lag(_) | Self::Eddy(_) | Self::Nonlinearity(_) | Self::CrossAxis(_) => true,
        }
    }
}

impl<T: Real> Effect<T> for BuiltIn<T> {
    fn id(&self, out: &mut dyn fmt::Write) -> fmt::Result {
        each!(self, effect => Effect::<T>::id(effect, out))
    }

    fn name(&self) -> &str {
        each!(self, effect => Effect::<T>::name(effect))
    }

    fn explanation(&self) -> &str {
        each!(self, effect => Effect::<T>::explanation(effect))
    }

    fn columns(&self) -> [Option<Column<'_, T>>; MAX_INPUTS] {
        each!(self, effect => effect.columns())
    }

    fn needs_gyro(&self) -> bool {
        each!(self, effect => Effect::<T>::needs_gyro(effect))
    }

    fn coefficients(&self) -> usize {
        each!(self, effect => Effect::<T>::coefficients(effect))
    }

    fn unit(&self) -> &str {
        each!(self, effect => Effect::<T>::unit(effect))
    }

    fn shape(&self, at: &Quantities<T>, shape: &mut Shape<T>) {
        each!(self, effect => effect.shape(at, shape));
    }

    fn reads_centre(&self) -> bool {
        each!(self, effect => Effect::<T>::reads_centre(effect))
    }

    #[inline]
    fn disturbance(&self, at: &Quantities<T>, coefficients: &Coefficients<T>) -> [T; 3] {
        each!(self, effect => effect.disturbance(at, coefficients))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effect::{MAX_COEFFICIENTS, Power, no_shape};

    fn all() -> [BuiltIn<f64>; 11] {
        let column = ColumnName::new("temp_c").unwrap();
        [
            BuiltIn::Offset(Offset::linear(column, 24.5)),
            BuiltIn::Offset(Offset { column, reference: 9.0, power: Power::Squared, delay_s: Some(0.25) }),
            BuiltIn::Gain(Gain { column, reference: 20.0 }),
            BuiltIn::Field(AmbientField { column, reference: 21.0 }),
            BuiltIn::Drift(Drift { reference_s: 40.0 }),
            BuiltIn::Step(Step { at_s: 3.0 }),
            BuiltIn::Lag(Lag),
            BuiltIn::Eddy(Eddy),
            BuiltIn::Nonlinearity(Nonlinearity),
            BuiltIn::CrossAxis(CrossAxis),
            BuiltIn::Periodic(Periodic { frequency_hz: 7.0, reference_s: 1.0 }),
        ]
    }

    #[test]
    fn the_cheap_way_is_the_shape_times_the_coefficients() {
        let at = Quantities {
            measured_ut: [20.0, -35.0, 12.5],
            centred_ut: [11.0, -30.0, 7.0],
            turning_ut_per_s: [-60.0, 14.0, 33.0],
            inputs: [31.0, 0.0],
        };
        let coefficients: Coefficients<f64> =
            core::array::from_fn(|i| if i < MAX_COEFFICIENTS { 0.3 - 0.1 * i as f64 } else { 0.0 });
        for effect in all() {
            let mut shape = no_shape();
            effect.shape(&at, &mut shape);
            let cheap = effect.disturbance(&at, &coefficients);
            let k = effect.coefficients();
            for axis in 0..3 {
                let whole: f64 = (0..k).map(|i| shape[i][axis] * coefficients[i]).sum();
                assert!(
                    (cheap[axis] - whole).abs() <= 1e-12 * whole.abs().max(1.0),
                    "{effect:?} axis {axis}"
                );
            }
            assert!(effect.is_sound() && effect.cast::<f32>().is_sound());
        }
    }

    #[test]
    fn an_effect_that_reads_the_centre_says_so() {
        let near = Quantities { inputs: [31.0, 0.0], ..Quantities::of_vector([20.0, -35.0, 12.5]) };
        let far = Quantities { centred_ut: [1.0, 2.0, 3.0], turning_ut_per_s: [4.0, 5.0, 6.0], ..near };
        for effect in all() {
            let differ = effect.disturbance(&near, &[1.0; MAX_COEFFICIENTS])
                != effect.disturbance(&far, &[1.0; MAX_COEFFICIENTS]);
            assert_eq!(differ, effect.reads_centre(), "{effect:?}");
        }
    }
}
