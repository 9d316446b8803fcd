//! When to look for a sensor's next conversion, so that each is found soon after it is there and the bus is mostly left alone.
//!
//! A sensor without a wire for *data ready* is asked over its bus, and a look takes as long as some bytes do. Looked for at
//! random, a conversion is stamped anywhere within the distance of two looks. So its rhythm is learned first, from looks a 64th of a
//! period apart; then there is one look just before each conversion is expected, repeated at once until it is there. The stamps
//! then lie within the length of a look or so of the conversions, whatever the sensor's clock does, and half of all looks find one.

/// How much earlier than expected the first look is, µs: where it finds the conversion, the next one is that much earlier, until one
/// comes too early and shows the edge again.
const LEAD_US: u32 = 40;
/// Edges that are seen before the rhythm is trusted.
const ENOUGH_EDGES: u8 = 8;
/// Looks in vain in a row, beyond the expected moment, after which the rhythm is learned anew.
const MOST_IN_VAIN: u8 = 12;
/// Finds at the first look in a row after which the same is done: the edge is somewhere before them.
const MOST_AT_ONCE: u8 = 24;

/// The rhythm of one sensor's conversions. Values in, values out: whoever has the clock and the bus looks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Conversions {
    nominal_us: u32,
    /// The period as it was learned.
    period_us: u32,
    /// The last conversion that was seen to come: a look in vain stood just before it. And how many came since.
    edge: Option<(u64, u32)>,
    edges: u8,
    /// Looks in vain since the last find.
    in_vain: u8,
    at_once: u8,
    /// The last find, and how far the finds were from a period after the one before, at most, since the rhythm was known.
    found_us: Option<u64>,
    worst_off_us: Option<u32>,
}

impl Conversions {
    /// Of a sensor with this rate; one that is no rate is taken for 10 Hz.
    pub fn new(rate_hz: f32) -> Self {
        let period_us = if rate_hz > 0.1 && rate_hz < 10_000.0 { 1e6 / rate_hz } else { 1e5 };
        let nominal_us = period_us as u32;
        Self {
            nominal_us,
            period_us: nominal_us,
            edge: None,
            edges: 0,
            in_vain: 0,
            at_once: 0,
            found_us: None,
            worst_off_us: None,
        }
    }

    /// The period as it is known by now, µs.
    pub const fn period_us(&self) -> u32 {
        self.period_us
    }

    /// How far a stamp was from one period after the stamp before it, µs, at most, since the rhythm was known for the first time.
    pub const fn worst_off_us(&self) -> Option<u32> {
        self.worst_off_us
    }

    /// Whether the rhythm is known.
    pub const fn is_known(&self) -> bool {
        self.edges >= ENOUGH_EDGES
    }

    /// A look at this time found a conversion: when to look for the next.
    pub fn found(&mut self, at_us: u64) -> u64 {
        let is_edge = self.in_vain > 0;
        self.in_vain = 0;
        let last_us = self.found_us.replace(at_us);
        if let Some(last_us) = last_us.filter(|_| self.is_known()) {
            let apart_us = at_us.saturating_sub(last_us).min(u64::from(u32::MAX)) as u32;
            // What was missed is counted elsewhere.
            if apart_us < self.period_us + self.period_us / 2 {
                let off_us = apart_us.abs_diff(self.period_us);
                self.worst_off_us = Some(self.worst_off_us.map_or(off_us, |worst| worst.max(off_us)));
            }
        }
        self.edge = match self.edge {
            Some((edge_us, since)) if is_edge => {
                self.learn(at_us.saturating_sub(edge_us), since + 1);
                Some((at_us, 0))
            }
            None if is_edge => Some((at_us, 0)),
            edge => edge.map(|(edge_us, since)| (edge_us, since + 1)),
        };
        self.at_once = if is_edge { 0 } else { self.at_once + 1 };
        if self.at_once > MOST_AT_ONCE {
            self.forget();
        }
        // The sensor's clock may be some percent fast: until it is known the search begins early.
        let early_us = if self.is_known() { LEAD_US.min(self.period_us / 16) } else { self.nominal_us / 8 };
        at_us + u64::from(self.period_us - early_us)
    }

    /// A look at this time found none: when to look again.
    pub fn missed(&mut self, at_us: u64) -> u64 {
        self.in_vain = self.in_vain.saturating_add(1);
        if self.is_known() && self.in_vain <= MOST_IN_VAIN {
            return at_us;
        }
        if self.is_known() {
            self.forget();
        }
        // A sensor that is far behind is asked less often.
        at_us + u64::from(if self.in_vain < 32 { self.nominal_us / 64 } else { self.nominal_us / 8 })
    }

    fn forget(&mut self) {
        (self.edge, self.edges, self.at_once) = (None, 0, 0);
        self.period_us = self.nominal_us;
    }

    /// Two edges were so far apart, with `count` periods between them.
    fn learn(&mut self, apart_us: u64, count: u32) {
        let count = u64::from(count.max(1));
        let period_us = (apart_us / count).min(u64::from(u32::MAX)) as u32;
        // A conversion that was missed, or a sensor that began anew.
        if period_us.abs_diff(self.nominal_us) > self.nominal_us / 8 {
            return self.forget();
        }
        self.edges = self.edges.saturating_add(1);
        let share = if self.edges < ENOUGH_EDGES { 2 } else { 8 };
        self.period_us = self.period_us.saturating_add_signed(
            (i64::from(period_us) - i64::from(self.period_us)).div_euclid(share) as i32,
        );
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::Conversions;
    use std::vec::Vec;

    /// How far stamps lie from the conversions' own rhythm, and looks a conversion, for a sensor of this true period, µs; `stop` is a
    /// time in which nobody can look.
    fn stamps(
        true_us: f64,
        nominal_hz: f32,
        look_us: u64,
        stop: core::ops::Range<u64>,
    ) -> (Vec<f64>, f64, u64, u32) {
        let mut rhythm = Conversions::new(nominal_hz);
        let (mut now_us, mut next_us, mut taken) = (777, 0, 0.0_f64);
        let (mut offs, mut looks, mut lost) = (Vec::new(), 0.0, 0);
        while now_us < 60_000_000 {
            now_us = next_us.max(now_us);
            if stop.contains(&now_us) {
                now_us = stop.end;
            }
            let stamp_us = now_us;
            looks += 1.0;
            // The status is sampled at the end of the look, the stamp is from its begin.
            now_us += look_us;
            let made = (now_us as f64 / true_us).floor();
            if made > taken {
                lost += (made - taken - 1.0) as u64;
                taken = made;
                if stamp_us > 2_000_000 {
                    offs.push(stamp_us as f64 - made * true_us);
                }
                now_us += 3 * look_us;
                next_us = rhythm.found(stamp_us);
            } else {
                next_us = rhythm.missed(stamp_us);
            }
        }
        let looks = looks / taken;
        (offs, looks, lost, rhythm.worst_off_us().expect("it was known"))
    }

    fn spread(offs: &[f64]) -> f64 {
        let least = offs.iter().copied().fold(f64::INFINITY, f64::min);
        offs.iter().copied().fold(f64::NEG_INFINITY, f64::max) - least
    }

    #[test]
    fn stamps_lie_within_a_tenth_of_a_millisecond_of_each_other_whatever_the_sensors_clock() {
        for true_us in [10_000.0, 9_400.0, 10_730.5, 10_000.37, 9_990.0] {
            let (offs, looks, lost, worst_us) = stamps(true_us, 100.0, 75, 0..0);
            assert!(worst_us < 100, "{true_us}: {worst_us}");
            // Of the conversion's own time, from the first to the last of a minute.
            assert!(spread(&offs) < 200.0, "{true_us}: {}", spread(&offs));
            let mean = offs.iter().sum::<f64>() / offs.len() as f64;
            assert!(offs.iter().all(|off| (off - mean).abs() < 100.0), "{true_us}");
            assert!(looks < 2.2, "{true_us}: {looks} looks a conversion");
            assert_eq!(lost, 0, "{true_us}");
        }
    }

    #[test]
    fn after_a_time_without_looks_the_rhythm_is_found_again() {
        let (offs, _, lost, _) = stamps(10_050.0, 100.0, 75, 20_000_000..20_055_000);
        assert!((4..=6).contains(&lost), "{lost}");
        let late = &offs[offs.len() - 3000..];
        assert!(spread(late) < 200.0, "{}", spread(late));
    }

    #[test]
    fn fast_and_slow_sensors_are_followed_and_no_rate_is_survived() {
        for (rate_hz, look_us) in [(10.0, 80), (30.0, 240), (200.0, 75), (1000.0, 60)] {
            let (offs, looks, _, _) = stamps(1.02e6 / f64::from(rate_hz), rate_hz, look_us, 0..0);
            assert!(!offs.is_empty() && looks < 4.5, "{rate_hz} Hz: {looks}");
        }
        for rate_hz in [0.0, -3.0, f32::NAN, f32::INFINITY] {
            assert_eq!(Conversions::new(rate_hz).period_us(), 100_000);
        }
    }
}
