//! An effect of one's own: a servo whose magnet turns with its arm.
//!
//! - `servo.rs` is the effect: its numbers, and what programs ask about it.
//! - `simulated.rs` hides it in simulated logs.
//! - [`REGISTRY`] is the one line that makes it known.

mod servo;
mod simulated;

pub use servo::Servo;
pub use simulated::SimulatedServo;

use ironout::effect::Registry;

/// The effects of the library, and this one.
pub const REGISTRY: Registry = Registry::with(&[&servo::Servos]);
