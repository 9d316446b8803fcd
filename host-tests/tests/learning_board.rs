//! The board's own study.

use ironout_host_tests::learning::{Kind, Trace, TraceOptions};

#[test]
fn probe() {
    let kinds = [Kind::Clean, Kind::Temperature, Kind::Current, Kind::Lag, Kind::Step, Kind::Ramp];
    for kind in kinds {
        for seed in 1..=3 {
            let mut trace = Trace::new(TraceOptions::new(kind, seed));
            trace.calibrate();
            let said = trace.why();
            println!("== {kind:?} {seed}");
            for line in &said.lines {
                println!("{line}");
            }
            if !kind.id().is_empty() {
                println!("{}", trace.last(&format!("effect add {}", kind.id())));
            }
        }
    }
}
