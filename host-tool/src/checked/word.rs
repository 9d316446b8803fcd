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
    pub(crate) fn name(self) -> &'static str {
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

    pub(crate) fn explanation(self) -> &'static str {
        match self {
            Word::Good => "the calibration is still good, for the directions covered",
            Word::Field => {
                "the calibration is still good. The field strength differs from that of the calibration (another place, or iron nearby): directions are correct, magnitudes are wrong by that factor"
            }
            Word::Moved => {
                "the offset has changed (a magnet, a new part, a shock). Calibrate again with ironout fit"
            }
            Word::Other => {
                "this log comes from another sensor, another mounting or another scale: by itself it gives a good \
                 calibration, but with another matrix. Fix: use the calibration of this sensor, or calibrate with ironout \
                 fit"
            }
            Word::Worse => {
                "the errors have grown, and neither an offset change nor another field strength explains that. Calibrate \
                 again, and run ironout diagnose to find the cause"
            }
            Word::Heading => {
                "the magnitude is correct, but the heading is not. Possible causes: wrong axes, a mirrored axis, a delayed \
                 sensor, or iron that rotates with the vehicle. Run ironout diagnose"
            }
            Word::Unknown => {
                "this log cannot show whether the calibration has changed. Fix: rotate the sensor through more directions"
            }
        }
    }
}
