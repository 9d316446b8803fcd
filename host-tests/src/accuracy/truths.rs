//! Harder truths: what a diagnosis says of logs with human and machine motion, noise of every colour, unrelated columns and
//! effects from weak to overwhelming. `cargo truths` prints the table.

use crate::accuracy::simulated::table_of;
use crate::rate::Rate;
use ironout_analysis::outcome::outcome::Verdict;
use ironout_analysis::{Diagnosis, Options, Table, diagnose};
use ironout_simulation::truths::{Kind, draw};
use serde_json::{Value, json};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// Logs that thresholds are tuned on.
pub const TUNED_ON: u64 = 0x7d;
/// Logs that the table is measured on, apart from those.
pub const MEASURED_ON: u64 = 0x5eed;

/// What became of one log.
#[derive(Debug, Clone)]
pub struct Outcome {
    /// The log's number.
    pub number: u64,
    /// What it was.
    pub words: String,
    /// What was hidden.
    pub hidden: Vec<String>,
    /// What was named, in order.
    pub named: Vec<String>,
    /// What was said to be indistinguishable.
    pub confounded: Vec<String>,
    /// The verdict.
    pub verdict: Option<Verdict>,
    /// The stated noise floor over the true one.
    pub floor: f64,
    /// Held-out error at the end over the stated floor.
    pub left: f64,
    /// Seconds it took.
    pub seconds: f64,
    /// Rows of the log.
    pub rows: usize,
    /// The noise that is left: its colour, and how far it is from that.
    pub noise: String,
    /// Why there is no diagnosis, or the verdict's reasons.
    pub why: String,
}

impl Outcome {
    fn of(kind: Kind, family: u64, number: u64) -> Outcome {
        let drawn = draw(kind, family, number);
        let log = drawn.world.run();
        let table = table_of(&log);
        Outcome::diagnosed(number, drawn.words, drawn.hidden, &table, log.truth.noise_ut)
    }

    /// What a diagnosis says of a log in which this is hidden, in so much noise, µT.
    pub fn diagnosed(
        number: u64,
        words: String,
        hidden: Vec<String>,
        table: &Table<'_>,
        noise_ut: f64,
    ) -> Outcome {
        let mut out = Outcome {
            number,
            words,
            hidden,
            named: Vec::new(),
            confounded: Vec::new(),
            verdict: None,
            floor: f64::NAN,
            left: f64::NAN,
            seconds: 0.0,
            rows: table.rows(),
            noise: String::new(),
            why: String::new(),
        };
        let options = Options { search: true, ..Options::default() };
        let start = Instant::now();
        let diagnosis = diagnose(table, &options);
        out.seconds = start.elapsed().as_secs_f64();
        match diagnosis {
            Ok(diagnosis) => out.take(&diagnosis, noise_ut),
            Err(refusal) => out.why = format!("{refusal:?}"),
        }
        out
    }

    fn take(&mut self, diagnosis: &Diagnosis, noise_ut: f64) {
        self.named = diagnosis.steps.iter().filter_map(|step| step.added.clone()).collect();
        let groups = diagnosis.candidates.iter().filter(|row| row.status.name() == "confounded");
        self.confounded = groups.map(|row| row.id.clone()).collect();
        self.verdict = Some(diagnosis.verdict);
        self.floor = diagnosis.noise_floor_ut.map_or(f64::NAN, |floor| floor / noise_ut);
        let last = diagnosis.steps.last().and_then(|step| step.holdout_rms_ut);
        self.left = last.zip(diagnosis.residual_floor_ut).map_or(f64::NAN, |(error, floor)| error / floor);
        self.noise = diagnosis
            .noise
            .map_or_else(String::new, |noise| format!("{:?} misfit {:.1}", noise.colour, noise.misfit));
        self.why = diagnosis.reasons.join("; ");
    }

    /// The first that is named was hidden.
    pub fn first(&self) -> bool {
        self.named.first().is_some_and(|id| self.hidden.contains(id))
    }

    /// All that was hidden is named, and nothing else.
    pub fn exact(&self) -> bool {
        let sorted = |list: &[String]| {
            let mut list = list.to_vec();
            list.sort();
            list
        };
        sorted(&self.named) == sorted(&self.hidden)
    }

    /// The log cannot tell, and what was hidden is among those that it names together.
    pub fn confounded_with_the_truth(&self) -> bool {
        let all = |id: &String| self.confounded.contains(id) || self.named.contains(id);
        self.verdict == Some(Verdict::Confounded) && !self.hidden.is_empty() && self.hidden.iter().all(all)
    }

    /// Something is named that was not hidden; `drift` and `step` blame nobody where a column is missing.
    pub fn accuses(&self, blames_nobody: &[&str]) -> bool {
        self.named.iter().any(|id| !self.hidden.contains(id) && !blames_nobody.contains(&id.as_str()))
    }

    /// It says that all is found.
    pub fn claims(&self) -> bool {
        matches!(self.verdict, Some(Verdict::Complete | Verdict::Missing))
    }

    /// One line.
    pub fn line(&self, kind: &str) -> String {
        format!(
            "{} {} [{}] hidden {:?} named {:?} confounded {:?} {} floor {:.2} left {:.2} {} {} rows {:.1} s; {}",
            kind,
            self.number,
            self.words,
            self.hidden,
            self.named,
            self.confounded,
            self.verdict.map_or("refused", Verdict::name),
            self.floor,
            self.left,
            self.noise,
            self.rows,
            self.seconds,
            self.why
        )
    }

    /// Whether the log came out as it should.
    pub fn good(&self, kind: Kind) -> bool {
        match kind {
            Kind::Nothing | Kind::NothingFlicker => {
                self.named.is_empty() && self.verdict == Some(Verdict::Complete)
            }
            Kind::Deleted => !self.claims(),
            _ => self.exact() || self.confounded_with_the_truth(),
        }
    }
}

/// The rows of one log, with what is hidden in it as a comment.
pub fn csv_of(kind: Kind, family: u64, number: u64) -> String {
    let drawn = draw(kind, family, number);
    let mut text = Vec::new();
    let comment = format!("{}; hidden: {}", drawn.words, drawn.hidden.join(", "));
    drawn.world.run().write_csv(&mut text, &comment).expect("memory takes what it is given");
    String::from_utf8(text).expect("numbers and names")
}

/// Runs the logs `numbers` of one kind; `say` hears each as it is done.
pub fn run(
    kind: Kind,
    family: u64,
    numbers: std::ops::Range<u64>,
    say: impl Fn(&Outcome) + Sync,
) -> Vec<Outcome> {
    each(numbers, |number| Outcome::of(kind, family, number), say)
}

/// Runs so many logs on two threads; `say` hears each as it is done.
pub fn each(
    numbers: std::ops::Range<u64>,
    of: impl Fn(u64) -> Outcome + Sync,
    say: impl Fn(&Outcome) + Sync,
) -> Vec<Outcome> {
    in_parallel(numbers, |number| {
        let outcome = of(number);
        say(&outcome);
        outcome
    })
}

/// What is `of` each number, on two threads, in their order.
pub fn in_parallel<T: Send>(numbers: std::ops::Range<u64>, of: impl Fn(u64) -> T + Sync) -> Vec<T> {
    let next = AtomicU64::new(numbers.start);
    let list = Mutex::new(Vec::new());
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                loop {
                    let number = next.fetch_add(1, Ordering::Relaxed);
                    if number >= numbers.end {
                        return;
                    }
                    let made = of(number);
                    list.lock().unwrap_or_else(PoisonError::into_inner).push((number, made));
                }
            });
        }
    });
    let mut list = list.into_inner().unwrap_or_else(PoisonError::into_inner);
    list.sort_by_key(|(number, _)| *number);
    list.into_iter().map(|(_, made)| made).collect()
}

/// How many of them.
pub fn rate(list: &[Outcome], of: impl Fn(&Outcome) -> bool) -> Rate {
    Rate { count: list.iter().filter(|one| of(one)).count() as u64, of: list.len() as u64 }
}

/// The figures of one kind, each with what it says.
pub fn rates(kind: Kind, list: &[Outcome]) -> Vec<(&'static str, Rate)> {
    match kind {
        Kind::Nothing | Kind::NothingFlicker => vec![
            ("somebody named", rate(list, |one| !one.named.is_empty())),
            ("complete", rate(list, |one| one.verdict == Some(Verdict::Complete))),
        ],
        Kind::Deleted => vec![
            ("complete or missing claimed", rate(list, Outcome::claims)),
            ("a stand-in named", rate(list, |one| one.accuses(&["drift", "step"]))),
            ("floor over 1.5 times the truth", rate(list, |one| one.floor > 1.5)),
        ],
        Kind::Alike | Kind::AlikeGaps => vec![
            ("named first", rate(list, Outcome::first)),
            ("exactly", rate(list, Outcome::exact)),
            (
                "exactly, or confounded with it",
                rate(list, |one| one.exact() || one.confounded_with_the_truth()),
            ),
            ("another accused", rate(list, |one| one.accuses(&[]))),
        ],
        _ => vec![
            ("named first", rate(list, Outcome::first)),
            ("exactly", rate(list, Outcome::exact)),
            ("another accused", rate(list, |one| one.accuses(&[]))),
        ],
    }
}

/// The lines of one kind.
pub fn text(kind: Kind, list: &[Outcome]) -> String {
    let mut text = String::new();
    for (what, rate) in rates(kind, list) {
        text += &format!("{:<16} {what:<34} {rate}\n", kind.name());
    }
    text
}

/// Median, 90 % and worst of the times, s.
pub fn times(list: &[Outcome]) -> [f64; 3] {
    let mut seconds: Vec<f64> = list.iter().map(|one| one.seconds).collect();
    seconds.sort_by(f64::total_cmp);
    let at = |share: f64| {
        let place = (share * seconds.len().saturating_sub(1) as f64).round() as usize;
        seconds.get(place).copied().unwrap_or(f64::NAN)
    };
    [at(0.5), at(0.9), at(1.0)]
}

/// One object a figure of this kind of logs.
pub fn json(logs: &str, rates: Vec<(&'static str, Rate)>) -> Value {
    rates
        .into_iter()
        .map(|(what, rate)| json!({"logs": logs, "what": what, "count": rate.count, "of": rate.of}))
        .collect()
}
