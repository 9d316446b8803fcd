//! Why a fit gave no answer, and what to do about it.

use crate::number::Num;
use core::fmt;

/// A refusal of a fit. Its `Display` names the reason and the remedy.
// A word for the tag: what follows it is then copied by words, not by bytes.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum FitError {
    /// Fewer samples than the fit can be judged by.
    TooFewSamples {
        /// Samples there were.
        samples: u64,
    },
    /// An axis never moved.
    StuckAxis {
        /// 0, 1, 2 for x, y, z.
        axis: u8,
    },
    /// An axis repeats another (or its negative) exactly.
    CopiedAxis {
        /// The axis that is a copy: 0, 1, 2 for x, y, z.
        axis: u8,
        /// The axis it is a copy of.
        of: u8,
    },
    /// All samples lie near one plane: the third direction of the ellipsoid is unknown.
    Planar {
        /// Thickness over width of the cloud of samples.
        thickness: f64,
    },
    /// The best quadric is not an ellipsoid: too little attitude for the noise, or a disturbance in the data.
    NotAnEllipsoid,
    /// The ellipsoid passes (nearly) through the sensor's zero, where the paper's constant reading is singular.
    ThroughOrigin {
        /// `|F² − bᵀQb| / F²`.
        distance: f64,
    },
    /// The offset is larger than any board's.
    OffsetTooLarge {
        /// Offset over field magnitude.
        fields: f64,
    },
    /// The axes of the ellipsoid differ more than any magnetometer's.
    AxisRatio {
        /// Longest over shortest semi-axis.
        ratio: f64,
    },
    /// A sample, scale or option was NaN, infinite or out of range.
    NotFinite,
}

impl FitError {
    /// A short word for programs: `too-few-samples`, `planar` …
    pub const fn code(&self) -> &'static str {
        match self {
            Self::TooFewSamples { .. } => "too-few-samples",
            Self::StuckAxis { .. } => "stuck-axis",
            Self::CopiedAxis { .. } => "copied-axis",
            Self::Planar { .. } => "planar",
            Self::NotAnEllipsoid => "no-ellipsoid",
            Self::ThroughOrigin { .. } => "through-origin",
            Self::OffsetTooLarge { .. } => "offset-too-large",
            Self::AxisRatio { .. } => "axis-ratio",
            Self::NotFinite => "not-finite",
        }
    }
}

/// The letter of an axis number.
pub const fn axis_letter(axis: u8) -> char {
    match axis {
        0 => 'x',
        1 => 'y',
        _ => 'z',
    }
}

impl fmt::Display for FitError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooFewSamples { samples } => {
                write!(f, "the sensor hardly moved ({samples} samples of motion): keep rotating it")
            }
            Self::StuckAxis { axis } => write!(
                f,
                "the {} axis never changed: rotate the sensor in all directions. If it was rotated, check the sensor",
                axis_letter(*axis)
            ),
            Self::CopiedAxis { axis, of } => write!(
                f,
                "the {} axis is a copy of the {} axis: check the driver or the log's columns",
                axis_letter(*axis),
                axis_letter(*of)
            ),
            Self::Planar { thickness } => write!(
                f,
                "all samples are near one plane (thickness {:.1} % of the width): tilt the sensor on its side and upside \
                 down",
                Num(thickness * 100.0)
            ),
            Self::NotAnEllipsoid => write!(
                f,
                "no ellipsoid fits: rotate the sensor through more directions, away from moving iron and currents"
            ),
            Self::ThroughOrigin { distance } => write!(
                f,
                "the ellipsoid passes through the origin (within {:.2} %), and there the constant method is singular: use \
                 the trace or adjusted method",
                Num(distance * 100.0)
            ),
            Self::OffsetTooLarge { fields } => write!(
                f,
                "the offset is {:.0} times the field, which is implausible: look for a magnet, or rotate through more \
                 directions",
                Num(*fields)
            ),
            Self::AxisRatio { ratio } => write!(
                f,
                "the axes differ by a factor of {:.1}, which is implausible: check the scale of each axis, or rotate \
                 through more directions",
                Num(*ratio)
            ),
            Self::NotFinite => write!(f, "a sample, scale or option is not a finite number in range"),
        }
    }
}

impl core::error::Error for FitError {}
