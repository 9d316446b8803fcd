//! What the heading and the lights are made of.

/// What the device keeps for its heading and for its lights.
#[derive(Debug, Clone, Copy)]
pub(super) struct View {
    /// The last measured vector, µT, and when.
    pub(super) latest: Option<(u64, [f32; 3])>,
    /// East positive.
    pub(super) declination_deg: f64,
    /// Whether the board has lights for more than a state.
    pub(super) has_lights: bool,
    /// The heading that the lights show, and when it was worked out.
    pub(super) heading: (u64, Option<f32>),
}

impl View {
    pub(super) const fn new() -> Self {
        Self { latest: None, declination_deg: 0.0, has_lights: false, heading: (0, None) }
    }

    /// Forgets what was measured; what was told stays.
    pub(super) const fn begin_anew(&mut self) {
        (self.latest, self.heading) = (None, (0, None));
    }

    pub(super) const fn measured(&mut self, t_ms: u64, measured_ut: [f32; 3]) {
        self.latest = Some((t_ms, measured_ut));
    }
}
