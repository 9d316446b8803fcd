//! A push button without its bounces.

/// How long a level has to stand before it counts.
const SETTLED_MS: u64 = 30;

/// A debounced button.
#[derive(Default)]
pub struct Button {
    /// The level that counts.
    down: bool,
    /// Since when the other level has been seen, if it has.
    changing_since_ms: Option<u64>,
}

impl Button {
    /// Whether the button has just been pressed, given its level `down` at `now_ms`. To be called often.
    pub fn pressed(&mut self, down: bool, now_ms: u64) -> bool {
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
}
