//! The sensor as the library is told of it.

/// What the library needs to know of the sensor. All values are in the board's axes: x forward, y right, z down.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IronoutSensor {
    /// Scale of each axis, µT per count; positive.
    pub ut_per_count: [f32; 3],
    /// Samples per second that are pushed; 0 if unknown.
    pub rate_hz: f32,
    /// Magnitude of the Earth's field where the calibration is made, µT; 0 if unknown. Corrected vectors are scaled to it;
    /// without it they keep the mean measured magnitude.
    pub field_ut: f32,
}
