//! A map of directions: what was seen of the sphere, and the largest part that was not.

use super::side::side_name;
use crate::math;

/// Slices of equal height (so of equal area): the bins of the coverage are their sectors.
pub const SLICES: usize = 6;
/// Sectors in each slice.
pub const SECTORS: usize = 8;
/// Number of equal-area bins.
pub const BINS: usize = SLICES * SECTORS;
/// Directions at which the largest gap is looked for; they lie some 16° apart.
const PROBES: usize = 162;
/// The probes are taken in steps of this many, which has no divisor in common with their number: a far one comes early, and
/// the others are soon known to be nearer.
const PROBE_STRIDE: usize = 61;

/// Rows of equal angle from +z to −z, and places around in each, 11.25° both: one direction is kept in each.
const ROWS: usize = 16;
const PLACES: usize = 32;
/// Cosines of the angles from the pole at which one row ends and the next begins, down to the equator.
const ROW_ENDS: [f32; ROWS / 2] =
    [0.980_785_3, 0.923_879_5, 0.831_469_6, 0.707_106_77, 0.555_570_24, 0.382_683_43, 0.195_090_32, 0.0];
/// Cosine of the least angle between a direction and any in the row so many rows away.
const REACH: [f32; ROWS] = [
    1.0,
    1.0,
    0.980_785_3,
    0.923_879_5,
    0.831_469_6,
    0.707_106_77,
    0.555_570_24,
    0.382_683_43,
    0.195_090_32,
    0.0,
    -0.195_090_32,
    -0.382_683_43,
    -0.555_570_24,
    -0.707_106_77,
    -0.831_469_6,
    -0.923_879_5,
];
/// Tangents of the angles between the places of an eighth turn.
const PLACE_ENDS: [f32; PLACES / 8] = [0.198_912_37, 0.414_213_57, 0.668_178_6, 1.0];
/// The length of a direction kept.
const UNIT: f32 = 32767.0;

/// A map of directions, filled from corrected vectors. 3.2 KB: made for a moment, not kept.
#[derive(Clone, Debug)]
pub struct CoverageMap {
    bins: Seen,
    /// The places of each row that were seen.
    seen: [u32; ROWS],
    /// A direction seen there.
    directions: [[i16; 3]; ROWS * PLACES],
}

impl Default for CoverageMap {
    fn default() -> Self {
        Self::new()
    }
}

/// Which of the equal-area bins were seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Seen(u64);

impl Seen {
    /// Whether the field came through the bin of slice `slice` (0 to 5 from −z, the top of the board, to +z) and sector `sector`
    /// (0 to 7, an eighth of a turn each, from the front to the right and on).
    pub const fn has(self, slice: usize, sector: usize) -> bool {
        slice < SLICES && self.0 >> (slice * SECTORS + sector % SECTORS) & 1 != 0
    }

    /// Adds a bin; for pictures of one.
    #[must_use]
    pub const fn with(self, slice: usize, sector: usize) -> Self {
        Self(self.0 | 1 << (slice % SLICES * SECTORS + sector % SECTORS))
    }

    /// How many there are.
    pub const fn count(self) -> u32 {
        self.0.count_ones()
    }
}

/// What a [`CoverageMap`] says.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Coverage {
    /// Fraction of the equal-area bins that were seen, 0 … 1.
    pub fraction: f32,
    /// Largest angle from any direction to the nearest one seen, degrees.
    pub gap_deg: f32,
    /// The middle of that gap, a unit vector in the board's axes.
    pub gap_direction: [f32; 3],
    /// The bins that were seen.
    pub seen: Seen,
}

impl Coverage {
    /// The side of the board through which the field has not been seen yet (x front, y right, z bottom).
    pub fn missing_side(&self) -> &'static str {
        side_name(self.gap_direction)
    }
}

/// The row and the place of a unit vector.
#[inline]
fn cell([x, y, z]: [f32; 3]) -> (usize, usize) {
    let height = z.abs();
    // Halving, written out: this runs for each of some hundred cells of a sketch.
    let before_row = |row: usize| height <= ROW_ENDS[row % ROW_ENDS.len()];
    let mut from_pole = if before_row(3) { 4 } else { 0 };
    from_pole += if before_row(from_pole + 1) { 2 } else { 0 };
    from_pole += if before_row(from_pole) { 1 } else { 0 };
    let row = if z >= 0.0 { from_pole } else { ROWS - 1 - from_pole };
    let (ax, ay) = (x.abs(), y.abs());
    let (less, more) = if ax >= ay { (ay, ax) } else { (ax, ay) };
    let beyond_place = |place: usize| less > PLACE_ENDS[place % PLACE_ENDS.len()] * more;
    let mut step = if beyond_place(1) { 2 } else { 0 };
    step += if beyond_place(step) { 1 } else { 0 };
    let in_quarter = if ax >= ay { step } else { PLACES / 4 - 1 - step };
    let in_half = if x >= 0.0 { in_quarter } else { PLACES / 2 - 1 - in_quarter };
    (row, if y >= 0.0 { in_half } else { PLACES - 1 - in_half })
}

/// `1/√v` for a positive, finite number, right to 5e-6: the exponent halved by an integer subtraction, then two of Newton's
/// steps. A direction needs no more, and a square root of the library costs ten times as much.
#[inline]
fn inverse_root(v: f32) -> f32 {
    let mut y = f32::from_bits(0x5f37_59df - (v.to_bits() >> 1));
    for _ in 0..2 {
        y *= 1.5 - 0.5 * v * y * y;
    }
    y
}

impl CoverageMap {
    /// An empty map.
    #[inline]
    pub const fn new() -> Self {
        Self { bins: Seen(0), seen: [0; ROWS], directions: [[0; 3]; ROWS * PLACES] }
    }

    /// Adds the direction of a corrected vector; its length does not matter. Zero and non-finite vectors are left out.
    #[inline]
    pub fn add(&mut self, corrected: [f32; 3]) {
        let [x, y, z] = corrected;
        let square = x * x + y * y + z * z;
        if !(square >= f32::MIN_POSITIVE && square.is_finite()) {
            return;
        }
        let per_length = inverse_root(square);
        let u = [x * per_length, y * per_length, z * per_length];
        let (row, place) = cell(u);
        let slice = (((u[2] + 1.0) * (0.5 * SLICES as f32)) as usize).min(SLICES - 1);
        self.bins = self.bins.with(slice, place / (PLACES / SECTORS));
        let Some(seen) = self.seen.get_mut(row) else { return };
        if *seen & (1 << place) == 0
            && let Some(direction) = self.directions.get_mut(row * PLACES + place)
        {
            *seen |= 1 << place;
            // By way of an i32, which is one instruction.
            let kept = |v: f32| (v * UNIT) as i32 as i16;
            *direction = [kept(u[0]), kept(u[1]), kept(u[2])];
        }
    }

    /// Cosine of the angle from a unit vector to the nearest direction seen; any that is not less than `enough` will do.
    fn nearest(&self, probe: [f32; 3], enough: f32) -> f32 {
        let (row, place) = cell(probe);
        let mut best = -1.0;
        for (away, reach) in REACH.into_iter().enumerate() {
            if best >= reach || best >= enough {
                break;
            }
            if let Some(above) = row.checked_sub(away) {
                best = self.nearest_in_row(above, place, probe, best);
            }
            if away > 0 {
                best = self.nearest_in_row(row + away, place, probe, best);
            }
        }
        best
    }

    /// The same in one row, or `best` if that is nearer. On either side it is the place next to the probe's own.
    #[inline]
    fn nearest_in_row(&self, row: usize, place: usize, probe: [f32; 3], best: f32) -> f32 {
        let Some(seen) = self.seen.get(row) else { return best };
        let around = seen.rotate_right(place as u32);
        if around == 0 {
            return best;
        }
        let onward = place + around.trailing_zeros() as usize;
        let back = place + PLACES - 1 - around.leading_zeros() as usize;
        [onward, back]
            .into_iter()
            .filter_map(|place| self.directions.get(row * PLACES + place % PLACES))
            .fold(best, |best, seen| {
                let cosine = f32::from(seen[0]) * probe[0]
                    + f32::from(seen[1]) * probe[1]
                    + f32::from(seen[2]) * probe[2];
                best.max(cosine * (1.0 / UNIT))
            })
    }

    /// Coverage and largest gap so far.
    pub fn coverage(&self) -> Coverage {
        if self.bins.count() == 0 {
            return Coverage {
                fraction: 0.0,
                gap_deg: 180.0,
                gap_direction: [0.0, 0.0, 1.0],
                seen: Seen::default(),
            };
        }
        let mut worst = (1.0f32, [0.0f32, 0.0, 1.0]);
        for probe in Probes::new().take(PROBES) {
            let cosine = self.nearest(probe, worst.0);
            if cosine < worst.0 {
                worst = (cosine, probe);
            }
        }
        Coverage {
            fraction: self.bins.count() as f32 / BINS as f32,
            gap_deg: math::acosf(worst.0).to_degrees(),
            gap_direction: worst.1,
            seen: self.bins,
        }
    }
}

/// The probes, each [`PROBE_STRIDE`] after the last: a Fibonacci lattice, evenly spread. Computed as they come: a table would take 2 KB.
struct Probes {
    number: usize,
    /// Cosine and sine of the probe's turn about z.
    turn: [f32; 2],
}

impl Probes {
    const fn new() -> Self {
        Self { number: 0, turn: [1.0, 0.0] }
    }
}

/// Cosine and sine of so many golden angles. The rotation is repeated, since a sine is not const.
const fn golden_turns(count: usize, backwards: bool) -> [f32; 2] {
    const COS: f64 = -0.737_368_878_078_319_9;
    const SIN: f64 = 0.675_490_294_261_523_8;
    let (mut c, mut s) = (1.0f64, 0.0f64);
    let mut i = 0;
    while i < count {
        (c, s) = (c * COS - s * SIN, s * COS + c * SIN);
        i += 1;
    }
    [c as f32, if backwards { -s as f32 } else { s as f32 }]
}

impl Iterator for Probes {
    type Item = [f32; 3];

    #[inline]
    fn next(&mut self) -> Option<[f32; 3]> {
        const ONWARD: [f32; 2] = golden_turns(PROBE_STRIDE, false);
        const BACK: [f32; 2] = golden_turns(PROBES - PROBE_STRIDE, true);
        self.number += PROBE_STRIDE;
        let mut step = ONWARD;
        if self.number >= PROBES {
            self.number -= PROBES;
            step = BACK;
        }
        let [c, s] = self.turn;
        self.turn = [c * step[0] - s * step[1], s * step[0] + c * step[1]];
        let z = 1.0 - (2 * self.number + 1) as f32 * (1.0 / PROBES as f32);
        let square = 1.0 - z * z;
        let r = square * inverse_root(square);
        Some([r * self.turn[0], r * self.turn[1], z])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibration::norm;

    fn probes() -> [[f32; 3]; PROBES] {
        let mut all = Probes::new();
        core::array::from_fn(|_| all.next().unwrap())
    }

    #[test]
    fn probes_are_unit_vectors_all_over_the_sphere() {
        let probes = probes();
        for p in probes {
            assert!((norm(p) - 1.0).abs() < 3e-5);
        }
        // Once around: the first comes again.
        assert!(Probes::new().nth(PROBES).is_some_and(|p| (p[0] - probes[0][0]).abs() < 3e-5));
        // Each probe's nearest other probe is 10 … 22° away.
        for (i, p) in probes.iter().enumerate() {
            let best = probes
                .iter()
                .enumerate()
                .filter(|(j, _)| *j != i)
                .map(|(_, q)| p[0] * q[0] + p[1] * q[1] + p[2] * q[2])
                .fold(-1.0f32, f32::max);
            assert!((0.92..0.985).contains(&best), "{i}: {best}");
        }
    }

    #[test]
    fn rows_and_places_are_where_their_angles_say() {
        for i in 0..4000 {
            let z = 1.0 - (2.0 * f64::from(i) + 1.0) / 4000.0;
            let (r, turn) = (math::sqrt(1.0 - z * z), f64::from(i) * 2.4);
            let u = [(r * math::cos(turn)) as f32, (r * math::sin(turn)) as f32, z as f32];
            let degrees = |v: f64| v.to_degrees() / 11.25;
            let row = degrees(math::acos(u[2].into()));
            let place = degrees(math::atan2(u[1].into(), u[0].into())).rem_euclid(32.0);
            let (found_row, found_place) = cell(u);
            let near = |exact: f64, found: usize| (exact - found as f64 - 0.5).abs() < 0.5 + 1e-4;
            assert!(near(row, found_row) && near(place, found_place), "{u:?}: {row} {place} {:?}", cell(u));
            assert!((inverse_root(1e-3 + u[0] * u[0]) * math::sqrtf(1e-3 + u[0] * u[0]) - 1.0).abs() < 1e-5);
        }
    }

    #[test]
    fn half_a_sphere_is_half_covered_and_names_the_missing_side() {
        // The axis and the sign of the half that was seen.
        let sides = [
            (2, 1.0, "top"),
            (2, -1.0, "bottom"),
            (0, 1.0, "back"),
            (0, -1.0, "front"),
            (1, 1.0, "left"),
            (1, -1.0, "right"),
        ];
        for (axis, sign, missing) in sides {
            let mut map = CoverageMap::new();
            for p in probes().iter().filter(|p| p[axis] * sign > 0.0) {
                map.add(p.map(|v| 48.0 * v));
            }
            let c = map.coverage();
            assert!((c.fraction - 0.5).abs() < 0.08, "{missing}: {}", c.fraction);
            assert!((c.gap_deg - 90.0).abs() < 12.0, "{missing}: {}", c.gap_deg);
            assert_eq!(c.missing_side(), missing);
        }
    }

    #[test]
    fn one_direction_leaves_half_a_turn_and_none_leaves_all() {
        let mut map = CoverageMap::new();
        assert_eq!((map.coverage().fraction, map.coverage().gap_deg), (0.0, 180.0));
        map.add([0.0; 3]);
        map.add([f32::NAN, 0.0, 1.0]);
        map.add([f32::INFINITY, 0.0, 1.0]);
        assert_eq!(map.coverage().fraction, 0.0);
        map.add([0.0, 0.0, -1e-3]);
        let c = map.coverage();
        assert!(c.gap_deg > 170.0 && c.fraction == 1.0 / BINS as f32, "{c:?}");
        assert_eq!(c.missing_side(), "bottom");
    }
}
