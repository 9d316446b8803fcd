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
    let mut state = 0x2545_f491_u32;
    let mut noise = || {
        // Irwin–Hall: the sum of twelve uniforms is near enough to a Gaussian of variance one.
        let sum: f64 = (0..12)
            .map(|_| {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                f64::from(state >> 8) / 16_777_216.0
            })
            .sum();
        (sum - 6.0) * 2.0
    };
    let n = table.len().max(1) as f64;
    for (i, slot) in table.iter_mut().enumerate() {
        let z = 1.0 - (2.0 * i as f64 + 1.0) / n;
        let r = libm::sqrt(1.0 - z * z);
        let angle = 2.399_963_229_728_653 * i as f64;
        let h = [r * libm::cos(angle) * FIELD, r * libm::sin(angle) * FIELD, z * FIELD];
        let x = [
            1.08 * h[0] + 0.05 * h[1] - 0.04 * h[2] + 310.0,
            0.94 * h[1] + 0.07 * h[2] - 270.0,
            1.03 * h[2] + 190.0,
        ];
        *slot = x.map(|v| libm::round(v + noise()) as i16);
    }
}
