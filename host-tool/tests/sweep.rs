//! scratch sweep
use ironout_cli::diagnose::{Options, Table, diagnose, outcome::*};
use ironout_host_tests::world::*;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

fn env<T: std::str::FromStr>(name: &str, default: T) -> T {
    std::env::var(name).ok().and_then(|s| s.parse().ok()).unwrap_or(default)
}

#[test]
fn sweep() {
    let effects = std::env::var("EFFECTS").unwrap_or("".into());
    let seeds: u64 = env("SEEDS", 10);
    let first: u64 = env("FIRST", 0);
    let rho: f64 = env("RHO", 0.0);
    let noise: f64 = env("NOISE", 0.25);
    let seconds: f64 = env("SECONDS", 80.0);
    let drop: String = env("DROP", "".into());
    let ramp: bool = env("RAMP", false);
    let cap: f64 = env("CAP", 0.0);
    let planar: bool = env("PLANAR", false);
    for set in effects.split(';') {
        let started = std::time::Instant::now();
        let next = AtomicU64::new(first);
        let lines = Mutex::new(vec![]);
        let stats = Mutex::new((0, 0, 0, 0.0, 0.0_f64, 0, 0, 0));
        std::thread::scope(|scope| {
            for _ in 0..2 {
                std::thread::Builder::new().stack_size(64<<20).spawn_scoped(scope, || loop {
            let seed = next.fetch_add(1, Ordering::SeqCst);
            if seed >= first + seeds { break; }
            let items: Vec<&str> = set.split(',').filter(|s| !s.is_empty()).collect();
            let specs: Vec<EffectSpec> = items.iter().filter_map(|s| EffectSpec::parse(s).ok()).collect();
            let faults: Vec<FaultSpec> = items.iter().filter_map(|s| FaultSpec::parse(s).ok()).collect();
            assert_eq!(specs.len() + faults.len(), items.len());
            let mut want: Vec<String> = specs.iter().map(|s| s.id()).filter(|s| s != "misalignment").collect();
            let world = World::new(WorldOptions { seed, effects: specs, faults, noise_ut: noise, noise_correlation: rho, seconds,
                temperature: if ramp { Temperature::Ramp } else { Temperature::WarmUp },
                motion: if planar { Motion::Planar } else if cap > 0.0 { Motion::Cap(cap) } else if env("HAND", false) { Motion::Hand } else { Motion::Sphere },
                drop_columns: drop.split(',').filter(|s| !s.is_empty()).map(String::from).collect(), ..Default::default() });
            let log = world.run();
            let d = diagnose(&Table::from(&log), &Options { search: true, ..Default::default() }).unwrap();
            if env("DBG", String::new()) != "" { let a = nalgebra::Matrix3::from_fn(|i,j| log.truth.soft_iron[i][j]); eprintln!("truth inverse {:?}", a.try_inverse().unwrap().transpose().as_slice()); }
            let got: Vec<String> = d.steps.iter().filter_map(|s| s.added.clone()).collect();
            let mut sorted = got.clone();
            sorted.sort(); want.sort();
            let named_first = got.first().is_some_and(|g| want.contains(g));
            let expected = if want.is_empty() { Verdict::Complete } else { Verdict::Missing };
            let exact = sorted == want && d.verdict == expected;
            let ratio = d.steps.last().and_then(|s| s.holdout_rms_ut).unwrap_or(f64::NAN) / d.residual_floor_ut.unwrap_or(f64::NAN);
            let (mut one, mut three, mut all) = (0, 0, 0);
            for h in &log.truth.effects {
                let id = match &h.kind { EffectKind::Offset{column,power:1,delayed:false} => format!("offset:{column}"), EffectKind::Offset{column,power:2,..} => format!("offset:{column}^2"), EffectKind::Offset{column,..} => format!("offset:{column}@delay"), EffectKind::Gain(c) => format!("gain:{c}"), EffectKind::Field(c) => format!("field:{c}"), EffectKind::Drift => "drift".into(), EffectKind::Step => "step".into(), EffectKind::Lag | EffectKind::Eddy => "lag".into(), EffectKind::Nonlinearity => "nonlinearity".into(), EffectKind::CrossAxis => "cross-axis".into(), EffectKind::Periodic => "periodic".into(), _ => continue };
                if let Some(e) = d.effects.iter().find(|e| e.id == id) { if e.coefficients.len() == h.coefficients.len() { for ((c, s), t) in e.coefficients.iter().zip(&e.std_errors).zip(&h.coefficients) {
                    let z = (c - t) / s; all += 1; one += (z.abs() < 1.0) as i32; three += (z.abs() < 3.0) as i32;
                    if std::env::var("Z").is_ok() { lines.lock().unwrap().push(format!("    {id} seed {seed} z {z:.2} c {c} t {t} s {s}")); }
                } } }
            }
            { let mut s = stats.lock().unwrap(); s.0 += named_first as i32; s.1 += exact as i32; s.2 += (d.verdict == expected) as i32; s.3 += ratio; s.4 = s.4.max(ratio); s.5 += one; s.6 += three; s.7 += all; }
            if !exact || !d.data_faults.is_empty() || std::env::var("V").is_ok() {
                let conf: Vec<String> = d.candidates.iter().filter(|c| c.status == Status::Confounded).map(|c| c.id.clone()).collect();
                lines.lock().unwrap().push(format!("  seed {seed}: {} {got:?} conf {conf:?} faults {:?} steps {:?} floor {:.3} reasons {:?}", d.verdict.name(), d.data_faults.iter().map(|f| format!("{} {:?}-{:?} {}", f.kind.name(), f.from_s, f.to_s, f.samples)).collect::<Vec<_>>(), d.steps.iter().map(|s| format!("{:.3}/{:.3}", s.rms_ut, s.holdout_rms_ut.unwrap_or(f64::NAN))).collect::<Vec<_>>(), d.residual_floor_ut.unwrap_or(f64::NAN), d.reasons));
            }
            if std::env::var("C").is_ok() { for c in &d.candidates { lines.lock().unwrap().push(format!("      {} {} p {:?} ho {:?}", c.id, c.status.name(), c.p_value, c.holdout_rms_ut)); } }
        }).unwrap();
            }
        });
        let s = stats.into_inner().unwrap();
        let n = seeds as f64;
        println!(
            "{set:36} first {:5.1} % exact {:5.1} % verdict {:5.1} % ho/floor mean {:.3} max {:.3}  1s {:.1} % 3s {:.1} % ({})  {:.2} s each",
            100.0 * s.0 as f64 / n,
            100.0 * s.1 as f64 / n,
            100.0 * s.2 as f64 / n,
            s.3 / n,
            s.4,
            100.0 * s.5 as f64 / s.7 as f64,
            100.0 * s.6 as f64 / s.7 as f64,
            s.7,
            started.elapsed().as_secs_f64() / n
        );
        for l in lines.into_inner().unwrap().iter().take(env("SHOW", 8)) {
            println!("{l}");
        }
    }
}
