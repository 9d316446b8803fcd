//! The looks, and the turn from one to the next.

use super::turn::{Link, Way};
use crate::vector::{dot, norm, scaled};

/// Looks that are kept.
pub const MAX_LOOKS: usize = 64;
/// Looks that an offset is measured from at least.
pub const MIN_LOOKS: usize = 24;
/// Turn of the field within one look, degrees.
pub const LOOK_DEG: f32 = 6.0;
/// Cosine of that.
const LOOK_COS: f32 = 0.994_521_9;
/// A look that takes longer than this, ms, is no turning.
const MAX_LOOK_MS: u64 = 2000;

/// The last looks of a board that turns, and the offset that they show.
#[derive(Clone, Debug)]
pub struct Rezero {
    /// With the turn since the look before.
    looks: [([f32; 3], Link); MAX_LOOKS],
    /// Looks ever taken; the next goes to this place, modulo their number.
    taken: usize,
    /// Sum and number of the readings of the look that is open, its first reading, and when it began.
    open: Option<([f32; 3], u16, [f32; 3], u64)>,
    way: Way,
}

impl Default for Rezero {
    fn default() -> Self {
        Self::new()
    }
}

impl Rezero {
    /// Without looks.
    pub const fn new() -> Self {
        Self { looks: [([0.0; 3], Link::NONE); MAX_LOOKS], taken: 0, open: None, way: Way::new() }
    }

    /// Forgets all looks.
    pub fn clear(&mut self) {
        (self.taken, self.open, self.way) = (0, None, Way::new());
    }

    /// Number of looks.
    pub fn count(&self) -> usize {
        self.taken.min(MAX_LOOKS)
    }

    /// Takes a corrected reading, µT, of this time since power-up, and the gyro's rate of turn at it, rad/s in the same axes; `None`
    /// without a gyro, or if it is silent.
    pub fn push(&mut self, t_ms: u64, corrected_ut: [f32; 3], turn_radps: Option<[f32; 3]>) {
        self.way.step(t_ms, turn_radps);
        let length = norm(corrected_ut);
        if !length.is_finite() {
            return;
        }
        let begun = Some((corrected_ut, 1, corrected_ut, t_ms));
        let Some((sum, count, first, begun_ms)) = &mut self.open else {
            self.open = begun;
            return self.way.skip(0.0);
        };
        let took_ms = t_ms.saturating_sub(*begun_ms);
        let took_s = took_ms as f32 * 1e-3;
        if took_ms > MAX_LOOK_MS || t_ms < *begun_ms {
            self.way.skip(took_s);
            self.open = begun;
        } else if dot(*first, corrected_ut) < LOOK_COS * norm(*first) * length {
            let look = scaled(*sum, 1.0 / f32::from(*count));
            if let Some(place) = self.looks.get_mut(self.taken % MAX_LOOKS) {
                *place = (look, self.way.close(*count, took_s));
            }
            // Past the first round only the place counts.
            self.taken = if self.taken + 1 == 2 * MAX_LOOKS { MAX_LOOKS } else { self.taken + 1 };
            self.open = begun;
        } else {
            (0..3).for_each(|axis| sum[axis] += corrected_ut[axis]);
            *count = count.saturating_add(1);
            self.way.count();
        }
    }

    /// A look, from the oldest on, with the turn since the one before.
    #[inline(never)]
    pub(super) fn at(&self, place: usize) -> Option<&([f32; 3], Link)> {
        let oldest = self.taken.saturating_sub(MAX_LOOKS);
        (place < self.count()).then(|| self.looks.get((oldest + place) % MAX_LOOKS)).flatten()
    }

    /// The looks from the oldest on.
    pub(super) fn iter(&self) -> impl Iterator<Item = [f32; 3]> + '_ {
        (0..MAX_LOOKS).map_while(|place| self.at(place).map(|(look, _)| *look))
    }
}
