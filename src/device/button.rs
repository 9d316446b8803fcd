//! The button: without its bounces, and what a press does.

use crate::store::{Slot, StoreError};

use super::sensor::SensorFault;

/// How long a level has to stand before it counts.
const SETTLED_MS: u64 = 30;

/// What a press of the button did.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ButtonEvent {
    /// Collecting has begun.
    Started,
    /// Nothing: the sensor does not work.
    NoSensor(SensorFault),
    /// The calibration was solved, stored in this slot, and is in use.
    Accepted(Slot),
    /// The data do not support a calibration; the one in use stays.
    Refused,
    /// The calibration is good and clearly worse than the one in use, which stays. `cal accept force` insists.
    Worse,
    /// The calibration is good and could not be stored; the one in use stays. `cal accept` tries again.
    NotStored(StoreError),
}

/// A debounced button.
#[derive(Debug, Clone, Default)]
pub(super) struct Button {
    /// The level that counts.
    down: bool,
    /// Since when the other level has been seen, if it has.
    changing_since_ms: Option<u64>,
}

impl Button {
    /// Whether the button has just been pressed, given its level `down` at `now_ms`.
    pub(super) fn pressed(&mut self, down: bool, now_ms: u64) -> bool {
        if down == self.down {
            self.changing_since_ms = None;
            return false;
        }
        let since_ms = *self.changing_since_ms.get_or_insert(now_ms);
        if now_ms.saturating_sub(since_ms) < SETTLED_MS {
            return false;
        }
        self.down = down;
        self.changing_since_ms = None;
        down
    }

    /// When the level has to be looked at again, where it is changing.
    pub(super) fn deadline_ms(&self) -> Option<u64> {
        self.changing_since_ms.map(|since_ms| since_ms.saturating_add(SETTLED_MS))
    }
}

#[cfg(test)]
mod tests {
    use super::Button;

    #[test]
    fn bounces_are_no_presses_and_a_held_button_is_one() {
        let mut button = Button::default();
        for (now_ms, down) in [(0, true), (3, false), (5, true), (20, false), (22, true)] {
            assert!(!button.pressed(down, now_ms), "{now_ms}");
        }
        assert_eq!(button.deadline_ms(), Some(52));
        assert!(button.pressed(true, 52));
        assert_eq!(button.deadline_ms(), None);
        assert!((53..2000).all(|now_ms| !button.pressed(true, now_ms)));
        // Let go with bounces, pressed again.
        assert!(!button.pressed(false, 2000) && !button.pressed(true, 2005) && !button.pressed(false, 2010));
        assert!(!button.pressed(false, 2040));
        assert!(!button.pressed(true, 2100));
        assert!(button.pressed(true, 2130));
    }
}
