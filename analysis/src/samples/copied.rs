//! Readings that a log holds twice: a file that was joined to itself, a buffer that was written again. They say nothing new, however
//! often they are there, and whatever the time next to them is.

use std::collections::HashMap;

/// So many readings in a row, ...
const WINDOW: usize = 16;
/// ... so many of them different, are the same again only where they were copied.
const DIFFERENT: usize = 12;
/// So many bits of chance a run of equal readings holds, if it is a copy: in coarse steps a board that turns evenly comes by the same
/// readings again.
const LEAST_BITS: f64 = 60.0;
/// A reading that goes on by one step at most is foretold by the ones before; of many such, some are not.
const BITS_OF_ONE_STEP: f64 = 0.25;
/// One window of so many is looked up, chosen by what it holds: the same ones in a copy.
const ONE_OF: u64 = 8;

/// The readings, as first and last of each run, that are a copy of earlier ones.
pub fn copied(readings: &[[f64; 3]]) -> Vec<(usize, usize)> {
    const BASE: u64 = 0x9e37_79b9_7f4a_7c15;
    let hash = |reading: &[f64; 3]| {
        let bits = reading.map(f64::to_bits);
        bits.iter().fold(0_u64, |hash, word| mix(hash ^ word))
    };
    if readings.len() < 2 * WINDOW {
        return Vec::new();
    }
    let oldest = (1..WINDOW).fold(1_u64, |power, _| power.wrapping_mul(BASE));
    let mut rolling = readings[..WINDOW - 1]
        .iter()
        .fold(0_u64, |rolling, reading| rolling.wrapping_mul(BASE).wrapping_add(hash(reading)));
    let mut seen: HashMap<u64, usize> = HashMap::new();
    let mut runs: Vec<(usize, usize)> = Vec::new();
    for from in 0..=readings.len() - WINDOW {
        rolling = rolling.wrapping_mul(BASE).wrapping_add(hash(&readings[from + WINDOW - 1]));
        let window = mix(rolling);
        rolling = rolling.wrapping_sub(hash(&readings[from]).wrapping_mul(oldest));
        let is_known = runs.last().is_some_and(|(_, last)| from + WINDOW <= last + 1);
        if !window.is_multiple_of(ONE_OF) || is_known {
            continue;
        }
        let Some(&earlier) = seen.get(&window) else {
            seen.insert(window, from);
            continue;
        };
        if earlier + WINDOW > from || !is_telling(&readings[from..from + WINDOW]) {
            continue;
        }
        let begins = runs.last().map_or(0, |(_, last)| last + 1);
        let before = (0..from - begins.min(from))
            .take_while(|&by| by < earlier && readings[from - 1 - by] == readings[earlier - 1 - by]);
        let first = from - before.count();
        let after = (from..readings.len()).take_while(|&at| readings[at] == readings[earlier + at - from]);
        let length = after.count();
        if length >= WINDOW && bits(&readings[from..from + length]) >= LEAST_BITS {
            runs.push((first, from + length - 1));
        }
    }
    runs
}

/// Whether so many readings differ that no chance repeats them.
fn is_telling(window: &[[f64; 3]]) -> bool {
    let mut words: Vec<[u64; 3]> = window.iter().map(|reading| reading.map(f64::to_bits)).collect();
    words.sort_unstable();
    words.dedup();
    words.len() >= DIFFERENT
}

/// How much the readings of a run leave open, each after the one before: how many steps of an axis it might have gone.
fn bits(run: &[[f64; 3]]) -> f64 {
    let ways = |axis: usize| run.windows(2).map(move |pair| (pair[1][axis] - pair[0][axis]).abs());
    let of_axis = |axis: usize| {
        let step = ways(axis).filter(|way| *way > 0.0).fold(f64::INFINITY, f64::min);
        ways(axis).map(|way| (way / step).max(1.0).log2()).sum::<f64>()
    };
    (0..3).map(of_axis).sum::<f64>() + BITS_OF_ONE_STEP * run.len() as f64
}

/// The end of MurmurHash3, which mixes every bit with every other.
fn mix(mut word: u64) -> u64 {
    word = (word ^ (word >> 33)).wrapping_mul(0xff51_afd7_ed55_8ccd);
    word = (word ^ (word >> 33)).wrapping_mul(0xc4ce_b9fe_1a85_ec53);
    word ^ (word >> 33)
}

#[cfg(test)]
mod tests {
    use super::copied;

    fn readings(from: u64, count: u64) -> Vec<[f64; 3]> {
        (from..from + count).map(|i| [0, 1, 2].map(|axis| (super::mix(3 * i + axis) % 1000) as f64)).collect()
    }

    #[test]
    fn a_copy_is_found_whole_wherever_it_is() {
        let log = readings(0, 500);
        assert_eq!(copied(&log), []);
        let twice = [log.clone(), log.clone(), log.clone()].concat();
        assert_eq!(copied(&twice), [(500, 1499)]);
        let part = [log.clone(), readings(9000, 37), log[100..300].to_vec(), readings(7000, 20)].concat();
        assert_eq!(copied(&part), [(537, 736)]);
        // Two values in turn, as a resting board's counts, are no copy.
        let coarse: Vec<[f64; 3]> = (0..400).map(|i| [f64::from(i % 2), 1.0, 2.0]).collect();
        assert_eq!(copied(&coarse), []);
        assert_eq!(copied(&log[..10]), []);
    }

    /// A board that turns evenly, in steps that hide the noise: the same readings again are not a copy, and in fine steps a copy is found.
    #[test]
    fn turns_in_coarse_steps_are_no_copies() {
        let turns = |step: f64| -> Vec<[f64; 3]> {
            let angle = |i: u64| i as f64 * std::f64::consts::TAU / 600.0;
            let noise = |i: u64, axis: u64| 0.08 * ((super::mix(3 * i + axis) % 1000) as f64 / 500.0 - 1.0);
            let reading = |i: u64| {
                let exact = [48.0 * angle(i).cos(), 48.0 * angle(i).sin(), 20.0 * (2.0 * angle(i)).sin()];
                [0, 1, 2].map(|axis| ((exact[axis] + noise(i, axis as u64)) / step).round() * step)
            };
            let mut all: Vec<[f64; 3]> = (0..6000).map(reading).collect();
            all.dedup();
            all
        };
        for step in [2.0, 3.4, 5.0] {
            let found = copied(&turns(step));
            assert!(found.is_empty(), "{step}: {found:?}");
        }
        let fine = turns(0.01);
        assert_eq!(copied(&fine), []);
        assert_eq!(copied(&[fine.clone(), fine[..300].to_vec()].concat()), [(fine.len(), fine.len() + 299)]);
    }
}
