//! The correction that runs on every sample.

use super::calibration::ExtendedCalibration;
use super::correction::{NotCorrected, Prepared, correct};
use super::delay::DelayLine;
use super::fitted::{Limits, MAX_EFFECTS, Ranges, held};
use super::low_pass::LowPass;
use super::outside::Outside;
use crate::calibration::Calibration;
use crate::effect::{Bends, BuiltIn, Coefficients, Effect, MAX_INPUTS, Past, TIME};
use crate::math::Real;
use core::fmt;
use heapless::Vec;

/// The most columns that a live correction keeps the past of: each effect of the catalogue may have one, so that whatever
/// a record holds can run.
pub const MAX_DELAYED: usize = MAX_EFFECTS;

/// Why a calibration cannot run live.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum LiveError {
    /// Its matrix has no inverse.
    Singular,
    /// More than [`MAX_DELAYED`] columns act late or through a low-pass.
    TooManyDelayed,
    /// A column acts before it is logged: its value is not known yet when the sample is. Log or feed it earlier.
    AheadOfItsColumn,
}

impl fmt::Display for LiveError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::AheadOfItsColumn => f.write_str(
                "a column of the calibration acts before it is logged, so its value is not known in time",
            ),
            Self::Singular => f.write_str("the calibration's matrix is singular"),
            Self::TooManyDelayed => {
                write!(f, "the calibration has more than {MAX_DELAYED} delayed or low-pass filtered columns")
            }
        }
    }
}

impl core::error::Error for LiveError {}

/// Every input of every effect has a place of its own.
const INPUTS: usize = MAX_EFFECTS * MAX_INPUTS;

/// Where the values of one column go: looked up once by name ([`Live::slots`]), then used on every sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Slots(u32);

impl Slots {
    const fn one(effect: usize, input: usize) -> Self {
        Self(1 << (effect * MAX_INPUTS + input))
    }

    /// All inputs of an effect.
    const fn all_of(effect: usize) -> Self {
        Self(((1 << MAX_INPUTS) - 1) << (effect * MAX_INPUTS))
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
    ranges: Ranges<T>,
    limits: Limits<T>,
    bends: Bends,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Late<T> {
    slot: Slots,
    now: T,
    memory: Memory<T>,
}

// The places of all are reserved anyhow, so that the larger one sets the size.
#[allow(clippy::large_enum_variant)]
#[derive(Clone, Copy, Debug, PartialEq)]
enum Memory<T> {
    Line(DelayLine<T>),
    LowPass(LowPass<T>),
}

impl<T: Real> Memory<T> {
    fn of(past: Past<T>) -> Option<Self> {
        match past {
            Past::Now => None,
            Past::Delayed(delay_s) => (delay_s != T::zero()).then(|| Self::Line(DelayLine::new(delay_s))),
            Past::LowPass(s) => (s > T::zero()).then(|| Self::LowPass(LowPass::new(s))),
        }
    }

    fn push(&mut self, now_s: f64, value: T) -> Option<T> {
        match self {
            Self::Line(line) => line.push(now_s, value),
            Self::LowPass(filter) => filter.push(now_s, value),
        }
    }
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
/// let heat = FittedEffect::new(BuiltIn::Offset(heat), theta, [0.01; 9]).over([Some([10.0, 40.0]), None]); // °C
/// calibration.effects.push(heat).map_err(|_| "four effects at most")?;
///
/// let mut live = Live::new(&calibration)?;
/// let temperature = live.slots("temp_c"); // by name once ...
/// live.set_slots(temperature, 35.0); // ... then without
/// assert_eq!(live.apply([25.0, 10.0, 39.0], None)?, [20.0, 10.0, 40.0]);
/// assert!(live.outside().next().is_none());
/// live.set_slots(temperature, 55.0); // corrected all the same, and known to be 15 °C outside
/// assert_eq!(live.outside().next().map(|outside| outside.distance()), Some(15.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Live<T, E = BuiltIn<T>> {
    base: Calibration<T>,
    prepared: Prepared<T>,
    places: Vec<Place<T, E>, MAX_EFFECTS>,
    inputs: [[T; MAX_INPUTS]; MAX_EFFECTS],
    /// Inputs that some effect reads, …
    needed: Slots,
    /// … and those that are known.
    known: Slots,
    late: Vec<Late<T>, MAX_DELAYED>,
    time: Slots,
    /// The time of the last [`Live::advance`], s; NaN before it.
    now_s: f64,
}

impl<T: Real, E: Effect<T> + Clone> Live<T, E> {
    /// Prepares a calibration. No column is known yet.
    ///
    /// # Errors
    /// [`LiveError`].
    #[inline(never)]
    pub fn new(calibration: &ExtendedCalibration<T, E>) -> Result<Self, LiveError> {
        let mut live = Self {
            base: calibration.base,
            prepared: Prepared::of(&calibration.base, &calibration.effects).ok_or(LiveError::Singular)?,
            places: Vec::new(),
            inputs: [[T::zero(); MAX_INPUTS]; MAX_EFFECTS],
            needed: Slots::default(),
            known: Slots::default(),
            late: Vec::new(),
            time: Slots::default(),
            now_s: f64::NAN,
        };
        for (index, fitted) in calibration.effects.iter().enumerate() {
            // As many places as a calibration has effects.
            let _ = live.places.push(Place {
                effect: fitted.effect.clone(),
                coefficients: fitted.coefficients,
                ranges: fitted.ranges,
                limits: fitted.limits(),
                bends: fitted.bends,
            });
            for (input, column) in fitted.effect.columns().into_iter().enumerate() {
                let Some(column) = column else { continue };
                let slot = Slots::one(index, input);
                live.needed.0 |= slot.0;
                if column.name == TIME {
                    live.time.0 |= slot.0;
                } else if matches!(column.past, Past::Delayed(s) if s < T::zero()) {
                    return Err(LiveError::AheadOfItsColumn);
                } else if let Some(memory) = Memory::of(column.past) {
                    let late = Late { slot, now: T::of(f64::NAN), memory };
                    live.late.push(late).map_err(|_| LiveError::TooManyDelayed)?;
                }
            }
        }
        Ok(live)
    }

    /// Where the values of a column go; empty if no effect reads it.
    pub fn slots(&self, column: &str) -> Slots {
        let mut found = Slots::default();
        for (index, place) in self.places.iter().enumerate() {
            for (input, read) in place.effect.columns().into_iter().enumerate() {
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

    /// Sets a column: it keeps this value until it is set again; NaN makes it unknown. A column whose past acts takes effect with
    /// [`Live::advance`].
    #[inline]
    pub fn set_slots(&mut self, slots: Slots, value: T) {
        let mut at_once = slots;
        for late in self.late.iter_mut().filter(|late| late.slot.0 & slots.0 != 0) {
            late.now = value;
            at_once.0 &= !late.slot.0;
        }
        self.put(at_once, value);
    }

    #[inline]
    fn put(&mut self, slots: Slots, value: T) {
        put(&mut self.known, &mut self.inputs, slots, value);
    }

    /// Moves the time on, s, in double precision also where the correction is in single: what effects of time and of the past of columns go by. Not needed where there are none
    /// ([`Live::needs_time`]).
    #[inline(never)]
    pub fn advance(&mut self, now_s: f64) {
        self.now_s = now_s;
        for (index, place) in self.places.iter().enumerate() {
            // Each effect has its own, reduced before it loses its places in a single.
            let own = Slots(self.time.0 & Slots::all_of(index).0);
            if !own.is_empty() {
                let time_s = T::of(place.effect.time_s(now_s));
                put(&mut self.known, &mut self.inputs, own, time_s);
            }
        }
        for index in 0..self.late.len() {
            let Some(late) = self.late.get_mut(index) else { break };
            let (slot, value) = (late.slot, late.memory.push(now_s, late.now));
            self.put(slot, value.unwrap_or(T::of(f64::NAN)));
        }
    }

    /// Whether [`Live::advance`] matters.
    pub fn needs_time(&self) -> bool {
        !(self.time.is_empty() && self.late.is_empty())
    }

    /// Whether a rate of turn is needed.
    pub fn needs_gyro(&self) -> bool {
        self.prepared.turning
    }

    /// The first column that is needed and not known.
    pub fn waits_for(&self) -> Option<&str> {
        let missing = self.missing()?;
        let columns = self.places.get(missing / MAX_INPUTS)?.effect.columns();
        columns.into_iter().nth(missing % MAX_INPUTS).flatten().map(|column| column.name)
    }

    /// The columns that are known and outside the range that their effect was fitted over. The correction goes on. It costs nothing until it is asked. Of an effect whose range is not known, nothing is told.
    pub fn outside(&self) -> impl Iterator<Item = Outside<'_, T>> {
        self.places.iter().zip(&self.inputs).enumerate().flat_map(move |(index, (place, inputs))| {
            let columns = place.effect.columns().into_iter().zip(place.ranges).zip(inputs).enumerate();
            columns.filter_map(move |(input, ((column, range), value))| {
                let slot = Slots::one(index, input).0;
                if self.known.0 & slot == 0 {
                    return None;
                }
                let is_advanced = || *value == T::of(place.effect.time_s(self.now_s));
                // An effect that repeats was given a time less whole periods.
                let value = if self.time.0 & slot != 0 && is_advanced() { T::of(self.now_s) } else { *value };
                Outside::of((index, input), column?.name, value, range?)
            })
        })
    }

    /// The first input that is needed and not known.
    fn missing(&self) -> Option<usize> {
        let missing = self.needed.0 & !self.known.0;
        (missing != 0).then(|| missing.trailing_zeros() as usize)
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
        if let Some(missing) = self.missing() {
            return Err(NotCorrected::Column(missing / MAX_INPUTS));
        }
        if self.prepared.turning && turn_radps.is_none() {
            let turning = self.places.iter().position(|place| place.effect.needs_gyro());
            return Err(NotCorrected::RateOfTurn(turning.unwrap_or_default()));
        }
        let effects = self.places.iter().zip(&self.inputs);
        let effects = effects.map(|(place, inputs)| {
            (&place.effect, &place.coefficients, held(&place.limits, *inputs), place.bends)
        });
        correct(&self.base, &self.prepared, measured_ut, turn_radps, effects)
    }

    /// The measured vector without the effects, both µT: what [`Live::apply`] corrects to, as the base alone would measure it.
    ///
    /// # Errors
    /// Those of [`Live::apply`].
    #[inline]
    pub fn cleaned(&self, measured_ut: [T; 3], turn_radps: Option<[T; 3]>) -> Result<[T; 3], NotCorrected> {
        if self.places.is_empty() {
            return Ok(measured_ut);
        }
        let corrected = self.apply(measured_ut, turn_radps)?;
        let [x, y, z] = self.base.offset_ut;
        let [a, b, c] = self.prepared.undone(corrected);
        Ok([a + x, b + y, c + z])
    }

    /// `‖corrected‖ − F`, µT.
    #[inline]
    pub fn residual_ut(&self, corrected_ut: [T; 3]) -> T {
        self.base.residual_ut(corrected_ut)
    }
}

/// Sets inputs to a value, which is known from now on if it is finite.
#[inline]
fn put<T: Real>(
    known: &mut Slots,
    inputs: &mut [[T; MAX_INPUTS]; MAX_EFFECTS],
    Slots(mut slots): Slots,
    value: T,
) {
    if value.is_finite() {
        known.0 |= slots;
    } else {
        known.0 &= !slots;
    }
    let inputs = inputs.as_flattened_mut();
    while slots != 0 {
        if let Some(input) = inputs.get_mut(slots.trailing_zeros() as usize % INPUTS) {
            *input = value;
        }
        slots &= slots - 1;
    }
}
