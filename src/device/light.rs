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
        match self {
            Light::Calibrated => true,
            Light::Collecting => t_ms % 250 < 125,
            Light::Solved => t_ms % 1000 < 500,
            Light::Refused => flashes(t_ms % 1000, 2),
            Light::SensorFault => flashes(t_ms % 2000, 3),
            Light::Uncalibrated => flashes(t_ms % 2000, 1),
        }
    }

    /// When the light changes next after `t_ms`; `None` where it never does.
    pub fn next_change_ms(self, t_ms: u64) -> Option<u64> {
        // Every pattern changes at multiples of 25 ms, and within two seconds if at all.
        let now = self.is_on(t_ms);
        (1..=80).map(|step| (t_ms / 25 + step) * 25).find(|&later_ms| self.is_on(later_ms) != now)
    }
}

/// `count` flashes of 100 ms, 200 ms apart, from the beginning of the period on.
const fn flashes(t_ms: u64, count: u64) -> bool {
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
