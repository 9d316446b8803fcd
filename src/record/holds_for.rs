//! The tilts that a calibration is right for, where it is not right for all.

#[cfg(feature = "record")]
use super::layout::{Reader, Writer};

/// Tilts that the error of a heading is kept for, degrees.
pub const TILTS_DEG: [f32; 4] = [0.0, 10.0, 20.0, 45.0];
/// Square of how far the length of a direction may be from one.
#[cfg(feature = "record")]
const ROUNDING: f32 = 1e-3;

/// The tilts that a calibration is right for: that of a vehicle, which cannot be turned over.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct HoldsFor {
    /// Largest tilt from `down`, degrees.
    pub tilt_deg: f32,
    /// Direction down of the level vehicle, unit vector in the board's axes.
    pub down: [f32; 3],
    /// Heading error (1σ) at the tilts of [`TILTS_DEG`], degrees.
    pub heading_errors_deg: [f32; 4],
}

impl HoldsFor {
    /// The tilt of this specific force, degrees; `None` for one that is zero or not finite.
    #[cfg(feature = "device")]
    pub(crate) fn tilt_deg_of(&self, force_mps2: [f32; 3]) -> Option<f32> {
        use crate::vector::{dot, norm};
        let length = norm(force_mps2);
        let cosine = -dot(self.down, force_mps2) / length;
        (length > 0.0 && cosine.is_finite())
            .then(|| crate::math::acosf(cosine.clamp(-1.0, 1.0)) * (180.0 / core::f32::consts::PI))
    }

    #[cfg(feature = "record")]
    fn is_sound(&self) -> bool {
        let [x, y, z] = self.down;
        let length2 = x * x + y * y + z * z;
        let is_error = |error: &f32| *error >= 0.0 && error.is_finite();
        self.tilt_deg > 0.0
            && self.tilt_deg <= 180.0
            && (length2 - 1.0).abs() < ROUNDING
            && self.heading_errors_deg.iter().all(is_error)
    }

    #[cfg(feature = "record")]
    pub(super) fn write(&self, writer: &mut Writer) {
        let numbers = [self.tilt_deg].into_iter().chain(self.down).chain(self.heading_errors_deg);
        numbers.for_each(|value| writer.put(&value.to_le_bytes()));
    }

    /// `None` if the bytes are not such tilts.
    #[cfg(feature = "record")]
    pub(super) fn read(reader: &mut Reader<'_>) -> Option<Self> {
        let tilt_deg = reader.single().ok()?;
        let (mut down, mut heading_errors_deg) = ([0.0; 3], [0.0; 4]);
        for value in down.iter_mut().chain(&mut heading_errors_deg) {
            *value = reader.single().ok()?;
        }
        Some(Self { tilt_deg, down, heading_errors_deg }).filter(Self::is_sound)
    }
}
