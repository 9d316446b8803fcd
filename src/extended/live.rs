//! The correction that runs on every sample.

use super::{DelayLine, ExtendedCalibration, MAX_EFFECTS, NotCorrected, Prepared, correct};
use crate::calibration::Calibration;
use crate::effect::{BuiltIn, Coefficients, Effect, MAX_INPUTS, TIME};
use crate::math::Real;
use core::fmt;

/// The most delayed columns that a live correction keeps the past of.
pub const MAX_DELAYED: usize = 2;

/// Why a calibration cannot run live.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum LiveError {
    /// Its matrix has no inverse.
    Singular,
    /// More than [`MAX_DELAYED`] columns act late.
    TooManyDelayed,
}

impl fmt::Display for LiveError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Singular => f.write_str("the calibration's matrix is singular"),
            Self::TooManyDelayed => write!(f, "more than {MAX_DELAYED} columns of the calibration act late"),
        }
    }
}

impl core::error::Error for LiveError {}

/// Where the values of one column go: looked up once by name ([`Live::slots`]), then used on every sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Slots(u16);

impl Slots {
    fn one(effect: usize, input: usize) -> Self {
        Self(1 << (effect * MAX_INPUTS + input))
    }

    fn has(self, effect: usize, input: usize) -> bool {
        self.0 & Self::one(effect, input).0 != 0
    }

    /// Whether no effect reads the column.
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Place<T, E> {
    effect: E,
    coefficients: Coefficients<T>,
    inputs: [T; MAX_INPUTS],
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Late<T> {
    slot: Slots,
    now: T,
    line: DelayLine<T>,
}

/// A calibration at work: columns are set when they are measured, samples corrected as they come.
///
/// ```
/// use ironout::calibration::Calibration;
/// use ironout::effect::{BuiltIn, ColumnName, Offset};
/// use ironout::extended::{ExtendedCalibration, FittedEffect, Live};
///
/// let mut calibration = ExtendedCalibration::plain(Calibration::identity(48.0_f32));
/// let heat = Offset::linear(ColumnName::new("temp_c")?, 25.0);
/// let theta = [0.5, 0.0, -0.1, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]; // µT/°C
/// let heat = FittedEffect { effect: BuiltIn::Offset(heat), coefficients: theta, std_errors: [0.0; 9] };
/// calibration.effects.push(heat).map_err(|_| "four effects at most")?;
///
/// let mut live = Live::new(&calibration)?;
/// let temperature = live.slots("temp_c"); // by name once ...
/// live.set_slots(temperature, 35.0); // ... then without
/// assert_eq!(live.apply([25.0, 10.0, 39.0], None)?, [20.0, 10.0, 40.0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Live<T, E = BuiltIn<T>> {
    base: Calibration<T>,
    prepared: Prepared<T>,
    places: [Option<Place<T, E>>; MAX_EFFECTS],
    late: [Option<Late<T>>; MAX_DELAYED],
    time: Slots,
}

impl<T: Real, E: Effect<T> + Clone> Live<T, E> {
    /// Prepares a calibration. No column is known yet.
    ///
    /// # Errors
    /// [`LiveError`].
    pub fn new(calibration: &ExtendedCalibration<T, E>) -> Result<Self, LiveError> {
        let prepared = Prepared::of(calibration).ok_or(LiveError::Singular)?;
        let mut live = Self {
            base: calibration.base,
            prepared,
            places: [const { None }; MAX_EFFECTS],
            late: [None; MAX_DELAYED],
            time: Slots::default(),
        };
        for (place, fitted) in live.places.iter_mut().zip(calibration.effects.iter()) {
            let inputs = [T::of(f64::NAN); MAX_INPUTS];
            *place = Some(Place { effect: fitted.effect.clone(), coefficients: fitted.coefficients, inputs });
        }
        live.time = live.slots(TIME);
        let mut waiting = live.late.iter_mut();
        for (index, fitted) in calibration.effects.iter().enumerate() {
            for (input, column) in fitted.effect.columns().into_iter().enumerate() {
                let Some(delay_s) = column.map(|column| column.delay_s).filter(|delay| *delay > T::zero())
                else {
                    continue;
                };
                let line = DelayLine::new(delay_s);
                *waiting.next().ok_or(LiveError::TooManyDelayed)? =
                    Some(Late { slot: Slots::one(index, input), now: T::of(f64::NAN), line });
            }
        }
        Ok(live)
    }

    /// Where the values of a column go; empty if no effect reads it.
    pub fn slots(&self, column: &str) -> Slots {
        let mut found = Slots::default();
        for (index, place) in self.places.iter().enumerate() {
            let columns = place.as_ref().map(|place| place.effect.columns());
            for (input, read) in columns.into_iter().flatten().enumerate() {
                if read.is_some_and(|read| read.name == column) {
                    found.0 |= Slots::one(index, input).0;
                }
            }
        }
        found
    }

    /// Sets a column by its name. Says whether an effect reads it.
    pub fn set(&mut self, column: &str, value: T) -> bool {
        let slots = self.slots(column);
        self.set_slots(slots, value);
        !slots.is_empty()
    }

    /// Sets a column: it keeps this value until it is set again; NaN makes it unknown. A delayed column takes effect with
    /// [`Live::advance`].
    #[inline]
    pub fn set_slots(&mut self, slots: Slots, value: T) {
        if slots.is_empty() {
            return;
        }
        let mut at_once = slots;
        for late in self.late.iter_mut().flatten().filter(|late| late.slot.0 & slots.0 != 0) {
            late.now = value;
            at_once.0 &= !late.slot.0;
        }
        self.put(at_once, value);
    }

    fn put(&mut self, slots: Slots, value: T) {
        for (index, place) in self.places.iter_mut().enumerate() {
            for (input, slot) in place.iter_mut().flat_map(|place| &mut place.inputs).enumerate() {
                if slots.has(index, input) {
                    *slot = value;
                }
            }
        }
    }

    /// Moves the time on, s: what effects of time and of delayed columns go by. Not needed where there are none
    /// ([`Live::needs_time`]).
    pub fn advance(&mut self, now_s: f64) {
        if !self.time.is_empty() {
            self.put(self.time, T::of(now_s));
        }
        for index in 0..MAX_DELAYED {
            let Some(late) = self.late.get_mut(index).and_then(Option::as_mut) else { break };
            let (slot, value) = (late.slot, late.line.push(now_s, late.now));
            self.put(slot, value.unwrap_or(T::of(f64::NAN)));
        }
    }

    /// Whether [`Live::advance`] matters.
    pub fn needs_time(&self) -> bool {
        !self.time.is_empty() || self.late.iter().any(Option::is_some)
    }

    /// Whether a rate of turn is needed.
    pub fn needs_gyro(&self) -> bool {
        self.prepared.turning
    }

    /// The first column that is needed and not known.
    pub fn waits_for(&self) -> Option<&str> {
        self.places.iter().flatten().find_map(|place| {
            let columns = place.effect.columns().into_iter().zip(place.inputs);
            columns
                .into_iter()
                .find_map(|(column, value)| column.filter(|_| !value.is_finite()).map(|column| column.name))
        })
    }

    /// Offset, matrix and field.
    pub fn base(&self) -> &Calibration<T> {
        &self.base
    }

    /// The corrected field of a measured vector, both µT. `turn_radps` is looked at only where an effect needs it.
    ///
    /// # Errors
    /// [`NotCorrected`] where something that an effect needs is not known.
    #[inline]
    pub fn apply(&self, measured_ut: [T; 3], turn_radps: Option<[T; 3]>) -> Result<[T; 3], NotCorrected> {
        let effects =
            self.places.iter().flatten().map(|place| (&place.effect, &place.coefficients, place.inputs));
        correct(&self.base, &self.prepared, measured_ut, turn_radps, effects)
    }

    /// `‖corrected‖ − F`, µT.
    #[inline]
    pub fn residual_ut(&self, corrected_ut: [T; 3]) -> T {
        self.base.residual_ut(corrected_ut)
    }
}
