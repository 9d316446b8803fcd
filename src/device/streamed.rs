//! A sample on its way to a stream.

/// What a stream line is made of.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sample {
    pub(super) t_ms: u64,
    /// Its number since power-up, samples that were lost among them.
    pub(super) seq: u32,
    pub(super) counts: [i16; 3],
    /// `None` where an axis was out of range: the counts are no measurement.
    pub(super) measured_ut: Option<[f32; 3]>,
    /// The rate of turn then, rad/s.
    pub(super) turn_radps: Option<[f32; 3]>,
    /// Whether the board was tilted further than its calibration holds for.
    pub(super) is_tilted: bool,
}
