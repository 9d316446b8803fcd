//! A rate with what it is worth: so many of so many, and the interval that 95 of 100 such intervals are right with.

use std::fmt;

/// The 97.5 % quantile of the normal distribution.
const Z: f64 = 1.959_963_985;

/// So many of so many.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Rate {
    /// How many.
    pub count: u64,
    /// Of how many.
    pub of: u64,
}

impl Rate {
    /// Wilson's interval, shares from 0 to 1; `None` of nothing. Unlike the plain one it is right at 0 and at 100 % too.
    pub fn interval(self) -> Option<[f64; 2]> {
        if self.of == 0 {
            return None;
        }
        let (n, p) = (self.of as f64, self.count as f64 / self.of as f64);
        let middle = p + Z * Z / (2.0 * n);
        let half = Z * (p * (1.0 - p) / n + Z * Z / (4.0 * n * n)).sqrt();
        Some([-half, half].map(|side| ((middle + side) / (1.0 + Z * Z / n)).clamp(0.0, 1.0)))
    }
}

impl fmt::Display for Rate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some([low, high]) = self.interval().map(|ends| ends.map(|end| 100.0 * end)) else {
            return f.pad("-");
        };
        f.pad(&format!("{} of {} ({low:.1} to {high:.1} %)", self.count, self.of))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against the same formula worked out in another language.
    #[test]
    fn wilsons_interval() {
        for (count, of, low, high) in [(20, 20, 0.8389, 1.0), (0, 263, 0.0, 0.0144), (17, 20, 0.6396, 0.9476)]
        {
            let [a, b] = Rate { count, of }.interval().expect("a rate of something");
            assert!((a - low).abs() < 1e-4 && (b - high).abs() < 1e-4, "{count} of {of}: {a} {b}");
        }
        assert_eq!(Rate::default().interval(), None);
        assert_eq!(Rate { count: 20, of: 20 }.to_string(), "20 of 20 (83.9 to 100.0 %)");
    }
}
