//! The accumulator's sums are exact: equal, bit for bit, to 128-bit arithmetic, in any order and in any grouping.

use ironout::moments::{Moments, Normalisation};
use ironout::monomial::EXPONENTS;
use proptest::prelude::*;

/// All 35 sums in 128-bit integers, straight from their definition.
fn direct(samples: &[[i16; 3]]) -> [i128; 35] {
    EXPONENTS.map(|e| {
        samples.iter().map(|s| (0..3).map(|a| i128::from(s[a]).pow(e[a].into())).product::<i128>()).sum()
    })
}

fn pushed(samples: &[[i16; 3]]) -> Moments {
    let mut moments = Moments::new();
    samples.iter().for_each(|s| moments.push(*s));
    moments
}

/// A mixture of any counts, the extremes among them, and the field of a board.
fn counts() -> impl Strategy<Value = i16> {
    prop_oneof![
        3 => any::<i16>(),
        1 => Just(i16::MIN),
        1 => Just(i16::MAX),
        1 => prop_oneof![Just(0i16), Just(1), Just(-1)],
        2 => -700i16..700,
    ]
}

fn log(most: usize) -> impl Strategy<Value = Vec<[i16; 3]>> {
    prop::collection::vec([counts(), counts(), counts()], 0..most)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, ..ProptestConfig::default() })]

    #[test]
    fn sums_are_those_of_128_bit_integers(samples in log(400)) {
        let moments = pushed(&samples);
        prop_assert_eq!(moments.sums(), direct(&samples));
        prop_assert_eq!(moments.count(), samples.len() as u64);
        for (e, sum) in EXPONENTS.iter().zip(direct(&samples)) {
            prop_assert_eq!(moments.sum(e[0].into(), e[1].into(), e[2].into()), Some(sum));
        }
        prop_assert_eq!(moments.sum(5, 0, 0), None);
        prop_assert_eq!(moments.sum(2, 2, 1), None);
    }

    #[test]
    fn sums_that_were_sent_go_on(samples in log(200), more in log(50)) {
        let mut sent = Moments::from_sums(&pushed(&samples).sums()).expect("sums of samples");
        prop_assert_eq!(sent.sums(), direct(&samples));
        more.iter().for_each(|sample| sent.push(*sample));
        prop_assert_eq!(sent.sums(), direct(&[samples, more].concat()));
    }

    #[test]
    fn order_does_not_matter(samples in log(100), turn in 0usize..100) {
        let mut other = samples.clone();
        other.reverse();
        if !other.is_empty() {
            let turn = turn % other.len();
            other.rotate_left(turn);
        }
        prop_assert_eq!(pushed(&samples).sums(), pushed(&other).sums());
    }

    #[test]
    fn merging_is_pushing_and_associative(a in log(60), b in log(60), c in log(60)) {
        let merged = |parts: &[&Moments]| {
            let mut out = Moments::new();
            for part in parts {
                assert!(out.merge(part));
            }
            out
        };
        let (ma, mb, mc) = (pushed(&a), pushed(&b), pushed(&c));
        let left = merged(&[&merged(&[&ma, &mb]), &mc]);
        let right = merged(&[&ma, &merged(&[&mb, &mc])]);
        let all: Vec<[i16; 3]> = a.iter().chain(&b).chain(&c).copied().collect();
        prop_assert_eq!(left.sums(), direct(&all));
        prop_assert_eq!(right.sums(), direct(&all));
        prop_assert!(left == right);
        // A merged accumulator goes on counting as exactly.
        let mut further = left;
        all.iter().for_each(|s| further.push(*s));
        prop_assert_eq!(further.sums(), direct(&all).map(|sum| 2 * sum));
    }

    #[test]
    fn normal_matrices_are_those_of_the_rows(samples in log(80)) {
        let moments = pushed(&samples);
        for reading in [Normalisation::Constant, Normalisation::Trace] {
            let mut dtd = [[0i128; 9]; 9];
            let mut dth = [0i128; 9];
            for s in &samples {
                let [x, y, z] = s.map(i128::from);
                let (row, left) = match reading {
                    // Eq. (13), and the constant 1 for Ĥ².
                    Normalisation::Constant => ([x * x, x, y * y, y, z * z, z, x * y, z * y, x * z], 1),
                    Normalisation::Trace => (
                        [
                            x * x + y * y - 2 * z * z,
                            x * x + z * z - 2 * y * y,
                            2 * x * y,
                            2 * x * z,
                            2 * y * z,
                            2 * x,
                            2 * y,
                            2 * z,
                            1,
                        ],
                        x * x + y * y + z * z,
                    ),
                };
                for i in 0..9 {
                    dth[i] += row[i] * left;
                    for j in 0..9 {
                        dtd[i][j] += row[i] * row[j];
                    }
                }
            }
            let normal = moments.normal_matrix(reading);
            // Each entry is the exact integer, rounded once.
            prop_assert_eq!(normal.dtd, dtd.map(|row| row.map(|v| v as f64)));
            prop_assert_eq!(normal.dth, dth.map(|v| v as f64));
        }
    }
}

#[test]
fn carries_are_exact_over_hundreds_of_thousands_of_full_scale_samples() {
    // Past several carries of the cubic sums, which come once in 65 536 samples.
    for (sample, n) in
        [([i16::MIN; 3], 300_007u32), ([i16::MAX; 3], 200_003), ([i16::MIN, i16::MAX, i16::MIN], 131_079)]
    {
        let mut moments = Moments::new();
        for _ in 0..n {
            moments.push(sample);
        }
        assert_eq!(moments.sums(), direct(&[sample]).map(|sum| sum * i128::from(n)));
    }
}

#[test]
fn doubling_to_two_to_the_31_full_scale_samples_is_exact_and_one_more_is_refused() {
    for sample in [[i16::MIN; 3], [i16::MAX, i16::MIN, i16::MAX]] {
        let one = direct(&[sample]);
        let mut moments = pushed(&[sample]);
        for doubling in 1..=31u32 {
            let copy = moments;
            assert!(moments.merge(&copy));
            assert_eq!(moments.sums(), one.map(|sum| sum << doubling), "2^{doubling} samples");
        }
        // 2³² samples are one more than the counter holds: refused, and nothing changed.
        let copy = moments;
        assert!(!moments.merge(&copy));
        assert!(moments == copy);
        // 2³² − 1 fit, and are the end.
        let mut rest = Moments::new();
        for power in 0..31u32 {
            let mut part = pushed(&[sample]);
            for _ in 0..power {
                let copy = part;
                assert!(part.merge(&copy));
            }
            assert!(rest.merge(&part));
        }
        assert_eq!(rest.count(), (1 << 31) - 1);
        assert!(moments.merge(&rest));
        assert_eq!(moments.count(), u64::from(Moments::CAPACITY));
        let full = one.map(|sum| sum * i128::from(u32::MAX));
        assert_eq!(moments.sums(), full);
        moments.push(sample);
        assert_eq!(moments.sums(), full, "a push beyond the capacity is left out");
    }
}

#[test]
fn an_emptied_accumulator_is_a_new_one() {
    let mut moments = pushed(&[[1, 2, 3], [-4, 5, i16::MIN]]);
    assert!(moments != Moments::new());
    moments.clear();
    assert!(moments == Moments::new());
    assert_eq!(moments.sums(), [0; 35]);
}

#[test]
fn sums_that_no_samples_have_are_refused() {
    let mut sums = pushed(&[[1, 2, 3]]).sums();
    sums[20] = 1 << 61;
    assert!(Moments::from_sums(&sums).is_none());
    sums[0] = -1;
    assert!(Moments::from_sums(&sums).is_none());
    sums[0] = 1 << 32;
    assert!(Moments::from_sums(&sums).is_none());
}
