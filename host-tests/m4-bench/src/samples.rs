//! The samples every image works on: all over the sphere, hard and soft iron, noise, in counts.

/// Samples in the table.
pub const COUNT: usize = 1200;
/// Scale of the simulated sensor, µT per count.
pub const UT_PER_COUNT: f64 = 0.1;
/// Field magnitude of the simulation, counts.
const FIELD: f64 = 500.0;

/// Fills a table with samples of a mildly distorted sensor: offset of 0.9 fields, soft iron of some 10 %, noise of two
/// counts. Only `libm` and integers, so the same numbers everywhere.
pub fn fill(table: &mut [[i16; 3]]) {
    let mut noise = Noise(0x2545_f491);
    let n = table.len().max(1) as f64;
    for (i, slot) in table.iter_mut().enumerate() {
        let z = 1.0 - (2.0 * i as f64 + 1.0) / n;
        let r = libm::sqrt(1.0 - z * z);
        let angle = 2.399_963_229_728_653 * i as f64;
        *slot = measured([r * libm::cos(angle), r * libm::sin(angle), z], &mut noise);
    }
}

/// Two counts of noise.
struct Noise(u32);

impl Noise {
    fn next(&mut self) -> f64 {
        // Irwin–Hall: the sum of twelve uniforms is near enough to a Gaussian of variance one.
        let sum: f64 = (0..12)
            .map(|_| {
                self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                f64::from(self.0 >> 8) / 16_777_216.0
            })
            .sum();
        (sum - 6.0) * 2.0
    }
}

/// What the sensor measures of a field in this direction.
fn measured(direction: [f64; 3], noise: &mut Noise) -> [i16; 3] {
    let h = direction.map(|v| v * FIELD);
    let x = [
        1.08 * h[0] + 0.05 * h[1] - 0.04 * h[2] + 310.0,
        0.94 * h[1] + 0.07 * h[2] - 270.0,
        1.03 * h[2] + 190.0,
    ];
    x.map(|v| libm::round(v + noise.next()) as i16)
}

/// A calibration in the hand, 50 samples a second for a minute: turned smoothly all over the sphere, with a rest of four
/// seconds in every ten, and every 25th sample a repetition of the one before.
pub struct Turned {
    noise: Noise,
    sample: u32,
    moved: u32,
    last: [i16; 3],
}

impl Turned {
    /// Samples of the whole calibration.
    pub const COUNT: u32 = 3000;

    /// From the beginning.
    pub fn new() -> Self {
        Self { noise: Noise(0x5bd1_e995), sample: 0, moved: 0, last: [0; 3] }
    }
}

impl Default for Turned {
    fn default() -> Self {
        Self::new()
    }
}

impl Iterator for Turned {
    type Item = [i16; 3];

    fn next(&mut self) -> Option<[i16; 3]> {
        if self.sample >= Self::COUNT {
            return None;
        }
        self.sample += 1;
        if self.sample % 500 < 300 {
            self.moved += 1;
        }
        if !self.sample.is_multiple_of(25) {
            // A radian a second and more; the tilt comes back to a place only after the whole calibration.
            let turn = 0.023 * f64::from(self.moved);
            let z = libm::sin(0.003_7 * f64::from(self.moved) - 1.4);
            let r = libm::sqrt(1.0 - z * z);
            self.last = measured([r * libm::cos(turn), r * libm::sin(turn), z], &mut self.noise);
        }
        Some(self.last)
    }
}
