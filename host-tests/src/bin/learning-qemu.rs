//! How often the firmware in QEMU names what is hidden, and what `effect add` leaves of it:
//! `cargo run --profile host -p ironout-host-tests --bin learning-qemu [TRACES [BOARDS [MINUTES [KIND …]]]]`.
//!
//! Traces of each kind with a hidden effect (six times as many clean ones: 10 and 60), on so many emulated boards at a time. A board
//! takes its samples by its own clock, so that a trace takes some two minutes. After MINUTES no trace is begun any more.

#[cfg(unix)]
fn main() -> std::process::ExitCode {
    unix::main()
}

#[cfg(not(unix))]
fn main() -> std::process::ExitCode {
    eprintln!("the emulated board speaks over Unix sockets");
    std::process::ExitCode::from(2)
}

#[cfg(unix)]
mod unix {
    use ironout_host_tests::learning::{EmulatedLengths, EmulatedShown, Kind, emulated};
    use ironout_host_tests::rate::Rate;
    use ironout_rig::qemu::{Firmware, installed};
    use std::collections::VecDeque;
    use std::process::ExitCode;
    use std::sync::Mutex;
    use std::time::Instant;

    /// The first seed: none of those that the study was made with.
    const FIRST: u64 = 7001;
    const LENGTHS: EmulatedLengths = EmulatedLengths { collect_s: 60.0, stream_s: 12.0 };
    const KINDS: [Kind; 6] =
        [Kind::Temperature, Kind::Current, Kind::Lag, Kind::Step, Kind::Ramp, Kind::Clean];

    type Row = (Kind, u64, EmulatedShown);

    /// One line a trace, as it ends.
    fn say((kind, seed, shown): &Row) {
        let said = &shown.said;
        print!(
            "{} {seed}: {} verdict={} first={} accepted={} samples={} late={} mixed={}",
            kind.name(),
            if shown.is_right { "right" } else { "WRONG" },
            said.verdict(),
            said.first(),
            shown.stopped.starts_with("ok"),
            shown.samples.all,
            shown.samples.late,
            shown.samples.mixed,
        );
        if let Some(learnt) = &shown.learnt {
            let before = learnt.before.map_or_else(|| "-".to_owned(), |ratio| format!("{ratio:.3}"));
            print!(
                " before={before} added={:.3} restarted={:.3} removed={:.3} kept={}",
                learnt.added, learnt.restarted, learnt.removed, learnt.is_kept
            );
        }
        println!();
        let removed = shown.learnt.as_ref().filter(|one| one.removed > 20.0);
        removed.iter().flat_map(|one| one.answers.lines()).for_each(|line| println!("  {line}"));
        if !shown.is_right || removed.is_some() {
            println!("  {}", shown.stopped);
            said.lines.iter().for_each(|line| println!("  {line}"));
        }
    }

    fn range(values: impl Iterator<Item = f64>) -> String {
        let mut all: Vec<f64> = values.collect();
        all.sort_by(f64::total_cmp);
        match (all.first(), all.get(all.len() / 2), all.last()) {
            (Some(least), Some(middle), Some(most)) => format!("{middle:.2} ({least:.2} to {most:.2})"),
            _ => "-".to_owned(),
        }
    }

    fn summary(kind: Kind, rows: &[Row]) {
        let of_kind: Vec<&EmulatedShown> =
            rows.iter().filter(|row| row.0 == kind).map(|(_, _, shown)| shown).collect();
        let rate = |is: &dyn Fn(&EmulatedShown) -> bool, of: usize| Rate {
            count: of_kind.iter().filter(|shown| is(shown)).count() as u64,
            of: of as u64,
        };
        println!("{}: right {}", kind.name(), rate(&|shown| shown.is_right, of_kind.len()));
        let learnt: Vec<_> = of_kind.iter().filter_map(|shown| shown.learnt.as_ref()).collect();
        if learnt.is_empty() {
            return;
        }
        let within = |of: &dyn Fn(&EmulatedShown) -> Option<f64>| {
            rate(&|shown| of(shown).is_some_and(|ratio| ratio <= 1.1), learnt.len())
        };
        println!(
            "  added, over the noise: {}; at most 1.1 floors: {}",
            range(learnt.iter().map(|one| one.added)),
            within(&|shown| Some(shown.learnt.as_ref()?.added))
        );
        println!(
            "  restarted, over the noise: {}; at most 1.1 floors: {}",
            range(learnt.iter().map(|one| one.restarted)),
            within(&|shown| Some(shown.learnt.as_ref()?.restarted))
        );
        println!("  removed, over the noise: {}", range(learnt.iter().map(|one| one.removed)));
        println!("  before, over the noise: {}", range(learnt.iter().filter_map(|one| one.before)));
        println!(
            "  kept over the power cut to the last digit: {}",
            learnt.iter().filter(|one| one.is_kept).count()
        );
    }

    pub fn main() -> ExitCode {
        let words: Vec<String> = std::env::args().skip(1).collect();
        let (numbers, names) = words.split_at(words.len().min(3));
        let numbers: Option<Vec<u64>> = numbers.iter().map(|word| word.parse().ok()).collect();
        let wanted = |kind: &Kind| names.is_empty() || names.iter().any(|name| name == kind.name());
        let (traces, boards, minutes) = match numbers.as_deref() {
            Some([]) => (10, 2, u64::MAX),
            Some([traces]) => (*traces, 2, u64::MAX),
            Some([traces, boards]) if *boards > 0 => (*traces, *boards, u64::MAX),
            Some([traces, boards, minutes]) if *boards > 0 => (*traces, *boards, *minutes),
            _ => {
                eprintln!("usage: learning-qemu [TRACES [BOARDS [MINUTES [KIND ...]]]]");
                return ExitCode::from(2);
            }
        };
        if !installed() {
            eprintln!("learning-qemu: {}", ironout_rig::qemu::Error::NotInstalled);
            return ExitCode::from(2);
        }
        let firmware = match Firmware::build() {
            Ok(firmware) => firmware,
            Err(error) => {
                eprintln!("learning-qemu: {error}");
                return ExitCode::from(2);
            }
        };
        // In turns, so that a run that is cut short has some of each.
        let jobs: VecDeque<(Kind, u64)> = (0..traces)
            .flat_map(|turn| {
                let one = KINDS[..5].iter().map(move |kind| (*kind, FIRST + turn));
                one.chain((6 * turn..6 * turn + 6).map(|seed| (Kind::Clean, FIRST + seed)))
            })
            .filter(|(kind, _)| wanted(kind))
            .collect();
        let (jobs, rows) = (Mutex::new(jobs), Mutex::new(Vec::<Row>::new()));
        let begun = Instant::now();
        let next = || {
            let is_time = begun.elapsed().as_secs() / 60 < minutes;
            jobs.lock().ok().filter(|_| is_time).and_then(|mut jobs| jobs.pop_front())
        };
        std::thread::scope(|scope| {
            for _ in 0..boards {
                scope.spawn(|| {
                    while let Some((kind, seed)) = next() {
                        match emulated::run(&firmware, kind, seed, LENGTHS) {
                            Ok(shown) if shown.samples.is_spoilt() => {
                                println!("{} {seed}: SPOILT, run again: {:?}", kind.name(), shown.samples);
                                if let Ok(mut jobs) = jobs.lock() {
                                    jobs.push_back((kind, seed));
                                }
                            }
                            Ok(shown) => {
                                let row = (kind, seed, shown);
                                say(&row);
                                if let Ok(mut rows) = rows.lock() {
                                    rows.push(row);
                                }
                            }
                            // A trace that could not be run is no answer, right or wrong, and is said.
                            Err(error) => println!("{} {seed}: FAILED: {error}", kind.name()),
                        }
                    }
                });
            }
        });
        let rows = rows.into_inner().unwrap_or_default();
        for kind in KINDS {
            summary(kind, &rows);
        }
        ExitCode::SUCCESS
    }
}
