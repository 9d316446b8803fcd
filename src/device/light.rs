//! One light that shows what the board is doing.

/// What the light shows, and how it blinks for it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Light {
    /// The sensor does not work: three short flashes every two seconds.
    SensorFault,
    /// Collecting: blinks four times a second. Turn the board.
    Collecting,
    /// The last attempt was refused: two short flashes every second.
    Refused,
    /// Solved and not accepted yet: blinks once a second.
    Solved,
    /// A calibration is in use: on.
    Calibrated,
    /// No calibration: one short flash every two seconds.
    Uncalibrated,
}

impl Light {
    /// Whether the light is on at `t_ms`.
    pub const fn is_on(self, t_ms: u64) -> bool {
        self.is_on_in((t_ms % PERIOD_MS) as u32)
    }

    /// The same within a period. In 32 bits: a small core divides 64 of them in hundreds of cycles, and the pattern is looked
    /// through at every turn of a loop.
    const fn is_on_in(self, phase_ms: u32) -> bool {
        match self {
            Light::Calibrated => true,
            Light::Collecting => phase_ms % 250 < 125,
            Light::Solved => phase_ms % 1000 < 500,
            Light::Refused => flashes(phase_ms % 1000, 2),
            Light::SensorFault => flashes(phase_ms, 3),
            Light::Uncalibrated => flashes(phase_ms, 1),
        }
    }

    /// When the light changes next after `t_ms`; `None` where it never does.
    pub fn next_change_ms(self, t_ms: u64) -> Option<u64> {
        const STEP_MS: u32 = 25;
        if self == Light::Calibrated {
            return None;
        }
        // Every pattern changes at multiples of 25 ms, and within two seconds if at all.
        let phase_ms = (t_ms % PERIOD_MS) as u32;
        let begin_ms = phase_ms - phase_ms % STEP_MS;
        let now = self.is_on_in(phase_ms);
        let steps = (1..=PERIOD_MS as u32 / STEP_MS).map(|step| begin_ms + step * STEP_MS);
        let mut phases = steps.map(|later_ms| (later_ms, later_ms % PERIOD_MS as u32));
        let (later_ms, _) = phases.find(|&(_, phase_ms)| self.is_on_in(phase_ms) != now)?;
        Some(t_ms + u64::from(later_ms - phase_ms))
    }
}

/// All patterns repeat within it.
const PERIOD_MS: u64 = 2000;

/// `count` flashes of 100 ms, 200 ms apart, from the beginning of the period on.
const fn flashes(t_ms: u32, count: u32) -> bool {
    t_ms < 200 * count && t_ms % 200 < 100
}

#[cfg(test)]
mod tests {
    use super::Light;

    fn turned_on(light: Light, period_ms: u64) -> usize {
        (1..=period_ms).filter(|&t| light.is_on(t) && !light.is_on(t - 1)).count()
    }

    #[test]
    fn each_state_has_its_own_pattern() {
        let patterns = [
            (Light::SensorFault, 3),
            (Light::Collecting, 8),
            (Light::Refused, 4),
            (Light::Solved, 2),
            (Light::Calibrated, 0),
            (Light::Uncalibrated, 1),
        ];
        for (light, flashes) in patterns {
            assert_eq!(turned_on(light, 2000), flashes, "{light:?}");
        }
        assert!(Light::Calibrated.is_on(1234));
        assert_eq!(Light::Calibrated.next_change_ms(1234), None);
    }

    #[test]
    fn looking_at_the_changes_only_shows_the_whole_pattern() {
        for light in
            [Light::SensorFault, Light::Collecting, Light::Refused, Light::Solved, Light::Uncalibrated]
        {
            let (mut shown, mut change_ms) = (light.is_on(0), light.next_change_ms(0));
            for t_ms in 0..4000 {
                if change_ms == Some(t_ms) {
                    (shown, change_ms) = (light.is_on(t_ms), light.next_change_ms(t_ms));
                }
                assert_eq!(shown, light.is_on(t_ms), "{light:?} at {t_ms}");
            }
        }
    }
}
