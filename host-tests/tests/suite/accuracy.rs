//! A small part of `cargo accuracy`, held to its snapshot.

use ironout_host_tests::accuracy::{bound, gates, paper_table, solvers::SOLVERS, table};

fn snapshot() -> String {
    std::fs::read_to_string(table::snapshot_path()).expect("the snapshot lies in the repository")
}

/// The numbers of the snapshot's lines that begin with these words.
fn stored(start: &str) -> Vec<f64> {
    let words: Vec<&str> = start.split_whitespace().collect();
    let text = snapshot();
    let line = text
        .lines()
        .find(|l| l.split_whitespace().take(words.len()).eq(words.iter().copied()))
        .unwrap_or_else(|| panic!("the snapshot has no line {start}"));
    line.split_whitespace().skip(words.len()).filter_map(|w| w.trim_end_matches('*').parse().ok()).collect()
}

#[test]
fn the_papers_simulation_is_as_the_snapshot_says() {
    for row in paper_table::rows(50).iter().filter(|r| r.who == "adjusted" || r.who == "trace") {
        let [b, a, ..] = stored(&format!("{:.4} {} {}", row.sigma, row.n, row.who))[..] else {
            panic!("no numbers for {row:?}")
        };
        // 50 of the snapshot's 200 logs.
        for (measured, stored) in [(row.b.unwrap(), b), (row.a.unwrap(), a)] {
            assert!((measured / stored - 1.0).abs() < 0.2, "{row:?}: {measured} against {stored}");
        }
    }
}

#[test]
fn adjusted_stays_at_the_bound_and_its_errors_honest() {
    for cell in bound::cells().iter().filter(|c| c.n == 2000 && c.hard_iron == 0.5).step_by(3) {
        for (solver, accuracy) in bound::run(cell, 25) {
            if solver.name() == "adjusted" {
                assert!(accuracy.over_bound < 1.4, "{cell:?}: {accuracy:?}");
                let inside = accuracy.inside.unwrap();
                assert!((0.5..0.85).contains(&inside), "{cell:?}: {accuracy:?}");
                assert_eq!(accuracy.refused, 0.0, "{cell:?}");
            }
        }
    }
}

#[test]
fn no_calibration_of_limited_attitude_is_wrongly_accepted() {
    let groups = gates::run(true, 0, 300, |seed, solver, log, judged| {
        let wrong = judged.accepted && solver.name() != "magcal";
        assert!(!wrong, "log {seed}, {}: {:?} {judged:?}", solver.name(), log.motion);
    });
    let all = gates::total(&groups);
    for (solver, tally) in SOLVERS.iter().zip(all.tallies).take(3) {
        let share = tally.accepted as f64 / tally.logs as f64;
        let lost = tally.wrongly_refused as f64 / tally.logs as f64;
        println!("{}: {:.0} % accepted, {:.1} % wrongly refused", solver.name(), share * 100.0, lost * 100.0);
        assert!(lost < 0.05, "{}: {tally:?}", solver.name());
    }
    // Adjusted least squares makes something of a quarter of them.
    assert!(all.tallies[2].accepted * 5 > all.tallies[2].logs, "{all:?}");
}

#[test]
fn full_attitude_is_accepted() {
    let groups = gates::run(false, 0, 100, |_, _, _, _| {});
    let adjusted = gates::total(&groups).tallies[2];
    assert_eq!(adjusted.wrongly_accepted, 0);
    assert!(adjusted.accepted >= 80, "{adjusted:?}");
}
