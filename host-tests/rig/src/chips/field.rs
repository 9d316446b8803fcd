//! Where a simulated sensor is.

/// The field at the sensor, µT in its axes.
pub trait FieldSource {
    /// The field at time `t_s`.
    fn field_ut(&mut self, t_s: f64) -> [f64; 3];
}

impl<F: FnMut(f64) -> [f64; 3]> FieldSource for F {
    fn field_ut(&mut self, t_s: f64) -> [f64; 3] {
        self(t_s)
    }
}
