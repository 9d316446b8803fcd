//! `cargo additions-accuracy`: the part of `cargo accuracy` about irrelevant effects alone.
use ironout_host_tests::accuracy::irrelevant::{ADDITIONS, CASES, trials};
fn main() {
    let from: u64 = std::env::args().nth(1).and_then(|a| a.parse().ok()).unwrap_or(1);
    let to: u64 = std::env::args().nth(2).and_then(|a| a.parse().ok()).unwrap_or(1);
    for seed in from..=to {
        for case in &CASES {
            for t in trials(case, seed, &ADDITIONS) {
                println!("{seed}|{}|{:?}|{}|{}|{}|{}|{:.5}|{:.5}|{:.4}|{:.4}|{:.4}|{:.4}|{:.4}|{:.4}|{:.5}|{:.5}", case.hidden, case.motion, case.without, t.addition, t.irrelevant as u8, t.plain.accepted as u8 * 10 + t.with.accepted as u8, t.plain.predicted, t.with.predicted, t.plain.rms_ut, t.with.rms_ut, t.plain.holdout_ut, t.with.holdout_ut, t.plain.unseen_ut, t.with.unseen_ut, t.plain.error, t.with.error);
            }
        }
    }
}
