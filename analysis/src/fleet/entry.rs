//! One log of a fleet, as the summary needs it.

/// The figures of a log whose calibration can be used.
#[derive(Debug, Clone, PartialEq)]
pub struct Calibrated {
    /// Offset, µT.
    pub offset_ut: [f64; 3],
    /// Diagonal of the matrix.
    pub gains: [f64; 3],
    /// Magnitude of the field, µT.
    pub field_ut: f64,
    /// Effects that move the offset in proportion to a column.
    pub moves: Vec<Move>,
}

/// An offset in proportion to a column: the offset of the calibration is that at the reference, which each log has its own of.
#[derive(Debug, Clone, PartialEq)]
pub struct Move {
    /// Id of the effect.
    pub id: String,
    /// µT per unit of the column.
    pub coefficients: [f64; 3],
    /// Value of the column at which the effect is zero.
    pub reference: f64,
}

/// One log of a fleet.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FleetLog {
    /// Name of the log.
    pub name: String,
    /// Vehicle that flew it; empty if unknown.
    pub vehicle: String,
    /// Sensor that was read; empty if unknown.
    pub sensor: String,
    /// Days since 1970 at the start of the log.
    pub day: Option<f64>,
    /// Word of the verdict, or of the failure.
    pub verdict: String,
    /// Ids of the effects that the log names.
    pub effects: Vec<String>,
    /// Calibration, if it can be used.
    pub calibrated: Option<Calibrated>,
    /// Rms of the base model's residual over the field.
    pub error_share: Option<f64>,
    /// Noise of the sensor, σ per axis, µT.
    pub noise_ut: Option<f64>,
}
