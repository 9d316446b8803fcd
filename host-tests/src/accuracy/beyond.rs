//! Causes beyond plain columns (low-passes, products, late columns, powers, motors …), by kind and strength, from both generators:
//! what a diagnosis names, what it leaves, and the error of its calibration on a second recording.

use crate::accuracy::true_error::best_rotation;
use crate::rate::Rate;
use ironout_analysis::effects::calibrated;
use ironout_analysis::{Corrector, Diagnosis, Options, Table, diagnose};
use ironout_simulation::{EffectSpec, Log, World, WorldOptions};
use nalgebra::Vector3;
use std::collections::BTreeMap;

/// Kinds of the second generator, by a word that its truth says.
const SECOND: [&str; 9] =
    ["low-pass", "product", "power", "saturation", "gain", "unlogged", "steps", "motor", "logged"];
/// Its first log here. Numbers to 9062, of low-passes and products to 9205, were looked at while the search was made.
const SECOND_FROM: u64 = 9000;
/// Kinds of the own simulator.
const OWN: [&str; 5] = [
    "offset:temp_c~tau",
    "offset:current_a~tau",
    "product:current_a*temp_c",
    "offset:current_a@delay",
    "offset:current_a^2",
];
/// Seeds of the own simulator, which no other table has.
const OWN_SEEDS: u64 = 0x41_be00;
/// Strengths of the own simulator's effects, in multiples of the noise, each in the middle of one of the bands.
const OWN_STRENGTHS: [f64; 3] = [2.5, 6.0, 13.0];
/// Ends of the bands of strength, in multiples of the noise.
const BANDS: [f64; 2] = [4.0, 9.0];

type Columns = Vec<(String, Vec<f64>)>;

/// A log with one cause, and a second recording of the same sensor with the same cause.
struct Case {
    kind: String,
    strength: f64,
    columns: Vec<String>,
    noise_ut: f64,
    log: Columns,
    /// None where the cause has no column, so that a second recording has another cause.
    second: Option<Recording>,
}

/// A recording, its true field in the body frame, and the first row that counts.
struct Recording {
    columns: Columns,
    truth: Vec<[f64; 3]>,
    from: usize,
}

/// Log `number` of the second generator: its first half, and its second half as the second recording, in which the columns have
/// another history and the state of a filter is known.
fn of_second(number: u64) -> Option<Case> {
    let drawn = second_generator::draw(second_generator::Kind::Beyond, SECOND_FROM + number);
    let hidden = drawn.truth.hidden.first()?;
    let kind = SECOND.iter().find(|word| hidden.words.contains(**word)).copied().unwrap_or("other");
    let rows = drawn.truth.field_body_ut.len();
    let log = drawn.columns.iter().map(|(name, values)| (name.clone(), values[..rows / 2].to_vec()));
    let second = Recording {
        columns: drawn.columns.clone(),
        truth: drawn.truth.field_body_ut.clone(),
        from: rows / 2,
    };
    Some(Case {
        kind: kind.into(),
        strength: hidden.strength,
        columns: hidden.columns.clone(),
        noise_ut: drawn.truth.noise_ut,
        log: if hidden.columns.is_empty() { drawn.columns.clone() } else { log.collect() },
        second: (!hidden.columns.is_empty()).then_some(second),
    })
}

fn columns_of(log: Log) -> Columns {
    log.names.into_iter().zip(log.columns).collect()
}

/// Log `number` of the own simulator: each kind at each strength in turn.
fn of_own(number: u64) -> Option<Case> {
    let place = number as usize;
    let kind = OWN[place % OWN.len()];
    let strength = OWN_STRENGTHS[place / OWN.len() % OWN_STRENGTHS.len()];
    let spec = EffectSpec::parse(&format!("{kind}={strength}")).ok()?;
    let columns = spec.columns().map(str::to_owned).collect();
    let world =
        World::new(WorldOptions { seed: OWN_SEEDS + number, effects: vec![spec], ..WorldOptions::default() });
    let second = world.recording(2).run();
    Some(Case {
        kind: kind.into(),
        strength,
        columns,
        noise_ut: world.options().noise_ut,
        log: columns_of(world.run()),
        second: Some(Recording {
            truth: second.truth.body_field_ut.clone(),
            columns: columns_of(second),
            from: 0,
        }),
    })
}

/// Error of a calibration on a recording beyond its noise, µT rms of the vector: in the scale and rotation of the truth, since a log
/// without another sensor knows neither.
fn error_ut(found: &Diagnosis, recording: &Recording, noise_ut: f64) -> Option<f64> {
    let columns = recording.columns.iter().map(|(name, values)| (name.as_str(), values.as_slice()));
    let table = Table::from_columns(columns).ok()?;
    let entries: Vec<_> = found.effects.iter().map(Into::into).collect();
    let corrector =
        Corrector::new(calibrated(found.calibration?, &entries, found.registry).ok()?, &table).ok()?;
    let pairs: Vec<(Vector3<f64>, Vector3<f64>)> = (recording.from..recording.truth.len())
        .filter_map(|row| {
            Some((Vector3::from(corrector.correct(row).ok()?), Vector3::from(*recording.truth.get(row)?)))
        })
        .filter(|(own, truth)| own.iter().chain(truth).all(|value| value.is_finite()))
        .collect();
    let mean = |list: &mut dyn Iterator<Item = f64>| list.sum::<f64>() / pairs.len() as f64;
    let scale = mean(&mut pairs.iter().map(|(_, truth)| truth.norm()))
        / mean(&mut pairs.iter().map(|(own, _)| own.norm()));
    let rotation = best_rotation(&pairs)?;
    let squares = mean(&mut pairs.iter().map(|(own, truth)| (rotation * own * scale - truth).norm_squared()));
    Some((squares - 3.0 * noise_ut.powi(2)).max(0.0).sqrt())
}

/// What became of the logs of one kind and one band of strengths.
#[derive(Default)]
struct Cell {
    logs: u64,
    first: u64,
    exactly: u64,
    tenth_left: u64,
    another: u64,
    /// Error on the second recording over that of the calibration without effects.
    ratios: Vec<f64>,
}

impl Cell {
    fn take(&mut self, case: &Case) -> Option<()> {
        let columns = case.log.iter().map(|(name, values)| (name.as_str(), values.as_slice()));
        let table = Table::from_columns(columns).ok()?;
        let options = Options { search: true, ..Options::default() };
        let found = diagnose(&table, &options).ok()?;
        let is_own = |id: &str| match options.registry.parse(id).filter(|named| named.form.column) {
            Some(named) => named.columns().all(|name| case.columns.iter().any(|own| own == name)),
            None => case.columns.is_empty(),
        };
        let named: Vec<&str> = found.steps.iter().filter_map(|step| step.added.as_deref()).collect();
        let beyond_noise = |rms_ut: f64| (rms_ut.powi(2) - case.noise_ut.powi(2)).max(0.0);
        let without_column = found.levels.as_ref().map(|levels| levels.rms_ut);
        let without_column = without_column.or(found.switching.as_ref().map(|switching| switching.rms_ut));
        let last = without_column.or(found.steps.last().map(|step| step.rms_ut)).unwrap_or(f64::NAN);
        let first = found.steps.first().map_or(f64::NAN, |step| step.rms_ut);
        let is_another = named.iter().any(|id| !is_own(id));
        self.logs += 1;
        self.first += u64::from(named.first().is_some_and(|id| is_own(id)));
        self.exactly += u64::from((!named.is_empty() || without_column.is_some()) && !is_another);
        self.tenth_left += u64::from(beyond_noise(last) < 0.1 * beyond_noise(first));
        self.another += u64::from(is_another);
        if let Some(second) = &case.second {
            let plain = diagnose(&table, &Options { search: false, ..Options::default() }).ok()?;
            let errors = error_ut(&found, second, case.noise_ut).zip(error_ut(&plain, second, case.noise_ut));
            self.ratios.extend(errors.map(|(found, plain)| found / plain));
        }
        Some(())
    }

    fn print(mut self, kind: &str, band: &str) {
        self.ratios.sort_by(f64::total_cmp);
        let at = |share: f64| {
            let place = (share * self.ratios.len().saturating_sub(1) as f64).round() as usize;
            self.ratios.get(place).map_or("-".into(), |ratio| format!("{ratio:.2}"))
        };
        let rate = |count| Rate { count, of: self.logs }.to_string();
        println!(
            "{kind:<26} {band:<6} {:>3}  {:<27} {:>3}  {:<27} {:>3}   {:>5} {:>5}",
            self.logs,
            rate(self.first),
            self.exactly,
            rate(self.tenth_left),
            self.another,
            at(0.5),
            at(0.9)
        );
    }
}

/// Prints the table of `logs` causes of each generator whose name contains one of `only`, after the first `skipped`.
pub fn print(skipped: u64, logs: u64, only: &[String]) {
    for (generator, case) in
        [("second generator", of_second as fn(u64) -> Option<Case>), ("own simulator", of_own)]
    {
        if !only.is_empty() && !only.iter().any(|word| generator.contains(word.as_str())) {
            continue;
        }
        println!("{generator}; error on a second recording over that of the calibration without effects");
        println!(
            "{:<26} {:<6} {:>3}  {:<27} {:>3}  {:<27} {:>3}   {:>5} {:>5}",
            "cause", "noise", "n", "own column first", "all", "a tenth left", "oth", "50 %", "90 %"
        );
        let mut cells: BTreeMap<(String, usize), Cell> = BTreeMap::new();
        for case in (skipped..skipped + logs).filter_map(case) {
            let band = BANDS.iter().filter(|end| case.strength > **end).count();
            cells.entry((case.kind.clone(), band)).or_default().take(&case);
        }
        let [low, high] = BANDS;
        let bands = [format!("<{low}x"), format!("{low}-{high}x"), format!(">{high}x")];
        for ((kind, band), cell) in cells {
            cell.print(&kind, &bands[band]);
        }
    }
}
