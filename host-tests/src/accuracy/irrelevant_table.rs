//! The table of irrelevant effects added: measured, as text, as JSON, and held to its snapshot and its limits.

use crate::accuracy::irrelevant::{ADDITIONS, CASES, Case, Kind, Trial, trials};
use crate::measured;
use serde_json::{Value, json};
use std::io;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

/// Logs of each kind behind the snapshot.
pub const SEEDS: u64 = 2;
/// Most of the irrelevant additions to refused logs that may be accepted.
pub const TURNED: f64 = 0.02;
/// Most of all irrelevant additions that may be accepted and worse on unseen time than no effect.
pub const WORSE: f64 = 0.01;

const HEADING: &str = "hidden               without    motion      additions  to refused  accepted of those  accepted and worse   its own effect";

/// Counts of additions.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Counts {
    /// Irrelevant additions.
    pub additions: u32,
    /// Of those, to logs that the plain fit refuses.
    pub refused: u32,
    /// Of those, accepted.
    pub turned: u32,
    /// Irrelevant additions that were accepted and are worse on unseen time than no effect.
    pub worse: u32,
    /// Additions of the hidden effect itself, and how many were accepted.
    pub own: [u32; 2],
    /// Stand-ins in time for what is hidden, and how many were accepted.
    pub stand_ins: [u32; 2],
}

impl Counts {
    fn add(&mut self, trial: &Trial) {
        let accepted = u32::from(trial.with.accepted);
        match trial.kind {
            Kind::Own => self.own = [self.own[0] + 1, self.own[1] + accepted],
            Kind::StandIn => self.stand_ins = [self.stand_ins[0] + 1, self.stand_ins[1] + accepted],
            Kind::Irrelevant => {
                self.additions += 1;
                self.refused += u32::from(!trial.plain.accepted);
                self.turned += u32::from(trial.is_turned());
                self.worse += u32::from(trial.is_worse());
            }
        }
    }

    fn merge(&mut self, other: &Counts) {
        let sum = |a: [u32; 2], b: [u32; 2]| [a[0] + b[0], a[1] + b[1]];
        self.additions += other.additions;
        self.refused += other.refused;
        self.turned += other.turned;
        self.worse += other.worse;
        self.own = sum(self.own, other.own);
        self.stand_ins = sum(self.stand_ins, other.stand_ins);
    }

    fn json(&self) -> Value {
        let interval = |k: u32, n: u32| json!(wilson(k, n));
        json!({
            "additions": self.additions, "to_refused": self.refused, "accepted_of_refused": self.turned,
            "accepted_of_refused_95": interval(self.turned, self.refused), "accepted_and_worse": self.worse,
            "accepted_and_worse_95": interval(self.worse, self.additions),
            "own": self.own[0], "own_accepted": self.own[1],
            "stand_ins": self.stand_ins[0], "stand_ins_accepted": self.stand_ins[1],
        })
    }
}

/// Wilson's interval of a share, 95 %.
pub fn wilson(k: u32, n: u32) -> [f64; 2] {
    if n == 0 {
        return [0.0, 1.0];
    }
    let (n, z) = (f64::from(n), 1.96);
    let share = f64::from(k) / n;
    let middle = share + z * z / (2.0 * n);
    let half = z * (share * (1.0 - share) / n + z * z / (4.0 * n * n)).sqrt();
    let whole = 1.0 + z * z / n;
    [((middle - half) / whole).max(0.0), ((middle + half) / whole).min(1.0)]
}

/// The whole table.
pub struct Irrelevant {
    rows: Vec<(Case, Counts)>,
    /// The sums.
    pub all: Counts,
}

impl Irrelevant {
    /// Runs `seeds` logs of each kind on two threads; `say` hears every trial.
    pub fn measure(seeds: u64, say: impl Fn(&Case, u64, &Trial) + Sync) -> Self {
        let counts = Mutex::new(vec![Counts::default(); CASES.len()]);
        let next = AtomicU64::new(0);
        let work = || {
            loop {
                let job = next.fetch_add(1, Ordering::Relaxed);
                let (index, seed) = ((job % CASES.len() as u64) as usize, job / CASES.len() as u64 + 1);
                let Some(case) = CASES.get(index).filter(|_| seed <= seeds) else { break };
                let found = trials(case, seed, &ADDITIONS);
                let mut counts = counts.lock().unwrap_or_else(PoisonError::into_inner);
                for trial in &found {
                    say(case, seed, trial);
                    counts[index].add(trial);
                }
            }
        };
        std::thread::scope(|scope| {
            scope.spawn(work);
            work();
        });
        let counts = counts.into_inner().unwrap_or_else(PoisonError::into_inner);
        let mut all = Counts::default();
        counts.iter().for_each(|one| all.merge(one));
        Irrelevant { rows: CASES.into_iter().zip(counts).collect(), all }
    }

    /// What the snapshot holds.
    pub fn text(&self) -> String {
        let mut text = format!("{HEADING}\n");
        for (case, counts) in &self.rows {
            let or = |word: &'static str| if word.is_empty() { "-" } else { word };
            text += &line(or(case.hidden), or(case.without), &format!("{:?}", case.motion), counts);
        }
        text += &line("all", "", "", &self.all);
        let percent = |[low, high]: [f64; 2]| format!("{:.1} to {:.1} %", 100.0 * low, 100.0 * high);
        let all = &self.all;
        text += &format!(
            "\naccepted though the plain fit was refused: {} of {} (95 %: {}; at most {} %)\n",
            all.turned,
            all.refused,
            percent(wilson(all.turned, all.refused)),
            100.0 * TURNED
        );
        text += &format!(
            "accepted and worse on unseen time than no effect: {} of {} (95 %: {}; at most {} %)\n",
            all.worse,
            all.additions,
            percent(wilson(all.worse, all.additions)),
            100.0 * WORSE
        );
        text += &format!(
            "shapes in time that stand in for a slow cause: {} of {} accepted\n",
            all.stand_ins[1], all.stand_ins[0]
        );
        text
    }

    /// One object a row, and the sums.
    pub fn json(&self) -> Value {
        let rows: Vec<Value> = (self.rows.iter())
            .map(|(case, counts)| {
                json!({
                    "hidden": case.hidden, "without": case.without, "motion": format!("{:?}", case.motion),
                    "counts": counts.json(),
                })
            })
            .collect();
        json!({"rows": rows, "all": self.all.json()})
    }

    /// Whether both shares are within their limits.
    pub fn holds(&self) -> bool {
        let share = |k: u32, n: u32| f64::from(k) / f64::from(n.max(1));
        share(self.all.turned, self.all.refused) <= TURNED
            && share(self.all.worse, self.all.additions) <= WORSE
    }

    /// Writes the snapshot, and the table of the document.
    ///
    /// # Errors
    /// A file that cannot be written, or a document without the table's markers.
    pub fn store(&self) -> io::Result<()> {
        let text = self.text();
        std::fs::write(Self::snapshot_path(), &text)?;
        measured::write(&[("accuracy-irrelevant", text)])
    }

    /// Where the snapshot lies.
    pub fn snapshot_path() -> PathBuf {
        PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/snapshots/irrelevant.txt"))
    }
}

fn line(hidden: &str, without: &str, motion: &str, counts: &Counts) -> String {
    let own =
        if counts.own[0] == 0 { String::new() } else { format!("{} of {}", counts.own[1], counts.own[0]) };
    let text = format!(
        "{hidden:<20} {without:<10} {motion:<10} {:>10} {:>11} {:>18} {:>19} {own:>16}",
        counts.additions, counts.refused, counts.turned, counts.worse
    );
    text.trim_end().to_string() + "\n"
}
