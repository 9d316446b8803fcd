//! The board's application without the board: sensor in, console in and out, calibration applied and kept.
//!
//! [`Device`] does no I/O and never waits. Its owner (a blocking loop, interrupts and a main loop, an async task, a test) keeps to
//! one pattern:
//!
//! ```
//! use ironout::device::{Action, Device, DeviceConfig, Pace, SensorAnswer, SensorTask, StoreAnswer};
//! use ironout::sensor::{Reading, Sensor};
//!
//! let sensor = Sensor::uniform("a chip", 0.1, 75.0); // a driver says it: driver.describe()
//! let mut device = Device::new(DeviceConfig { board: "bench", sensor, pace: Pace::EachConversion });
//! let mut console = heapless::String::<4096>::new();
//! let mut typed = b"version\nstream raw\n".iter().copied().peekable();
//! let mut now_ms = 0;
//! loop {
//!     while typed.peek().is_some_and(|&byte| device.take_byte(byte)) {
//!         typed.next();
//!     }
//!     match device.poll(now_ms, &mut console) {
//!         Action::Sensor(SensorTask::Start) => device.complete_sensor(SensorAnswer::Started, now_ms),
//!         Action::Sensor(SensorTask::Sample) => {
//!             let reading = Reading { counts: [1, 2, 3], overflow: [false; 3] };
//!             device.complete_sensor(SensorAnswer::Reading(reading), now_ms);
//!         }
//!         Action::Sensor(SensorTask::Temperature) => {
//!             device.complete_sensor(SensorAnswer::Temperature(None), now_ms); // the chip has none
//!         }
//!         Action::Store(_) => device.complete_store(&StoreAnswer::Failed, now_ms), // there is no memory
//!         Action::Again => {}
//!         Action::Sleep if device.is_idle() => break,
//!         Action::Sleep => now_ms = device.next_deadline_ms(), // or until a byte or a sample comes
//!     }
//! }
//! assert!(console.contains("slots=unreadable,unreadable"));
//! assert!(console.contains("ok ironout=") && console.contains("ok stream=raw"));
//! ```
//!
//! Time is milliseconds since power-up. A firmware whose tick has 32 bits passes it as it is, `u64::from(tick)`: the device notices that
//! it has wrapped (after 49.7 days) and goes on, and the firmware sleeps *for* `device.next_deadline_ms() as u32 − tick` (wrapping)
//! milliseconds, not *until* then.
//!
//! [`Device::turn`] does one round of it with a driver and a memory that are waited for. What holds whatever goes wrong:
//! - a calibration in use is replaced only by one that was accepted, stored and read back;
//! - each line is answered exactly once, in the order they came, and never before the sensor has had its turn: a console that
//!   sends without end starves neither samples nor the button, and a solve begins right after a sample was taken;
//! - a sensor that fails is tried again for ever, and so is a memory that does not answer: the calibration in it is put to work as soon
//!   as it does.

mod active;
mod adopted;
mod button;
mod calibrate;
mod columns;
mod config;
mod console;
mod conversions;
mod dump;
#[cfg(feature = "study")]
mod effects;
mod extrapolated;
mod figures;
mod heading;
mod job_purpose;
mod learn;
mod learner_inputs;
mod level;
#[cfg(all(test, feature = "methods"))]
mod level_tests;
mod level_worse;
mod light;
mod load;
mod loading;
mod log;
mod machine;
mod name;
mod output;
mod own;
mod packet;
mod samples;
mod sensor;
mod serve;
mod shown;
mod store_watch;
mod stream;
mod streamed;
mod study;
#[cfg(test)]
mod tests;
#[cfg(not(feature = "study"))]
mod unasked;
#[cfg(not(feature = "study"))]
mod unstudied;
mod view;
#[cfg(feature = "study")]
mod why;
mod zero;

pub use crate::store::{StoreAnswer, StoreTask};
pub use button::ButtonEvent;
pub use config::DeviceConfig;
pub use conversions::Conversions;
pub use learn::{NO_TEMPERATURE_MS, TEMPERATURE_MS};
pub use light::Light;
pub use machine::{Action, Device};
pub use output::{MAX_REPLY_BYTES, Output};
pub use own::{MAX_OWN, Origin};
pub use sensor::{Pace, SensorAnswer, SensorFault, SensorTask};
pub use serve::serve_sensor;
pub use shown::Shown;
