//! The sphere of directions in tiles of equal area: which the field was seen through, and where none was.

use ironout::coverage::{CoverageMap, SECTORS, SLICES, side_name};
use serde::Serialize;

/// The tiles, slice after slice from −z (the top side) to +z, sector after sector from +x by way of +y.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Tiles {
    /// Slices of equal height.
    pub slices: usize,
    /// Sectors in each.
    pub sectors: usize,
    /// Samples in each tile.
    pub samples: Vec<u32>,
    /// The side of the board that each tile is on.
    pub sides: Vec<&'static str>,
    /// Covered share of the tiles.
    pub coverage: f64,
    /// Largest angle from any direction to the nearest that was seen, degrees.
    pub gap_deg: f64,
    /// The side of the board through the middle of that gap.
    pub gap_side: &'static str,
}

/// Of corrected vectors, in body axes.
pub fn tiles(corrected_ut: &[[f64; 3]]) -> Tiles {
    let mut map = CoverageMap::new();
    let mut samples = vec![0_u32; SLICES * SECTORS];
    for v in corrected_ut {
        map.add(v.map(|value| value as f32));
        let length = v.iter().map(|value| value * value).sum::<f64>().sqrt();
        if !(length > 0.0 && length.is_finite()) {
            continue;
        }
        let slice = (((v[2] / length + 1.0) * 0.5 * SLICES as f64) as usize).min(SLICES - 1);
        let turn = v[1].atan2(v[0]).rem_euclid(std::f64::consts::TAU) / std::f64::consts::TAU;
        let sector = ((turn * SECTORS as f64) as usize).min(SECTORS - 1);
        if let Some(count) = samples.get_mut(slice * SECTORS + sector) {
            *count += 1;
        }
    }
    let coverage = map.coverage();
    let middle = |tile: usize| {
        let z = ((tile / SECTORS) as f64 + 0.5) * 2.0 / SLICES as f64 - 1.0;
        let angle = ((tile % SECTORS) as f64 + 0.5) / SECTORS as f64 * std::f64::consts::TAU;
        let level = (1.0 - z * z).sqrt();
        [level * angle.cos(), level * angle.sin(), z].map(|value| value as f32)
    };
    Tiles {
        slices: SLICES,
        sectors: SECTORS,
        sides: (0..samples.len()).map(|tile| side_name(middle(tile))).collect(),
        samples,
        coverage: f64::from(coverage.fraction),
        gap_deg: f64::from(coverage.gap_deg),
        gap_side: coverage.missing_side(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_agree_with_the_core() {
        let half: Vec<[f64; 3]> = (0..2000)
            .map(|i| {
                let (z, a) = (f64::from(i) / 2000.0, f64::from(i) * 2.4);
                let level = (1.0 - z * z).sqrt();
                [48.0 * level * a.cos(), 48.0 * level * a.sin(), 48.0 * z]
            })
            .collect();
        let tiles = tiles(&half);
        let lit = tiles.samples.iter().filter(|count| **count > 0).count();
        assert!((tiles.coverage - lit as f64 / tiles.samples.len() as f64).abs() < 1e-6);
        assert_eq!((lit, tiles.gap_side), (24, "top"));
        assert!((80.0..=91.0).contains(&tiles.gap_deg), "{}", tiles.gap_deg);
        assert_eq!(tiles.samples.iter().sum::<u32>(), 2000);
    }
}
