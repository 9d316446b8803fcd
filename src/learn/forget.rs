//! What is left of the study once its oldest block is forgotten, held against values of its own time.
//!
//! A column is a multiple of the offset's, by how far it is from the value that it is held against. Held against a value of long ago
//! (a clock at power-up, the temperature of a cold start) it would be nearly the offset's column itself, and single precision would
//! have no digits for the difference.

use super::layout::{DRIFT, DRIFT_UNIT_MS, EFFECTS};
use super::learner::Learner;

impl Learner {
    /// Holds each effect's column against its mean over the rows that are left, the clock against where they begin. What was learned
    /// is the same, about the same model.
    #[inline(never)]
    pub(super) fn hold_against_what_is_left(&mut self) {
        // With every second block, so that both parts of a range reach as far back as the sums do, to within a block.
        self.is_odd = !self.is_odd;
        if !self.is_odd {
            self.columns.forget_ranges();
        }
        for effect in 0..EFFECTS {
            let first = DRIFT + 3 * effect;
            let (mut along, mut size) = (0.0, 0.0);
            for block in self.blocks.iter() {
                along += (0..3).map(|axis| block.entry(first + axis, axis)).sum::<f32>();
                size += (0..3).map(|axis| block.entry(axis, axis)).sum::<f32>();
            }
            let mean = along / size;
            let further = match effect.checked_sub(1) {
                // The mean is in the middle. Whole units, so that the clock goes with it to the digit.
                None => {
                    let now = self.last_ms.saturating_sub(self.first_ms) as f32 / DRIFT_UNIT_MS;
                    (2.0 * mean - now) as u32 as f32
                }
                Some(_) => mean,
            };
            if !(further.is_finite() && further != 0.0) {
                continue;
            }
            match effect.checked_sub(1) {
                None => self.first_ms += (further * DRIFT_UNIT_MS) as u64,
                Some(place) => self.columns.hold_against(place, further),
            }
            for block in self.blocks.iter_mut() {
                (0..3).for_each(|axis| block.take_off_column(first + axis, axis, further));
            }
            self.marks.hold_against(effect, further);
            if let (Some(point), Some(theta)) = (&mut self.point, self.carried.get(effect)) {
                for (offset, along) in point.offset_ut.iter_mut().zip(theta) {
                    *offset += point.field_ut * along * further;
                }
            }
        }
    }
}
