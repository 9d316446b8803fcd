//! The watch over a calibration in use.

use crate::calibration::IronoutCalibration;
use crate::error::IronoutError;
use crate::pointer;
use crate::state::{self, Kind};
use ironout::clock::Extended;
use ironout::monitor::{Condition, Monitor};

/// What the monitor says of the calibration in use.
// The names are those of C.
#[allow(non_camel_case_types)]
#[repr(i32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum IronoutCondition {
    /// No disturbance was detected.
    IRONOUT_GOOD = 0,
    /// Something magnetic is near: do not trust the field now.
    IRONOUT_DISTURBED = 1,
    /// The calibration no longer fits the board: calibrate again.
    IRONOUT_OUTDATED = 2,
}

/// A watch over a calibration, in the caller's memory. Its content is the library's own.
#[repr(C)]
pub struct IronoutMonitor {
    opaque: [u64; IRONOUT_MONITOR_WORDS],
}

/// Size of ironout_monitor in words of 8 bytes.
pub const IRONOUT_MONITOR_WORDS: usize = 16;

/// What is in it.
struct Watch {
    monitor: Monitor,
    clock: Extended,
}

impl Kind for Watch {
    const MARK: u32 = 0x4972_6f03;
    type Opaque = IronoutMonitor;
}

const _: () = Watch::FITS;

/// Begins to watch a calibration: its field, noise and predicted error are copied.
///
/// IRONOUT_BAD_ARGUMENT: its field is not positive and finite.
#[unsafe(no_mangle)]
pub extern "C" fn ironout_monitor_init(
    monitor: *mut IronoutMonitor,
    calibration: *const IronoutCalibration,
) -> IronoutError {
    let begun = pointer::input(calibration).and_then(|calibration| {
        let IronoutCalibration { field_ut, noise_ut, predicted_error_ut, .. } = *calibration;
        if !(field_ut.is_finite() && field_ut > 0.0) {
            return Err(IronoutError::IRONOUT_BAD_ARGUMENT);
        }
        let watch =
            Watch { monitor: Monitor::new(field_ut, noise_ut, predicted_error_ut), clock: Extended::new() };
        state::init(monitor, watch)
    });
    IronoutError::of(begun)
}

/// Takes a corrected sample and writes what is to be said now to `condition`. `t_ms` may wrap. `accel_mps2` is the specific
/// force in the board's axes, m/s² (at rest level: 0, 0, -9.8); null if there is no accelerometer. A sample that is not
/// finite is passed over. The calibration is never changed.
/// cbindgen:ptrs-as-arrays=[[corrected_ut; 3], [accel_mps2; 3]]
#[unsafe(no_mangle)]
pub extern "C" fn ironout_monitor_push(
    monitor: *mut IronoutMonitor,
    t_ms: u32,
    corrected_ut: *const f32,
    accel_mps2: *const f32,
    condition: *mut IronoutCondition,
) -> IronoutError {
    let pushed = pointer::vector(corrected_ut).and_then(|corrected_ut| {
        let accel_mps2 = pointer::optional_vector(accel_mps2)?;
        let watch = state::get_mut::<Watch>(monitor)?;
        let t_ms = watch.clock.at(t_ms);
        watch.monitor.push(t_ms, corrected_ut, accel_mps2);
        let said = match watch.monitor.condition() {
            Condition::Good => IronoutCondition::IRONOUT_GOOD,
            Condition::Disturbed => IronoutCondition::IRONOUT_DISTURBED,
            Condition::Outdated => IronoutCondition::IRONOUT_OUTDATED,
        };
        pointer::write(condition, said)
    });
    IronoutError::of(pushed)
}
