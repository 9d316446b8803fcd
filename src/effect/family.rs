//! Everything of an effect but its numbers: what programs around the fit ask.

use super::code::RustCode;
use super::columns::Usual;
use super::definition::Effect;
use super::parts::{Form, Parts, Searched};
use super::quantities::{Column, MAX_INPUTS, TIME};
use core::fmt;

/// What an effect goes by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Follows {
    /// A column of the log.
    Column,
    /// The time, with no column behind it.
    Time,
    /// The time, periodically.
    Tone,
    /// The attitude alone: it turns with the board.
    Attitude,
    /// How fast the board turns.
    Turning,
}

/// What `Φ` is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Acts {
    /// A vector of its own, added whatever the field: a resting board shows it too.
    Added,
    /// The measured vector.
    Measured,
    /// The field itself, the measured vector about its centre.
    Field,
    /// The rate at which the measured vector turns.
    Turning,
}

/// What a sensor bends in an effect whose shape is made of the measured vector ([`Acts::Measured`]): two forms of one effect. They differ by
/// the square of the disturbance over the field.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Bends {
    /// Its reading, as an amplifier behind a feedback does: the shape is that of what the sensor gives out, `m = x + Φ(m) θ`.
    #[default]
    Reading,
    /// The field at the sensor, as a core does that saturates: the shape is that of the undisturbed reading, `m = x + Φ(x) θ`.
    Field,
}

/// What a log must have besides the effect's column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Need {
    /// The time.
    Time,
    /// The rate of turn.
    Gyro,
}

impl Need {
    /// The column, or the first of three.
    pub const fn column(self) -> &'static str {
        match self {
            Self::Time => TIME,
            Self::Gyro => "gx_radps",
        }
    }

    /// What a log without it is told.
    pub const fn missing(self) -> &'static str {
        match self {
            Self::Time => "no time column: log t_s",
            Self::Gyro => "no rate of turn: log gx_radps,gy_radps,gz_radps",
        }
    }

    /// What somebody is told who asks for the effect with a log without it.
    pub const fn refusal(self) -> &'static str {
        match self {
            Self::Time => "it needs the time, and the log has no time column",
            Self::Gyro => "it needs the rate of turn, which is not in the log",
        }
    }
}

/// What an effect amounts to over a log.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Amount {
    /// That is not told.
    Untold,
    /// Its coefficients times what its column goes through, µT.
    Field,
    /// The largest coefficient times what its column goes through, as a share.
    Share,
    /// Its coefficients times the length of the log, µT.
    OverTime,
    /// Its coefficients, µT.
    Itself,
}

/// Some coefficients that are shown together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Group {
    /// A row of them.
    Row {
        /// What they are; empty under a row that says it.
        label: &'static str,
        /// A name for each, empty where it needs none.
        names: &'static [&'static str],
        /// The first of them.
        from: usize,
        /// Their unit.
        unit: &'static str,
    },
    /// The amplitudes of sines and cosines in x, y and z.
    Amplitude {
        /// What they are.
        label: &'static str,
        /// The first of three coefficients of sines.
        sines: usize,
        /// The first of three coefficients of cosines.
        cosines: usize,
        /// Their unit.
        unit: &'static str,
    },
    /// The mean of some of them.
    Mean {
        /// What it is.
        label: &'static str,
        /// Which.
        of: &'static [usize],
        /// Into the unit.
        factor: f64,
        /// The unit, and what is to be said of it.
        unit: &'static str,
    },
}

/// The names of the axes, for [`Group::Row`].
pub(super) const AXES: &[&str] = &["x", "y", "z"];

/// An effect as seen by another one that is to be told from it: by what it does, not by what it is called.
#[derive(Clone, Copy, Debug)]
pub struct Subject<'a> {
    /// What it goes by.
    pub follows: Follows,
    /// Its column; empty where it has none.
    pub column: &'a str,
    /// Its form.
    pub form: &'static Form,
}

impl Subject<'_> {
    /// Whether it happens at one moment.
    pub fn is_sudden(&self) -> bool {
        self.form.searched == Some(Searched::At)
    }
}

/// A sentence about one or two columns, shown by its `Display`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Advice<'a> {
    /// The sentence, with `{0}` and `{1}` where the columns stand.
    pub text: &'static str,
    /// The columns.
    pub names: [&'a str; 2],
}

impl fmt::Display for Advice<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [first, second] = self.names;
        // By a character: a search for words is four kilobytes on a board.
        for part in self.text.split_inclusive('}') {
            let named = [("{0}", first), ("{1}", second)];
            match named.iter().find_map(|(place, name)| Some((part.strip_suffix(place)?, name))) {
                Some((before, name)) => {
                    f.write_str(before)?;
                    f.write_str(name)?;
                }
                None => f.write_str(part)?,
            }
        }
        Ok(())
    }
}

/// A kind of effect, and all that a program asks about it besides its numbers.
///
/// The methods without a body are what every family has to say; the others have the answer of an effect that adds a
/// vector of its own.
pub trait Family: Sync {
    /// The id's first word, as in `offset:temp_c`: lower case, no blanks, no colon.
    fn kind(&self) -> &'static str;
    /// The forms it comes in, the one that is offered first in front; all with a column, or none.
    fn forms(&self) -> &'static [&'static Form];
    /// Builds the effect of these parts and hands it on. The parts are of one of [`Family::forms`].
    fn with(&self, parts: &Parts<&str>, use_it: &mut dyn FnMut(&dyn Effect<f64>));
    /// What it goes by.
    fn follows(&self) -> Follows;

    /// What `Φ` is made of.
    fn acts(&self) -> Acts {
        Acts::Added
    }
    /// Whether its disturbance is in proportion to its column's distance from the reference.
    fn is_proportional(&self, parts: &Parts<&str>) -> bool {
        let _ = parts;
        false
    }
    /// The columns of [`Effect::columns`], with names that live as long as the parts.
    fn columns<'p>(&self, parts: &Parts<&'p str>) -> [Option<Column<'p, f64>>; MAX_INPUTS] {
        let column = match self.follows() {
            Follows::Column => Some(Column { name: parts.column, past: parts.past() }),
            Follows::Time | Follows::Tone => Some(Column::now(TIME)),
            Follows::Attitude | Follows::Turning => None,
        };
        [column, None]
    }
    /// Whether it goes by the time of the log it was found in, so that it cannot correct another one.
    fn is_bound_to_its_log(&self) -> bool {
        matches!(self.follows(), Follows::Time | Follows::Tone)
    }
    /// Whether a search offers it for a column of this name: some causes do not know what a column measures.
    fn suits(&self, column: &str) -> bool {
        let _ = column;
        true
    }
    /// What a log must have besides the column.
    fn need(&self, form: &Form) -> Option<Need> {
        match self.follows() {
            Follows::Time | Follows::Tone => Some(Need::Time),
            Follows::Turning => Some(Need::Gyro),
            Follows::Column | Follows::Attitude => form.searched.map(|_| Need::Time),
        }
    }
    /// Why a form that only the dip shows cannot be tested where no accelerometer tells the direction down.
    fn without_down(&self) -> &'static str {
        "it needs an accelerometer: log ax_mps2,ay_mps2,az_mps2"
    }
    /// Columns whose absence from a log is worth a word.
    fn usual_columns(&self) -> &'static [Usual] {
        &[]
    }
    /// The coefficients whose mean is a pure delay of the sensor, s: the magnitude hides that share of the effect.
    fn delay_coefficients(&self, form: &Form) -> &'static [usize] {
        let _ = form;
        &[]
    }

    /// What the coefficients are called, where "coefficients" is not enough.
    fn groups(&self, form: &Form) -> &'static [Group] {
        let _ = form;
        &[]
    }
    /// Whether all coefficients are shown in the same power of ten.
    fn one_scale(&self) -> bool {
        false
    }
    /// What it amounts to.
    fn amount(&self) -> Amount {
        Amount::Untold
    }
    /// A word for a single one, as in "a second tone beside the tone".
    fn word(&self) -> &'static str {
        self.kind()
    }
    /// The recording that tells it from another effect; `None` where the other one has to tell.
    fn apart<'a>(&self, own: &Subject<'a>, other: &Subject<'a>) -> Option<Advice<'a>> {
        let _ = (own, other);
        None
    }

    /// Writes the effect as an expression of Rust that is constant.
    ///
    /// # Errors
    /// Those of `out`.
    fn rust(&self, parts: &Parts<&str>, code: &RustCode<'_>, out: &mut dyn fmt::Write) -> fmt::Result;
    /// The names that [`Family::rust`] uses, from [`Family::rust_module`].
    fn rust_names(&self, parts: &Parts<&str>) -> &'static [&'static str];
    /// The module of these names.
    fn rust_module(&self) -> &'static str {
        "ironout::effect"
    }
    /// Writes the statements of C99 that add the disturbance to `sum[3]`. They may read `theta[k]`, `measured_ut[3]`,
    /// `left[3]` (the vector about its centre, without the disturbance), `turning[3]` where the effect needs the gyro, the
    /// effect's columns under the names `inputs` (the time as a double), and use `i`; all but the time are `ironout_real`.
    ///
    /// # Errors
    /// Those of `out`.
    fn c(&self, parts: &Parts<&str>, inputs: [&str; MAX_INPUTS], out: &mut dyn fmt::Write) -> fmt::Result;
    /// Whether [`Family::c`] needs `math.h`.
    fn c_needs_math(&self) -> bool {
        false
    }
}
