//! Kinds of logs.

/// Kind of log: what it hides, and how it was recorded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Kind {
    /// One effect of the catalogue, 1.5 to 20 times the noise.
    One,
    /// Two effects of different families.
    Two,
    /// Three effects of different families.
    Three,
    /// One effect, 20 to 60 times the noise.
    Strong,
    /// No effect, white noise.
    NothingWhite,
    /// No effect, noise of one of eight colours.
    NothingColoured,
    /// One effect whose column is not in the log.
    Deleted,
    /// One effect whose column has a twin with a correlation of 0.97 to 0.995.
    Alike,
    /// One effect whose column has missing cells and a lower rate.
    Gaps,
    /// One offset proportional to a column, 3 to 10 times the noise, many orientations.
    PlainOffset,
    /// One gain proportional to a column, 3 to 10 times the noise, many orientations.
    Gain,
    /// One lag, 3 to 10 times the noise, many orientations.
    Lag,
    /// One nonlinearity or cross-axis sensitivity, 3 to 10 times the noise, many orientations.
    Shape,
    /// No effect, 1/f noise, many orientations.
    Coloured,
    /// No effect, white noise, many orientations.
    White,
    /// One cause outside of the catalogue.
    Beyond,
    /// Drone flight; half of them hide an effect of the current.
    Flight,
    /// Level car with turns.
    Car,
    /// Rocking boat that turns.
    Boat,
    /// Hasty calibration by hand of 15 s.
    Quick,
}

/// Names in the order of the kinds.
const NAMES: [&str; 20] = [
    "one",
    "two",
    "three",
    "strong",
    "nothing-white",
    "nothing-coloured",
    "deleted",
    "alike",
    "gaps",
    "plain-offset",
    "gain",
    "lag",
    "shape",
    "coloured",
    "white",
    "beyond",
    "flight",
    "car",
    "boat",
    "quick",
];

impl Kind {
    /// All kinds.
    #[rustfmt::skip]
    pub const ALL: [Kind; 20] = {
        use Kind::*;
        [One, Two, Three, Strong, NothingWhite, NothingColoured, Deleted, Alike, Gaps, PlainOffset, Gain,
         Lag, Shape, Coloured, White, Beyond, Flight, Car, Boat, Quick]
    };

    /// Name on the command line.
    pub fn name(self) -> &'static str {
        NAMES[self as usize]
    }

    /// Vehicle or hasty hand: few orientations, and an autopilot's quaternion in the log.
    pub(crate) fn is_confined(self) -> bool {
        matches!(self, Kind::Flight | Kind::Car | Kind::Boat | Kind::Quick)
    }

    /// Log for the check of predicted errors: many orientations, moderate strengths.
    pub(crate) fn is_well_covered(self) -> bool {
        use Kind::{Coloured, Gain, Lag, PlainOffset, Shape, White};
        matches!(self, PlainOffset | Gain | Lag | Shape | Coloured | White)
    }

    /// Limits of the strength, as multiples of the noise.
    pub(crate) fn strengths(self) -> [f64; 2] {
        match self {
            Kind::Strong => [20.0, 60.0],
            kind if kind.is_well_covered() => [3.0, 10.0],
            _ => [1.5, 20.0],
        }
    }
}
