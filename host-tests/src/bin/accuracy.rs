//! tmp
use ironout_host_tests::accuracy::gates;
fn main() {
    let n: u64 = std::env::args().nth(1).and_then(|a| a.parse().ok()).unwrap_or(300);
    for limited in [true, false] {
        let groups = gates::run(limited, 0, if limited { n } else { n / 3 }, |seed, solver, log, j| {
            if solver.name() != "magcal" {
                println!(
                    "{seed} {} {:?} n {} noise {:.2}% lsb {:.3} rho {:.2} acc {} err {:.4} pred {:.4} {}",
                    solver.name(),
                    log.motion,
                    log.counts.len(),
                    log.noise_ut * 2.0,
                    log.ut_per_count,
                    log.rho,
                    j.accepted,
                    j.error.unwrap_or(f64::NAN),
                    j.predicted.unwrap_or(f64::NAN),
                    j.reasons
                );
            }
        });
        for g in groups.iter().chain([&gates::total(&groups)]) {
            println!(
                "{:<10} {:?}",
                g.name,
                g.tallies.map(|t| (t.logs, t.accepted, t.wrongly_accepted, t.wrongly_refused))
            );
        }
    }
}
