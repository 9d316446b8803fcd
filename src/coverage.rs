//! Which directions the field has been seen from: equal-area bins, the largest gap, and where to turn next.

use crate::calibration::{Calibration, norm};
use crate::math;
use heapless::Vec;

/// Slices of equal height (so of equal area) and sectors in each: the bins of the coverage.
const SLICES: usize = 6;
const SECTORS: usize = 8;
/// Number of equal-area bins.
pub const BINS: usize = SLICES * SECTORS;
/// Directions at which the largest gap is looked for; they lie some 16° apart.
const PROBES: usize = 162;

/// A map of directions, filled from corrected vectors.
#[derive(Clone, Debug)]
pub struct CoverageMap {
    bins: u64,
    /// Cosine of the angle from each probe to the nearest direction seen.
    nearest: [f32; PROBES],
}

impl Default for CoverageMap {
    fn default() -> Self {
        Self::new()
    }
}

/// What a [`CoverageMap`] says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coverage {
    /// Fraction of the equal-area bins that were seen, 0 … 1.
    pub fraction: f32,
    /// Largest angle from any direction to the nearest one seen, degrees.
    pub gap_deg: f32,
    /// The middle of that gap, a unit vector in the board's axes.
    pub gap_direction: [f32; 3],
}

impl Coverage {
    /// The side of the board through which the field has not been seen yet (x front, y right, z bottom).
    pub fn missing_side(&self) -> &'static str {
        side_name(self.gap_direction)
    }
}

impl CoverageMap {
    /// An empty map.
    pub const fn new() -> Self {
        Self { bins: 0, nearest: [-1.0; PROBES] }
    }

    /// Adds the direction of a corrected vector; its length does not matter. Zero and non-finite vectors are left out.
    pub fn add(&mut self, corrected: [f32; 3]) {
        let length = norm(corrected);
        if !(length > 0.0 && length.is_finite()) {
            return;
        }
        let u = corrected.map(|v| v / length);
        let slice = (((u[2] + 1.0) * 0.5 * SLICES as f32) as usize).min(SLICES - 1);
        let turn = math::atan2(f64::from(u[1]), f64::from(u[0])) / core::f64::consts::TAU + 0.5;
        let sector = ((turn * SECTORS as f64) as usize).min(SECTORS - 1);
        self.bins |= 1 << (slice * SECTORS + sector);
        for (i, best) in self.nearest.iter_mut().enumerate() {
            let p = PROBE[i];
            let cosine = p[0] * u[0] + p[1] * u[1] + p[2] * u[2];
            if cosine > *best {
                *best = cosine;
            }
        }
    }

    /// Coverage and largest gap so far.
    pub fn coverage(&self) -> Coverage {
        let mut worst = (1.0f32, [0.0f32, 0.0, 1.0]);
        for (cosine, direction) in self.nearest.iter().zip(PROBE) {
            if *cosine < worst.0 {
                worst = (*cosine, direction);
            }
        }
        Coverage {
            fraction: self.bins.count_ones() as f32 / BINS as f32,
            gap_deg: math::acos(f64::from(worst.0)).to_degrees() as f32,
            gap_direction: worst.1,
        }
    }
}

/// The probes: a Fibonacci lattice, evenly spread. A table, computed when the crate is compiled.
const PROBE: [[f32; 3]; PROBES] = fibonacci();

const fn fibonacci() -> [[f32; 3]; PROBES] {
    // cos and sin of the golden angle; the rotation is repeated instead of calling a sine, which is not const.
    const COS: f64 = -0.737_368_878_078_319_9;
    const SIN: f64 = 0.675_490_294_261_523_8;
    let mut out = [[0.0; 3]; PROBES];
    let (mut c, mut s) = (1.0f64, 0.0f64);
    let mut i = 0;
    while i < PROBES {
        let z = 1.0 - (2.0 * i as f64 + 1.0) / PROBES as f64;
        // √(1 − z²) by Newton steps.
        let square = 1.0 - z * z;
        let mut r = 1.0;
        let mut step = 0;
        while step < 12 {
            r = 0.5 * (r + square / r);
            step += 1;
        }
        out[i] = [(r * c) as f32, (r * s) as f32, z as f32];
        (c, s) = (c * COS - s * SIN, s * COS + c * SIN);
        i += 1;
    }
    out
}

/// The name of the side a direction points through, in the board's axes: x front, y right, z bottom. Its length does not
/// matter; `any` where it has none.
pub fn side_name(direction: [f32; 3]) -> &'static str {
    const NAMES: [&str; 27] = [
        "back-left-top",
        "back-left",
        "back-left-bottom",
        "back-top",
        "back",
        "back-bottom",
        "back-right-top",
        "back-right",
        "back-right-bottom",
        "left-top",
        "left",
        "left-bottom",
        "top",
        "any",
        "bottom",
        "right-top",
        "right",
        "right-bottom",
        "front-left-top",
        "front-left",
        "front-left-bottom",
        "front-top",
        "front",
        "front-bottom",
        "front-right-top",
        "front-right",
        "front-right-bottom",
    ];
    let length = norm(direction);
    let direction = if length > 0.0 { direction.map(|v| v / length) } else { direction };
    let third = |v: f32| {
        if v > 0.4 {
            2
        } else if v < -0.4 {
            0
        } else {
            1
        }
    };
    let place = third(direction[0]) * 9 + third(direction[1]) * 3 + third(direction[2]);
    NAMES.get(place).copied().unwrap_or("any")
}

/// Most points a [`Sketch`] keeps.
pub const SKETCH_POINTS: usize = 240;

/// A bounded set of measured points spread over everything seen, kept on the board instead of the samples: the coverage
/// can be drawn after the solve, when the centre is known at last.
///
/// A point is kept if it is farther than some distance from all kept ones; when the set is full, the distance grows and
/// the set is thinned.
#[derive(Clone, Debug)]
pub struct Sketch {
    points: Vec<[i16; 3], SKETCH_POINTS>,
    ut_per_count: [f32; 3],
    spacing_ut: f32,
}

impl Sketch {
    /// An empty sketch for a sensor of this scale, µT per count.
    pub fn new(ut_per_count: [f32; 3]) -> Self {
        Self { points: Vec::new(), ut_per_count, spacing_ut: 2.0 }
    }

    fn far_from(points: &[[i16; 3]], point: [i16; 3], scale: [f32; 3], spacing: f32) -> bool {
        points.iter().all(|p| {
            let d: f32 = (0..3)
                .map(|a| {
                    let d = (f32::from(p[a]) - f32::from(point[a])) * scale[a];
                    d * d
                })
                .sum();
            d > spacing * spacing
        })
    }

    /// Takes a sample into account.
    pub fn add(&mut self, counts: [i16; 3]) {
        if !Self::far_from(&self.points, counts, self.ut_per_count, self.spacing_ut) {
            return;
        }
        // Few rounds are needed; the bound keeps a nonsensical scale from looping.
        for _ in 0..64 {
            if !self.points.is_full() {
                break;
            }
            self.spacing_ut *= 1.3;
            let mut kept: Vec<[i16; 3], SKETCH_POINTS> = Vec::new();
            for point in &self.points {
                if Self::far_from(&kept, *point, self.ut_per_count, self.spacing_ut) {
                    // Cannot be full: `kept` holds a subset of as many points.
                    let _ = kept.push(*point);
                }
            }
            self.points = kept;
        }
        if Self::far_from(&self.points, counts, self.ut_per_count, self.spacing_ut) {
            // A full set was thinned above; where it could not be, the point is left out.
            let _ = self.points.push(counts);
        }
    }

    /// Forgets all points.
    pub fn clear(&mut self) {
        self.points.clear();
        self.spacing_ut = 2.0;
    }

    /// The points kept, counts.
    pub fn points(&self) -> &[[i16; 3]] {
        &self.points
    }

    /// The coverage of the points as corrected by `calibration`.
    pub fn coverage(&self, calibration: &Calibration<f32>) -> Coverage {
        let mut map = CoverageMap::new();
        for p in &self.points {
            let measured = core::array::from_fn(|a| f32::from(p[a]) * self.ut_per_count[a]);
            map.add(calibration.apply(measured));
        }
        map.coverage()
    }

    /// The middle of the extremes seen, µT.
    pub fn middle_ut(&self) -> [f32; 3] {
        let mut low = [i16::MAX; 3];
        let mut high = [i16::MIN; 3];
        for p in &self.points {
            for a in 0..3 {
                low[a] = low[a].min(p[a]);
                high[a] = high[a].max(p[a]);
            }
        }
        core::array::from_fn(|a| (f32::from(low[a]) + f32::from(high[a])) * 0.5 * self.ut_per_count[a])
    }

    /// The coverage before there is a calibration: about the middle of the extremes seen.
    pub fn coverage_about_middle(&self) -> Coverage {
        self.coverage(&Calibration { offset_ut: self.middle_ut(), ..Calibration::identity(1.0) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn probes_are_unit_vectors_all_over_the_sphere() {
        for p in PROBE {
            assert!((norm(p) - 1.0).abs() < 1e-6);
        }
        // Each probe's nearest other probe is 10 … 22° away.
        for (i, p) in PROBE.iter().enumerate() {
            let best = PROBE
                .iter()
                .enumerate()
                .filter(|(j, _)| *j != i)
                .map(|(_, q)| p[0] * q[0] + p[1] * q[1] + p[2] * q[2])
                .fold(-1.0f32, f32::max);
            assert!((0.92..0.985).contains(&best), "{i}: {best}");
        }
    }

    #[test]
    fn half_a_sphere_is_half_covered_and_names_the_missing_side() {
        let mut map = CoverageMap::new();
        for p in PROBE.iter().filter(|p| p[2] > 0.0) {
            map.add(*p);
        }
        let c = map.coverage();
        assert!((c.fraction - 0.5).abs() < 0.06, "{}", c.fraction);
        assert!((c.gap_deg - 90.0).abs() < 12.0, "{}", c.gap_deg);
        assert_eq!(c.missing_side(), "top");
    }

    #[test]
    fn a_sketch_of_the_whole_sphere_covers_it() {
        let mut sketch = Sketch::new([0.1; 3]);
        for i in 0..5000 {
            let z = 1.0 - 2.0 * (f64::from(i) + 0.5) / 5000.0;
            let (r, angle) = (math::sqrt(1.0 - z * z), f64::from(i) * 0.7);
            let u = [r * math::cos(angle), r * math::sin(angle), z];
            sketch.add(u.map(|v| (500.0 * v + 930.0) as i16));
        }
        let c = sketch.coverage_about_middle();
        assert!(c.fraction > 0.97 && c.gap_deg < 25.0, "{c:?}, {} points", sketch.points().len());
    }
}
