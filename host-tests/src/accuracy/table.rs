//! The tables, as text that a person reads and a diff shows, and as JSON.

use super::bound::{self, Accuracy, Cell};
use super::correlated;
use super::gates::{self, Group};
use super::paper_table;
use super::solvers::{SOLVERS, Solver};
use crate::measured;
use crate::rate::Rate;
use serde_json::{Value, json};
use std::io;
use std::path::PathBuf;

/// How much of everything is run.
#[derive(Clone, Copy, Debug)]
pub struct Size {
    /// Logs of each cell of the sweep.
    pub seeds: u64,
    /// Logs of limited attitude.
    pub limited: u64,
    /// Logs of full attitude.
    pub full: u64,
    /// Logs of the paper's simulation.
    pub paper: u64,
    /// Logs of each cell of correlated noise.
    pub correlated: u64,
}

/// The full run.
pub const FULL: Size = Size { seeds: 100, limited: 1000, full: 500, paper: 200, correlated: 20 };

/// Everything measured.
pub struct Report {
    /// The sweep.
    pub sweep: Vec<(Cell, Vec<(Solver, Accuracy)>)>,
    /// Verdicts on limited attitude.
    pub limited: Vec<Group>,
    /// Verdicts on full attitude.
    pub full: Vec<Group>,
    /// The paper's simulation.
    pub paper: Vec<paper_table::Row>,
    /// Noise with a memory.
    pub correlated: Vec<correlated::Row>,
}

/// Runs everything.
pub fn measure(size: Size) -> Report {
    let with_total = |mut groups: Vec<Group>| {
        groups.push(gates::total(&groups));
        groups
    };
    Report {
        sweep: bound::cells().into_iter().map(|cell| (cell, bound::run(&cell, size.seeds))).collect(),
        limited: with_total(gates::run(true, 0, size.limited, |_, _, _, _| {})),
        full: gates::run(false, 0, size.full, |_, _, _, _| {}),
        paper: paper_table::rows(size.paper),
        correlated: correlated::measure(size.correlated),
    }
}

/// The sweep: error over the bound, and for the adjusted method bias and honesty of the standard errors.
pub fn sweep(rows: &[(Cell, Vec<(Solver, Accuracy)>)]) -> String {
    let mut text = String::from(
        "Rms error of b and A over the Cramer-Rao bound; of adjusted also the bias over the bound and the part of the errors\n\
         inside one standard error. A star: some logs were refused.\n\n\
         noise  samples coverage  offset | constant    trace adjusted   magcal |  bias inside\n",
    );
    for (cell, solvers) in rows {
        text += &format!(
            "{:5.1} % {:7} {:6.0} % {:5.1} F |",
            cell.sigma * 100.0,
            cell.n,
            cell.coverage * 100.0,
            cell.hard_iron
        );
        for (_, accuracy) in solvers {
            let star = if accuracy.refused > 0.0 { '*' } else { ' ' };
            text += &if accuracy.refused < 1.0 {
                format!("{:8.2}{star}", accuracy.over_bound)
            } else {
                format!("{:>8}{star}", "refused")
            };
        }
        if let Some((_, adjusted)) = solvers.iter().find(|(s, _)| s.name() == "adjusted") {
            text += &format!("| {:5.2} {:6.2}\n", adjusted.bias, adjusted.inside.unwrap_or(f64::NAN));
        }
    }
    text
}

/// The verdicts: accepted, wrongly accepted, wrongly refused.
pub fn verdicts(groups: &[Group]) -> String {
    let mut text = format!("{:<10} {:>5} |", "motion", "logs");
    for solver in SOLVERS {
        text += &format!(" {:^22} |", solver.name());
    }
    text += &format!("\n{:<10} {:>5} |", "", "");
    for _ in SOLVERS {
        text += " accept wrong good lost |";
    }
    text.push('\n');
    for group in groups {
        text += &format!("{:<10} {:>5} |", group.name, group.tallies[0].logs);
        for tally in &group.tallies {
            text += &format!(
                " {:6} {:5} {:4} {:4} |",
                tally.accepted, tally.wrongly_accepted, tally.good, tally.wrongly_refused
            );
        }
        text.push('\n');
    }
    text
}

/// What the verdicts' counts are worth: the last group of each kind of attitude stands for all of it.
pub fn rates(attitudes: &[(&str, &[Group])]) -> String {
    let mut text = String::from(
        "attitude  method    wrong of those accepted         lost of those good, with 95 % intervals\n",
    );
    for (name, groups) in attitudes {
        let Some(all) = groups.last() else { continue };
        for (solver, tally) in SOLVERS.iter().zip(&all.tallies) {
            let wrong = Rate { count: tally.wrongly_accepted as u64, of: tally.accepted as u64 };
            let lost = Rate { count: tally.wrongly_refused as u64, of: tally.good as u64 };
            text += &format!("{name:<9} {:<9} {wrong:<31} {lost}\n", solver.name());
        }
    }
    text
}

impl Report {
    /// Everything as text: what the snapshot holds.
    pub fn text(&self) -> String {
        format!(
            "The paper's simulation, eq. (16)\n\n{}\n{}\n{}\n{}",
            paper_table::text(&self.paper),
            sweep(&self.sweep),
            self.judged(),
            correlated::text(&self.correlated)
        )
    }

    /// The verdicts on both kinds of logs, and their rates.
    fn judged(&self) -> String {
        format!(
            "Verdicts on limited attitude. wrong: accepted though a corrected vector is off by more than {} % of the field\n\
             somewhere; good: none is off by {} %; lost: of these, refused. magcal has no verdict: its answers count as accepted.\n\n{}\n\
             Verdicts on full attitude\n\n{}\n{}",
            gates::WRONG * 100.0,
            gates::RIGHT * 100.0,
            verdicts(&self.limited),
            verdicts(&self.full),
            rates(&[("limited", &self.limited), ("full", &self.full)])
        )
    }

    /// Calibrations of limited attitude that our methods accepted though they are wrong.
    pub fn wrongly_accepted(&self) -> usize {
        let all = self.limited.iter().filter(|group| group.name == "all");
        let ours = SOLVERS.map(|solver| matches!(solver, Solver::Ironout(_)));
        all.flat_map(|group| group.tallies.iter().zip(ours))
            .map(|(tally, ours)| if ours { tally.wrongly_accepted } else { 0 })
            .sum()
    }

    /// Writes the snapshot, and the tables of the document of measurements.
    ///
    /// # Errors
    /// A file that cannot be written, or a document without the tables' markers.
    pub fn store(&self) -> io::Result<()> {
        std::fs::write(snapshot_path(), self.text())?;
        measured::write(&[
            ("accuracy-paper", paper_table::text(&self.paper)),
            ("accuracy-sweep", sweep(&self.sweep)),
            ("accuracy-verdicts", self.judged()),
            ("accuracy-correlated", correlated::text(&self.correlated)),
        ])
    }

    /// Everything as one object.
    pub fn json(&self) -> Value {
        let groups = |groups: &[Group]| -> Value {
            groups
                .iter()
                .flat_map(|g| {
                    SOLVERS.iter().zip(g.tallies).map(|(s, t)| {
                        json!({"motion": g.name, "method": s.name(), "logs": t.logs, "accepted": t.accepted,
                               "wrongly_accepted": t.wrongly_accepted, "good": t.good,
                               "wrongly_refused": t.wrongly_refused})
                    })
                })
                .collect()
        };
        let sweep: Value = self
            .sweep
            .iter()
            .flat_map(|(c, solvers)| {
                solvers.iter().map(move |(s, a)| {
                    json!({"method": s.name(), "noise": c.sigma, "samples": c.n, "coverage": c.coverage,
                           "hard_iron": c.hard_iron, "over_bound": a.over_bound, "bias_over_bound": a.bias,
                           "inside_one_se": a.inside, "refused": a.refused})
                })
            })
            .collect();
        let paper: Value = self
            .paper
            .iter()
            .map(|r| json!({"sigma": r.sigma, "samples": r.n, "method": r.who, "b": r.b, "a": r.a, "refused": r.refused}))
            .collect();
        json!({"paper": paper, "sweep": sweep, "limited": groups(&self.limited), "full": groups(&self.full),
               "correlated": correlated::json(&self.correlated)})
    }
}

/// Where the snapshot lies.
pub fn snapshot_path() -> PathBuf {
    PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/snapshots/accuracy.txt"))
}
