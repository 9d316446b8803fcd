//! scratch sweep
use ironout::study::Residual;
use ironout_cli::diagnose::{
    base, candidates::Catalogue, engine::*, greedy::*, samples::Samples, series::*, table::Table,
};
use ironout_host_tests::world::*;

#[test]
fn sweep() {
    let effects = std::env::var("EFFECTS").unwrap_or("".into());
    let seeds: u64 = std::env::var("SEEDS").ok().and_then(|s| s.parse().ok()).unwrap_or(10);
    let rho: f64 = std::env::var("RHO").ok().and_then(|s| s.parse().ok()).unwrap_or(0.0);
    let noise: f64 = std::env::var("NOISE").ok().and_then(|s| s.parse().ok()).unwrap_or(0.25);
    for set in effects.split(';') {
        let mut right = 0;
        let mut lines = vec![];
        let started = std::time::Instant::now();
        let first: u64 = std::env::var("FIRST").ok().and_then(|s| s.parse().ok()).unwrap_or(0);
        for seed in first..first + seeds {
            let specs: Vec<EffectSpec> =
                set.split(',').filter(|s| !s.is_empty()).map(|s| EffectSpec::parse(s).unwrap()).collect();
            let mut want: Vec<String> = specs.iter().map(|s| s.id()).collect();
            let world = World::new(WorldOptions {
                seed,
                effects: specs,
                noise_ut: noise,
                noise_correlation: rho,
                ..Default::default()
            });
            let log = world.run();
            let table = Table::from(&log);
            let samples = Samples::take(&table, &vec![false; table.rows()], [true; 3]);
            let catalogue = Catalogue::new(&samples, &table);
            let known = Known::default();
            let pass = Pass { samples: &samples, residual: Residual::Magnitude };
            let (model, _) = base::start(&samples, None).unwrap();
            let fitted = pass.fit(model, vec![], &known).unwrap().unwrap();
            let greedy = Greedy { pass, catalogue: &catalogue, known: &known };
            let e = greedy.run(fitted).unwrap();
            let mut got: Vec<String> = e.fitted.pieces.iter().map(|p| p.id.clone()).collect();
            let order = got.clone();
            got.sort();
            want.sort();
            let list: Vec<&Piece> = e.fitted.pieces.iter().collect();
            let r = pass.residuals(&e.fitted.model, &list).unwrap();
            let ok = got == want && e.confounded.is_empty();
            if ok {
                right += 1;
            }
            if !ok || std::env::var("V").is_ok() {
                lines.push(format!(
                    "  seed {seed}: got {order:?} conf {:?} steps {:?} 2nd {:.3}",
                    e.confounded,
                    e.steps
                        .iter()
                        .map(|s| format!("{:.3}/{:.3}", s.rms, s.held_out.unwrap_or(f64::NAN)))
                        .collect::<Vec<_>>(),
                    second_difference_sigma(&r)
                ));
                if std::env::var("V").is_ok() {
                    for j in &e.last {
                        lines.push(format!(
                            "      {} dec {:.2} p {:.2e} tau {:.1} ho {:?} dirs {}",
                            j.candidate.piece.id,
                            j.tested.decrease,
                            j.tested.p_value,
                            j.tested.time,
                            j.tested.held_out,
                            j.tested.directions
                        ));
                    }
                }
            }
        }
        println!("{set:40} {right}/{seeds} {:.2} s each", started.elapsed().as_secs_f64() / seeds as f64);
        for l in lines.iter().take(40) {
            println!("{l}");
        }
    }
}
