//! Hidden effects are found in simulated logs: a few seeds of the table that `cargo effects-accuracy` writes in full.

use ironout_analysis::outcome::outcome::Verdict;
use ironout_host_tests::accuracy::effect_table::{CASES, HEADING, line, run};

#[test]
fn every_kind_of_log_gets_its_verdict() {
    let mut misses = Vec::new();
    let mut coefficients = [0; 3];
    for case in &CASES {
        // Few false alarms would hide in one log.
        let clean = case.logs(1) > 1;
        let row = run(case, if clean { 3 } else { 1 });
        let named = case.verdict != Verdict::Missing || row.named_first == row.logs;
        let explained = case.verdict != Verdict::Missing || row.worst_over_floor <= 1.05;
        let exact = matches!(case.verdict, Verdict::Confounded | Verdict::Undetermined | Verdict::Missing)
            || row.exact == row.logs;
        if row.verdict < row.logs || !named || !explained || !exact {
            misses.push(line(case, &row));
        }
        for (sum, count) in coefficients.iter_mut().zip(row.coefficients) {
            *sum += count;
        }
    }
    assert!(misses.is_empty(), "\n{HEADING}\n{}", misses.join("\n"));
    let [all, one, three] = coefficients.map(f64::from);
    // All kinds share the noise of the one seed, so the share swings; twenty seeds hold it in `cargo accuracy`.
    assert!((0.50..0.90).contains(&(one / all)), "{:.2} within one standard error", one / all);
    assert!(three / all >= 0.95, "{:.3} within three standard errors", three / all);
}
