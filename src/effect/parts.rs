//! An effect taken apart: the plain data that ids, calibration files, records and searches have in common.

use super::column_name::ColumnName;
use super::quantities::Past;

/// What of a shape is searched for, since the fit is not linear in it. How a search goes about it depends on what a shape
/// of that kind looks like, so this is fixed too.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Searched {
    /// The time from which on an offset of three coefficients is there, s.
    At,
    /// The frequency of three sines and three cosines, in this order, Hz.
    Frequency,
    /// How late a column acts that adds a vector of three coefficients, s; negative where it acts before it is logged.
    Delay,
    /// The time constant of the low-pass through which a column acts that adds a vector of three coefficients, s.
    TimeConstant,
}

impl Searched {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::At, Self::Frequency, Self::Delay, Self::TimeConstant];

    /// Its key in calibration files and on the console.
    pub const fn name(self) -> &'static str {
        match self {
            Self::At => "at_s",
            Self::Frequency => "frequency_hz",
            Self::Delay => "delay_s",
            Self::TimeConstant => "time_constant_s",
        }
    }

    /// Whether a value can be meant: finite, and not negative for what cannot be.
    pub fn is_sound(self, value: f64) -> bool {
        value.is_finite() && (value >= 0.0 || matches!(self, Self::At | Self::Delay))
    }
}

/// What the effect's reference, where the effect vanishes, is a value of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Zero {
    /// The effect has none.
    None,
    /// The column.
    Column,
    /// The column's square.
    Square,
    /// The time, s.
    Time,
}

/// One form in which the effects of a family come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Form {
    /// Its number in the board's records, which is never given to another one since records outlive programs; 0 for a form
    /// that no record holds.
    pub tag: u8,
    /// Whether it follows a column that its id names: `kind:COLUMN`.
    pub column: bool,
    /// What its id ends in: `^2`, `@delay`, or nothing.
    pub suffix: &'static str,
    /// k.
    pub coefficients: usize,
    /// What its reference is a value of.
    pub zero: Zero,
    /// What is searched for.
    pub searched: Option<Searched>,
    /// Whether every magnitude hides it, so that only the dip shows it.
    pub dip_only: bool,
    /// Whether a search offers it. One that does not is read and applied all the same.
    pub offered: bool,
}

impl Form {
    /// Three coefficients, and nothing else: what the others differ from.
    pub const PLAIN: Self = Form {
        tag: 0,
        column: false,
        suffix: "",
        coefficients: 3,
        zero: Zero::None,
        searched: None,
        dip_only: false,
        offered: true,
    };

    /// Whether a log may hold several of it, each at a place of its own: steps, and tones.
    pub const fn is_repeated(&self) -> bool {
        !self.column && matches!(self.searched, Some(Searched::At | Searched::Frequency))
    }

    /// Whether the square of the column acts.
    pub fn is_squared(&self) -> bool {
        self.zero == Zero::Square
    }

    /// Whether a past of the column acts: late, or through a low-pass.
    pub fn is_late(&self) -> bool {
        matches!(self.searched, Some(Searched::Delay | Searched::TimeConstant))
    }
}

/// The parts of one effect: its form, and what that form leaves open.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parts<C> {
    /// The form.
    pub form: &'static Form,
    /// The column that the id names; empty where it names none.
    pub column: C,
    /// Where the effect vanishes; 0 where it has no such place.
    pub reference: f64,
    /// What was searched for; 0 where nothing is.
    pub parameter: f64,
}

impl<C: Default> Parts<C> {
    /// Of a form without a column, everything else 0.
    pub fn of(form: &'static Form) -> Self {
        Parts { form, column: C::default(), reference: 0.0, parameter: 0.0 }
    }
}

impl<C: AsRef<str>> Parts<C> {
    /// The same with the column's name borrowed.
    pub fn borrowed(&self) -> Parts<&str> {
        let Parts { form, column, reference, parameter } = self;
        Parts { form, column: column.as_ref(), reference: *reference, parameter: *parameter }
    }
}

impl<C> Parts<C> {
    /// The reference, where there is one.
    pub fn reference(&self) -> Option<f64> {
        (self.form.zero != Zero::None).then_some(self.reference)
    }

    /// What was searched for, where something is.
    pub fn parameter(&self) -> Option<(Searched, f64)> {
        self.form.searched.map(|searched| (searched, self.parameter))
    }

    /// Which past of the column acts.
    pub fn past(&self) -> Past<f64> {
        match self.form.searched {
            Some(Searched::Delay) => Past::Delayed(self.parameter),
            Some(Searched::TimeConstant) => Past::LowPass(self.parameter),
            _ => Past::Now,
        }
    }

    /// When the effect has its own zero of time, s; `None` for an effect that does not read the time.
    pub fn time_reference_s(&self) -> Option<f64> {
        match (self.form.zero, self.form.searched) {
            (Zero::Time, _) => Some(self.reference),
            (_, Some(Searched::At)) => Some(self.parameter),
            _ => None,
        }
    }

    /// The same effect on a clock that shows zero when the other one shows `origin_s`.
    pub fn on_clock_from(self, origin_s: f64) -> Self {
        let moved = |is_time: bool, value: f64| if is_time { value - origin_s } else { value };
        Parts {
            reference: moved(self.form.zero == Zero::Time, self.reference),
            parameter: moved(self.form.searched == Some(Searched::At), self.parameter),
            ..self
        }
    }

    /// Whether every number in it is finite, and no time constant or frequency negative.
    pub fn is_sound(&self) -> bool {
        self.reference().is_none_or(f64::is_finite)
            && self.parameter().is_none_or(|(searched, value)| searched.is_sound(value))
    }
}

/// An effect that a calibration carries can be taken apart and put together again.
pub trait InParts: Sized {
    /// Its parts.
    fn parts(&self) -> Parts<ColumnName>;
    /// The same effect with other numbers: reference and parameter are taken from `parts`.
    fn with_numbers(&self, parts: &Parts<ColumnName>) -> Self;
}
