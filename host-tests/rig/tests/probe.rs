#[path = "../../src/learning/trace.rs"]
mod trace;
use trace::{Kind, Trace, TraceOptions};

#[test]
fn probe() {
    let env = |key: &str, or: u64| std::env::var(key).ok().and_then(|v| v.parse().ok()).unwrap_or(or);
    let (from, to) = (env("FROM", 1), env("TO", 2));
    let rho = env("RHO", 0) as f64 / 100.0;
    let hand = env("HAND", 0) == 1;
    let verbose = env("VERBOSE", 1) == 1;
    let only = std::env::var("KIND").unwrap_or_default();
    let kinds = [Kind::Clean, Kind::Temperature, Kind::Current, Kind::Lag, Kind::Step, Kind::Ramp];
    for kind in kinds {
        if !only.is_empty() && !only.split(',').any(|one| one == format!("{kind:?}")) {
            continue;
        }
        let (mut right, mut total) = (0, 0);
        for seed in from..=to {
            let motion =
                if hand { ironout_simulation::Motion::Hand } else { ironout_simulation::Motion::Sphere };
            let mut trace =
                Trace::new(TraceOptions { correlation: rho, motion, ..TraceOptions::new(kind, 1000 + seed) });
            trace.calibrate();
            let said = trace.why();
            total += 1;
            let ok = match kind {
                Kind::Clean => said.verdict() == "complete",
                Kind::Ramp => said.verdict() == "confounded",
                _ => said.first() == kind.id(),
            };
            right += u32::from(ok);
            if verbose || !ok {
                println!("== {kind:?} {seed} {}", if ok { "ok" } else { "WRONG" });
                for line in &said.lines {
                    println!("{line}");
                }
            }
            if verbose && !kind.id().is_empty() {
                println!("{}", trace.last(&format!("effect add {}", kind.id())));
                let said = trace.why();
                println!("{}", said.lines[0]);
                trace.last("stream cal");
                let mut squares = 0.0;
                let mut n = 0.0;
                for _ in 0..20 {
                    trace.run_ms(500);
                    for line in trace.board.received() {
                        if line.starts_with("C,") {
                            let r: f64 = line.rsplit(',').next().unwrap().parse().unwrap_or(f64::NAN);
                            squares += r * r;
                            n += 1.0;
                        }
                    }
                }
                trace.last("stream off");
                println!("streamed rms {:.4} n {n}", (squares / n as f64).sqrt());
                println!("{}", trace.last(&format!("effect remove {}", kind.id())));
                for h in trace.world.hidden() {
                    println!("{}", h.describe());
                }
                println!("{:?}", trace.board.command("cal show"));
            }
        }
        println!("## {kind:?} rho {rho} hand {hand}: {right} of {total}");
    }
}
