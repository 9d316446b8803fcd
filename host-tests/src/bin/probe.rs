//! tmp
use ironout::fit::Method;
use ironout_host_tests::accuracy::{attitude::Motion, gates, log::Log, solvers::Solver};
fn main() {
    let mut r = [vec![], vec![], vec![]];
    for seed in 0..4000u64 {
        let log = Log::draw(0x11a1 + seed, |s| Motion::limited(seed as usize, s));
        let j = gates::judge(&log, Solver::Ironout(Method::Adjusted));
        if let (Some(e), Some(p)) = (j.error, j.predicted) {
            if p < 0.02 {
                let k = if log.rho == 0.0 {
                    0
                } else if log.rho < 0.7 {
                    1
                } else {
                    2
                };
                r[k].push(e / p);
            }
        }
    }
    for (k, mut v) in r.into_iter().enumerate() {
        v.sort_by(f64::total_cmp);
        let q = |f: f64| v[((v.len() - 1) as f64 * f) as usize];
        println!(
            "{k} n {} median {:.2} 90 {:.2} 97 {:.2} 99 {:.2} max {:.2}",
            v.len(),
            q(0.5),
            q(0.9),
            q(0.97),
            q(0.99),
            q(1.0)
        );
    }
}
