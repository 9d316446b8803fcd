//! The answers of `check`.

/// The answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Word {
    Good,
    Field,
    Moved,
    Other,
    Worse,
    Heading,
    Unknown,
}

impl Word {
    pub(super) fn name(self) -> &'static str {
        match self {
            Word::Good => "good",
            Word::Field => "field",
            Word::Moved => "moved",
            Word::Other => "other",
            Word::Worse => "worse",
            Word::Heading => "heading",
            Word::Unknown => "unknown",
        }
    }

    pub(super) fn explanation(self) -> &'static str {
        match self {
            Word::Good => "the calibration still holds, as far as the directions seen tell",
            Word::Field => {
                "the calibration holds; the field's magnitude is another than at the calibration (another place, or iron \
                 around): directions are right, magnitudes are off by that factor"
            }
            Word::Moved => {
                "the offset has moved (a magnet, a new part, a shock): calibrate again with ironout fit"
            }
            Word::Other => {
                "this log is that of another sensor, another mounting or another scale: by itself it gives a good calibration, and its matrix is not \
                 this one. Fix: use the calibration of this sensor, or calibrate with ironout fit"
            }
            Word::Worse => {
                "the errors grew, and neither a moved offset nor another field explains it: calibrate again, and see \
                 what is missing with ironout diagnose"
            }
            Word::Heading => {
                "the magnitude fits, but the heading does not: axes, a mirrored driver, a sensor that lags, or iron that turns with the board; see \
                 ironout diagnose"
            }
            Word::Unknown => {
                "this log does not determine a change. Fix: turn the board through more directions"
            }
        }
    }
}
