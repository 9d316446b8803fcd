//! `ironout` — magnetometer calibration that runs on the microcontroller, says how good it is, and finds what is missing.
//!
//! # The model in ten lines
//!
//! A compass on a board lies. Magnets nearby add a constant (hard iron `b`), steel and uneven, crooked sensor axes bend the
//! field (soft iron `A`), and there is noise: `measured = A · field + b + noise`. While the board turns, the true field
//! draws a sphere of radius `F` in the board's axes; the measurements draw a shifted ellipsoid. Fitting that ellipsoid
//! gives `b` and `C = A⁻¹`, and `corrected = C · (measured − b)` lies on the sphere again. The ellipsoid is a quadric, linear
//! in nine coefficients, so the fit needs only the 9×9 matrix `DᵀD` and the vector `DᵀĤ²` of Dong, Chou and Fang (2014):
//! [`moments::Moments`] keeps them exactly, in 384 bytes, while samples stream in. [`fit::fit`] solves for them, by default with
//! adjusted least squares, which has no bias from noise and estimates the noise itself. From magnitudes alone `C` is known up
//! to a rotation; an accelerometer tells the rotation too.
//!
//! # Calibrating
//!
//! ```
//! use ironout::sensor::{Sample, Sensor};
//! use ironout::session::{Session, SessionConfig};
//!
//! let sensor = Sensor::uniform("a chip", 0.1, 50.0); // a driver says it: driver.describe()
//! let mut session = Session::new(SessionConfig {
//!     field_ut: Some(50.0), // the field where the board is; without it the mean magnitude is kept
//!     ..SessionConfig::of(&sensor)
//! });
//! session.start();
//! for i in 0..1500 {
//!     // On a board: sensor.sample(&driver.read()?)
//!     let (tilt, turn) = (i as f64 * 0.013, i as f64 * 0.11);
//!     let field = [tilt.cos() * turn.cos(), tilt.cos() * turn.sin(), tilt.sin()].map(|v| 500.0 * v);
//!     session.push(Sample::valid([field[0] as i16 + 930, field[1] as i16 - 120, (1.1 * field[2]) as i16 + 45]));
//! }
//! let outcome = session.stop()?;
//! assert!(outcome.verdict.accepted, "{:?}", outcome.verdict.reasons);
//! let record = session.accept()?; // what is worth storing
//! assert!((record.calibration.offset_ut[0] - 93.0).abs() < 0.1);
//! // Live, in single precision, straight from counts:
//! let calibration = record.calibration.cast::<f32>();
//! let corrected_ut = calibration.apply_counts(&sensor, [1430, -120, 45]);
//! assert!((corrected_ut[0] - 50.0).abs() < 0.1);
//! # Ok::<(), ironout::session::StateError>(())
//! ```
//!
//! # Rooms
//!
//! | module | what it does |
//! |---|---|
//! | [`moments`], [`gate`], [`coverage`], [`whiteness`] | what streams: exact sums, the rest gate, the directions seen, the independence of samples |
//! | [`scatter`], [`fit`], [`quality`] | what solves: centred moments, the methods, the verdict with reasons |
//! | [`calibration`], [`extended`] | what is applied: offset and matrix, and with them the effects that were found |
//! | [`effect`], [`model`], [`study`] | what the base does not know yet: shapes of physical causes, the model linearised with them, and the test for them |
//! | [`learn`] | the study that a board carries with it: what is missing, found on its own samples |
//! | [`sensor`] | what a sensor is: its description and its samples |
//! | [`session`] | the state machine around them |
//! | [`record`], [`store`] | what survives a restart: a checked record in two slots |
//! | [`protocol`], [`device`] | the console's language, and the board's whole application without I/O |
//!
//! Each room imports only what stands before it in the order of `host-tests/layers/ROOMS.md`, which `cargo layers` checks.
//! Data flow one way: a fit never reads a driver, a driver never knows a calibration, and nothing here names a pin or a bus.
//!
//! # Features
//!
//! | feature | what it adds |
//! |---|---|
//! | none | sums, fit, correction, [`heading`], [`monitor`] |
//! | `session` (default) | the state machine with rest gate, coverage, independence of samples, verdict |
//! | `record` | a calibration in checked bytes, and the two slots for it |
//! | `effects` | calibrations with effects of columns such as a temperature or a current, and their live correction; with `record` also in records |
//! | `study` | the study of missing effects, on the board and for a host |
//! | `methods` | sessions by other methods than [`fit::Method::Adjusted`], the default, and the device's level calibration |
//! | `device` | the whole application of a board with its console: `record` and `effects` too, and `study` where that is chosen |
//! | `defmt` | `defmt::Format` for what a firmware logs |
//!
//! `cargo footprint` prints what each takes of the flash. Rust 1.89 or newer.
//!
//! # What is not promised
//!
//! Standard errors are "from noise": an effect that is not in the model (temperature, motor current …) makes them too
//! small. A low residual alone proves nothing. No function panics; each refusal is a named error.
#![no_std]
#![forbid(unsafe_code)]
// What some rooms have for others is not used where those are left out.
#![cfg_attr(not(all(feature = "device", feature = "study")), allow(dead_code, unused_imports))]

pub mod calibration;
pub mod clock;
#[cfg(feature = "session")]
pub mod coverage;
mod dense;
#[cfg(feature = "device")]
pub mod device;
#[cfg(feature = "effects")]
pub mod effect;
#[cfg(feature = "effects")]
pub mod extended;
#[cfg(any(feature = "study", test))]
mod fdist;
pub mod fit;
#[cfg(feature = "session")]
pub mod gate;
pub mod heading;
#[cfg(feature = "study")]
pub mod learn;
#[cfg(feature = "device")]
pub mod level;
pub mod math;
#[cfg(feature = "effects")]
pub mod model;
pub mod moments;
pub mod monitor;
pub mod monomial;
pub mod number;
#[cfg(feature = "device")]
pub mod protocol;
mod quadric;
#[cfg(feature = "session")]
pub mod quality;
mod real;
#[cfg(feature = "session")]
pub mod record;
mod refusal;
#[cfg(feature = "device")]
pub mod replacement;
pub mod rezero;
pub mod scatter;
pub mod sensor;
#[cfg(feature = "session")]
pub mod session;
#[cfg(feature = "record")]
pub mod store;
#[cfg(feature = "study")]
pub mod study;
mod trig;
pub mod vector;
#[cfg(feature = "session")]
pub mod whiteness;
