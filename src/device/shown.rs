//! What a board with more than one light shows: a ring of eight as a compass of what was seen, a matrix of 25 as a map of it.
//!
//! While a calibration is collected, each light stands for a part of the directions from which the field can come, in the board's
//! axes: it is on once most of its part was seen, and blinks once some of it was. With a calibration in use and an accelerometer the
//! lights point north. Everything else is the one light's pattern on all of them, or a picture.

use super::light::Light;
use crate::coverage::Seen;

/// Slices of the coverage from the top of the board to the bottom, and sectors of an eighth of a turn.
const SLICES: usize = 6;
const SECTORS: usize = 8;

/// What is to be shown now.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shown {
    /// What it is about.
    pub light: Light,
    /// Whether a single light is on: the pattern of [`Light`].
    pub is_on: bool,
    /// While collecting: the directions that were seen, as of the last look at them.
    pub seen: Seen,
    /// The heading of the board's front, degrees clockwise from north, where it is known.
    pub heading_deg: Option<f32>,
}

/// How much of a light's part was seen.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Part {
    Nothing,
    Some,
    Most,
}

impl Shown {
    /// The ring: bit 0 is the light at the front, the others follow clockwise as seen from above.
    pub fn ring(&self) -> u8 {
        match (self.light, self.heading_deg) {
            (Light::Collecting, _) => {
                // The lights of an empty ring blink, so that it is not taken for one that is off.
                if self.seen.count() == 0 {
                    return if self.is_on { 0b0001_0001 } else { 0 };
                }
                (0..SECTORS).fold(0, |ring, place| {
                    ring | u8::from(self.lit(self.part(0..SLICES, &around(place)))) << place
                })
            }
            (Light::Calibrated, Some(heading_deg)) => 1 << eighth(-heading_deg, SECTORS),
            // Not all eight: that would be bright, and looks like a ring that is full.
            (Light::Refused | Light::SensorFault, _) => {
                if self.is_on {
                    0b0101_0101
                } else {
                    0
                }
            }
            _ => {
                if self.is_on {
                    0xff
                } else {
                    0
                }
            }
        }
    }

    /// The matrix: five rows from the front back, bit 0 of each the light on the left. The middle stands for the bottom of the board,
    /// the eight around it for its sides, the sixteen at the rim for its top.
    pub fn matrix(&self) -> [u8; 5] {
        match (self.light, self.heading_deg) {
            (Light::Collecting, _) => self.map(),
            (Light::Calibrated, Some(heading_deg)) => {
                let mut rows = [0, 0, 0b00100, 0, 0];
                light_up(&mut rows, RIM.get(eighth(-heading_deg, RIM.len())));
                rows
            }
            (light, _) if self.is_on => match light {
                Light::SensorFault => [0b00100, 0b00100, 0b00100, 0b00000, 0b00100],
                Light::Refused => [0b10001, 0b01010, 0b00100, 0b01010, 0b10001],
                Light::Solved => [0b00000, 0b10000, 0b01000, 0b00101, 0b00010],
                Light::Calibrated => [0b01110, 0b10001, 0b10001, 0b10001, 0b01110],
                Light::Uncalibrated | Light::Collecting => [0, 0, 0b00100, 0, 0],
            },
            _ => [0; 5],
        }
    }

    fn map(&self) -> [u8; 5] {
        let mut rows = [0; 5];
        if self.seen.count() == 0 {
            // As with the ring.
            return if self.is_on { [0b10001, 0, 0, 0, 0b10001] } else { rows };
        }
        let all: [usize; SECTORS] = core::array::from_fn(|sector| sector);
        if self.lit(self.part(5..6, &all)) {
            light_up(&mut rows, Some(&(2, 2)));
        }
        for (place, light) in INNER.iter().enumerate() {
            if self.lit(self.part(3..5, &around(place))) {
                light_up(&mut rows, Some(light));
            }
        }
        for (place, light) in RIM.iter().enumerate() {
            // Between two sectors the middle slices, within one its column up to the top.
            let part = if place % 2 == 0 {
                self.part(1..3, &around(place / 2))
            } else {
                self.part(0..3, &[place / 2])
            };
            if self.lit(part) {
                light_up(&mut rows, Some(light));
            }
        }
        rows
    }

    fn part(&self, slices: core::ops::Range<usize>, sectors: &[usize]) -> Part {
        let all = slices.len() * sectors.len();
        let seen = slices
            .flat_map(|slice| sectors.iter().filter(move |&&sector| self.seen.has(slice, sector)))
            .count();
        match seen {
            0 => Part::Nothing,
            _ if 3 * seen >= 2 * all => Part::Most,
            _ => Part::Some,
        }
    }

    fn lit(&self, part: Part) -> bool {
        part == Part::Most || (part == Part::Some && self.is_on)
    }
}

/// The two sectors that meet at this eighth of a turn from the front.
const fn around(place: usize) -> [usize; 2] {
    [(place + SECTORS - 1) % SECTORS, place % SECTORS]
}

/// The place nearest to an angle clockwise from the front, of `count` around.
fn eighth(angle_deg: f32, count: usize) -> usize {
    let part = 360.0 / count as f32;
    // From minus to plus two turns; a number that is none is the front.
    let turned = (angle_deg + 720.0) / part + 0.5;
    turned as usize % count
}

/// Row and column of the lights around the middle, from the front clockwise.
const INNER: [(usize, u8); 8] = [(1, 2), (1, 3), (2, 3), (3, 3), (3, 2), (3, 1), (2, 1), (1, 1)];
/// And of those at the rim.
const RIM: [(usize, u8); 16] = [
    (0, 2),
    (0, 3),
    (0, 4),
    (1, 4),
    (2, 4),
    (3, 4),
    (4, 4),
    (4, 3),
    (4, 2),
    (4, 1),
    (4, 0),
    (3, 0),
    (2, 0),
    (1, 0),
    (0, 0),
    (0, 1),
];

fn light_up(rows: &mut [u8; 5], light: Option<&(usize, u8)>) {
    if let Some((row, column)) = light
        && let Some(row) = rows.get_mut(*row)
    {
        *row |= 1 << column;
    }
}

#[cfg(test)]
mod tests {
    use super::{INNER, Light, RIM, SECTORS, SLICES, Shown};
    use crate::coverage::Seen;

    fn shown(light: Light, is_on: bool) -> Shown {
        Shown { light, is_on, seen: Seen::default(), heading_deg: None }
    }

    fn collecting(seen: Seen, is_on: bool) -> Shown {
        Shown { seen, ..shown(Light::Collecting, is_on) }
    }

    fn all() -> Seen {
        let bins = (0..SLICES).flat_map(|slice| (0..SECTORS).map(move |sector| (slice, sector)));
        bins.fold(Seen::default(), |seen, (slice, sector)| seen.with(slice, sector))
    }

    #[test]
    fn every_light_has_its_place_and_every_direction_its_light() {
        let mut places: [u8; 5] = [0; 5];
        places[2] |= 1 << 2;
        for (row, column) in INNER.into_iter().chain(RIM) {
            assert_eq!(places[row] & 1 << column, 0, "{row} {column} twice");
            places[row] |= 1 << column;
        }
        assert_eq!(places, [0b11111; 5]);
        assert_eq!(collecting(all(), false).matrix(), [0b11111; 5]);
        assert_eq!(collecting(all(), false).ring(), 0xff);
        for slice in 0..SLICES {
            for sector in 0..SECTORS {
                let one = Seen::default().with(slice, sector);
                assert_ne!(collecting(one, true).matrix(), [0; 5], "{slice} {sector} is not shown");
                let ring = collecting(one, true).ring();
                assert_eq!(ring, 1 << sector | 1 << ((sector + 1) % 8), "{slice} {sector}");
                assert_eq!(collecting(one, false).ring(), 0, "one of twelve is some, not most");
            }
        }
    }

    #[test]
    fn the_front_half_lights_the_front_of_the_ring_and_of_the_matrix() {
        // Sectors 6 and 7 are left of the front, 0 and 1 right of it.
        let bins = (0..SLICES).flat_map(|slice| [6, 7, 0, 1].map(move |sector| (slice, sector)));
        let seen = bins.fold(Seen::default(), |seen, (slice, sector)| seen.with(slice, sector));
        let ring = collecting(seen, false).ring();
        assert_eq!(ring, 0b1000_0011, "front, front right, front left are full; right and left half");
        assert_eq!(collecting(seen, true).ring(), 0b1100_0111);
        let [first, .., last] = collecting(seen, false).matrix();
        assert_eq!((first, last), (0b11111, 0));
    }

    #[test]
    fn north_is_where_the_heading_says() {
        for (heading_deg, place) in
            [(0.0, 0), (90.0, 6), (45.0, 7), (180.0, 4), (359.0, 0), (270.0, 2), (20.0, 0)]
        {
            let shown = Shown { heading_deg: Some(heading_deg), ..shown(Light::Calibrated, true) };
            assert_eq!(shown.ring(), 1 << place, "{heading_deg}");
        }
        let east = Shown { heading_deg: Some(90.0), ..shown(Light::Calibrated, true) };
        assert_eq!(east.matrix(), [0, 0, 0b00101, 0, 0], "north is on the left");
        let none = Shown { heading_deg: Some(f32::NAN), ..shown(Light::Calibrated, true) };
        assert_eq!(none.ring(), 1);
    }

    #[test]
    fn states_differ_and_what_blinks_goes_dark() {
        let states =
            [Light::SensorFault, Light::Refused, Light::Solved, Light::Uncalibrated, Light::Calibrated];
        for (index, light) in states.into_iter().enumerate() {
            assert_eq!(shown(light, false).matrix(), [0; 5], "{light:?}");
            assert_eq!(shown(light, false).ring(), 0, "{light:?}");
            assert_ne!(shown(light, true).ring(), 0);
            for other in &states[..index] {
                assert_ne!(shown(light, true).matrix(), shown(*other, true).matrix(), "{light:?} {other:?}");
            }
        }
        assert_ne!(collecting(Seen::default(), true).matrix(), [0; 5]);
    }
}
