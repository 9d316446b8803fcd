//! Effects put into real recordings: their noise, their motion and what nobody knows of them stay, and beside the cause stand columns
//! that cause nothing. The recordings lie in `shared/data` beside the project; where they do not, there are no such rows.

use crate::accuracy::truths::{Outcome, each, rate};
use crate::rate::Rate;
use ironout_analysis::outcome::outcome::Verdict;
use ironout_analysis::{Options, Table, fit};
use nalgebra::Vector3;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use std::path::Path;

/// A recording, or all of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// HMC5883L over nearly the whole sphere.
    Sphere,
    /// HMC5883L, tilted.
    Tilt,
    /// QMC5883L, filtered.
    Filtered,
    /// Turned by hand, without a column of time.
    Timeless,
    /// A quadrotor in level flight.
    Flight,
    /// All of them in turn with nothing put in.
    Untouched,
}

/// Effects that are put in.
const EFFECTS: [&str; 6] = [
    "offset:current_a",
    "offset:board_temp_c",
    "offset:throttle",
    "gain:board_temp_c",
    "offset:current_a^2",
    "step",
];
/// Columns that are laid beside every recording.
const LAID: [&str; 4] = ["current_a", "board_temp_c", "throttle", "mode"];
/// The error of a recording that has no base of its own, µT.
const UNKNOWN_UT: f64 = 0.5;
/// No effect is larger, µT rms, ...
const MOST_UT: f64 = 10.0;
/// ... nor anywhere than this share of the field.
const MOST_SHARE: f64 = 0.2;

impl Source {
    /// All, in the order of the table.
    pub const ALL: [Source; 6] =
        [Source::Sphere, Source::Tilt, Source::Filtered, Source::Timeless, Source::Flight, Source::Untouched];

    /// A word for it.
    pub const fn name(self) -> &'static str {
        match self {
            Source::Sphere => "real-sphere",
            Source::Tilt => "real-tilt",
            Source::Filtered => "real-filtered",
            Source::Timeless => "real-timeless",
            Source::Flight => "real-flight",
            Source::Untouched => "real-untouched",
        }
    }

    /// Its file, and µT a count where it has counts.
    fn file(self, number: u64) -> (&'static str, f64) {
        const OTHERS: [(&str, f64); 3] = [
            ("hmc5883l-mpu6050-roll-and-tilt-at-45-90.csv", 1.0),
            ("imu-gnss-board.csv", 0.1),
            ("lsm9ds1-hand-outliers.csv", 1.0),
        ];
        match self {
            Source::Sphere => ("hmc5883l-mpu6050-full-sphere.csv", 1.0),
            Source::Tilt => ("hmc5883l-mpu6050-tilt-sphere.csv", 1.0),
            Source::Filtered => ("qmc5883l-filtered.csv", 0.0333),
            Source::Timeless => ("hand-rotated-counts.csv", 0.1),
            Source::Flight => ("px4-quad-flight.csv", 1.0),
            Source::Untouched => match (number % 8) as usize {
                place @ 0..5 => Source::ALL[place].file(0),
                place => OTHERS[place - 5],
            },
        }
    }
}

/// Columns of a recording by name, µT for the field.
pub type Columns = Vec<(String, Vec<f64>)>;

/// Reads a recording; `None` where it is not there.
fn read(file: &str, ut_per_count: f64) -> Option<Columns> {
    let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/data")).join(file);
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_path(path).ok()?;
    let names: Vec<String> = reader.headers().ok()?.iter().map(str::to_owned).collect();
    let mut columns: Columns = names.into_iter().map(|name| (name, Vec::new())).collect();
    for record in reader.records() {
        for ((_, values), word) in columns.iter_mut().zip(record.ok()?.iter()) {
            values.push(word.trim().parse().unwrap_or(f64::NAN));
        }
    }
    for (name, values) in &mut columns {
        if let Some(axis) = name.strip_suffix("_counts") {
            *name = format!("{axis}_ut");
            values.iter_mut().for_each(|value| *value *= ut_per_count);
        }
    }
    Some(columns)
}

fn normal(rng: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(rng)
}

/// A current that is on and off, for two to fifteen seconds each.
fn current_a(t_s: &[f64], rng: &mut ChaCha8Rng) -> Vec<f64> {
    let (mut until_s, mut level) = (f64::NEG_INFINITY, 0.0);
    let each = t_s.iter().map(|&t| {
        if t >= until_s {
            until_s = t + rng.random_range(2.0..15.0);
            level = if level > 0.5 { 0.0 } else { rng.random_range(2.0..10.0) };
        }
        let noise = 0.05 * (1.0 + level) * normal(rng);
        (100.0 * (level + noise)).round() / 100.0
    });
    each.collect()
}

/// A board that warms up, with a slow wander.
fn board_temp_c(t_s: &[f64], rng: &mut ChaCha8Rng) -> Vec<f64> {
    let whole_s = t_s.last().unwrap_or(&1.0) - t_s.first().unwrap_or(&0.0);
    let (rise, after_s, waves) =
        (rng.random_range(3.0..20.0), whole_s * rng.random_range(0.1..0.5), rng.random_range(0.5..4.0));
    let (share, phase) = (rng.random_range(0.1..0.6), rng.random_range(0.0..std::f64::consts::TAU));
    let begin_s = t_s.first().copied().unwrap_or(0.0);
    let each = t_s.iter().map(|t| {
        let t = t - begin_s;
        let wave = share * (std::f64::consts::TAU * waves * t / whole_s + phase).sin();
        (10.0 * (22.0 + rise * (1.0 - (-t / after_s).exp() + wave))).round() / 10.0
    });
    each.collect()
}

/// A lever that somebody moves: a walk that comes back.
fn throttle(t_s: &[f64], rng: &mut ChaCha8Rng) -> Vec<f64> {
    let (time_s, mut value, mut last) = (rng.random_range(1.0..12.0), 0.5, None);
    let each = t_s.iter().map(|&t| {
        let step_s: f64 = last.map_or(0.0, |last: f64| (t - last).max(0.0));
        last = Some(t);
        let keep = (-step_s / time_s).exp();
        value = 0.5 + (value - 0.5) * keep + 0.18 * (1.0 - keep * keep).sqrt() * normal(rng);
        value
    });
    each.collect()
}

/// A mode that changes a few times.
fn mode(t_s: &[f64], rng: &mut ChaCha8Rng) -> Vec<f64> {
    let (begin_s, end_s) = (t_s.first().copied().unwrap_or(0.0), t_s.last().copied().unwrap_or(1.0));
    let mut changes: Vec<f64> =
        (0..rng.random_range(1..6)).map(|_| rng.random_range(begin_s..end_s)).collect();
    changes.sort_by(f64::total_cmp);
    t_s.iter().map(|t| (changes.partition_point(|change| change < t) % 3) as f64).collect()
}

/// A part of a recording with columns laid beside it, the effect that was put in, and the words for it.
struct Drawn {
    columns: Columns,
    hidden: Vec<String>,
    words: String,
}

/// The laid column that an effect follows.
pub fn laid_column(id: &str) -> Option<&str> {
    let (_, of) = id.split_once(':')?;
    let name = of.split(['^', '@']).next()?;
    LAID.contains(&name).then_some(name)
}

fn column<'a>(columns: &'a Columns, name: &str) -> Option<&'a [f64]> {
    columns.iter().find(|(own, _)| own == name).map(|(_, values)| values.as_slice())
}

fn table(columns: &Columns) -> Option<Table<'_>> {
    Table::from_columns(columns.iter().map(|(name, values)| (name.as_str(), values.as_slice()))).ok()
}

impl Source {
    fn draw(self, number: u64) -> Option<Drawn> {
        let (file, ut_per_count) = self.file(number);
        let mut columns = read(file, ut_per_count)?;
        let mut rng = ChaCha8Rng::seed_from_u64(number ^ ((self as u64) << 32) ^ 0x1a7e);
        let rows = columns.first()?.1.len();
        // A part of it, so that no two are the same motion.
        let length = if rows > 1000 { (rows as f64 * rng.random_range(0.6..1.0)) as usize } else { rows };
        let begin = rng.random_range(0..=rows - length);
        for (_, values) in &mut columns {
            *values = values[begin..begin + length].to_vec();
        }
        let t_s: Vec<f64> = match column(&columns, "t_s") {
            Some(t_s) => t_s.to_vec(),
            // By hand some twenty times a second.
            None => (0..length).map(|row| 0.05 * row as f64).collect(),
        };
        let laid = [
            current_a(&t_s, &mut rng),
            board_temp_c(&t_s, &mut rng),
            throttle(&t_s, &mut rng),
            mode(&t_s, &mut rng),
        ];
        let mut drawn = Drawn { columns, hidden: Vec::new(), words: format!("{file} {begin}+{length}") };
        if self != Source::Untouched {
            // Without a column of time nothing can be said of a step.
            let timed = column(&drawn.columns, "t_s").is_some();
            let ids: Vec<&str> = EFFECTS.into_iter().filter(|id| timed || *id != "step").collect();
            let id = ids[rng.random_range(0..ids.len())];
            drawn.put(id, &t_s, &laid, &mut rng)?;
        }
        drawn.columns.extend(LAID.iter().map(|name| (*name).to_owned()).zip(laid));
        Some(drawn)
    }

    fn outcome(self, number: u64) -> Option<Outcome> {
        let drawn = self.draw(number)?;
        let table = table(&drawn.columns)?;
        Some(Outcome::diagnosed(number, drawn.words, drawn.hidden, &table, f64::NAN))
    }

    /// The first so many logs; none where the recordings are not there.
    pub fn run(self, logs: u64, say: impl Fn(&Outcome) + Sync) -> Vec<Outcome> {
        if self.draw(0).is_none() {
            return Vec::new();
        }
        each(0..logs, |number| self.outcome(number).expect("a recording that was there before"), say)
    }

    /// The figures, each with what it says.
    pub fn rates(self, list: &[Outcome]) -> Vec<(&'static str, Rate)> {
        // What a recording has of its own may be named beside it.
        let accuses = |one: &Outcome, id: &String| {
            laid_column(id).is_some_and(|of| one.hidden.iter().all(|own| laid_column(own) != Some(of)))
        };
        let accused = |one: &Outcome| one.named.iter().any(|id| accuses(one, id));
        let listed = |one: &Outcome| accused(one) || one.confounded.iter().any(|id| accuses(one, id));
        let reshaped = |one: &Outcome| {
            let own = |id: &String| laid_column(id).is_some() && !accuses(one, id);
            one.named.iter().any(|id| own(id) && !one.hidden.contains(id))
        };
        match self {
            Source::Untouched => vec![
                ("an unrelated column named", rate(list, accused)),
                ("named, or said to be one of several", rate(list, listed)),
            ],
            _ => vec![
                ("named first", rate(list, Outcome::first)),
                (
                    "named first, or undetermined",
                    rate(list, |one| {
                        one.first() || (one.named.is_empty() && one.verdict == Some(Verdict::Undetermined))
                    }),
                ),
                ("an unrelated column named", rate(list, accused)),
                ("its own column in another shape", rate(list, reshaped)),
            ],
        }
    }

    /// One of its logs as text, the hidden effect in the first line; `None` where the recording is not there.
    pub fn csv(self, number: u64) -> Option<String> {
        let drawn = self.draw(number)?;
        let mut text = format!("# {}\n", drawn.words);
        let names: Vec<&str> = drawn.columns.iter().map(|(name, _)| name.as_str()).collect();
        text += &names.join(",");
        for row in 0..drawn.columns.first()?.1.len() {
            let cells: Vec<String> =
                drawn.columns.iter().map(|(_, values)| format!("{:.6}", values[row])).collect();
            text += "\n";
            text += &cells.join(",");
        }
        Some(text + "\n")
    }

    /// The columns of one of its logs, and the effects that were put in; `None` where the recording is not there.
    pub fn columns(self, number: u64) -> Option<(Columns, Vec<String>)> {
        self.draw(number).map(|drawn| (drawn.columns, drawn.hidden))
    }

    /// The lines of the table.
    pub fn text(self, list: &[Outcome]) -> String {
        let lines = self.rates(list).into_iter().filter(|_| !list.is_empty());
        lines.map(|(what, rate)| format!("{:<16} {what:<36} {rate}\n", self.name())).collect()
    }
}

impl Drawn {
    /// Puts an effect in, 2 to 12 times the error that the recording has by itself.
    fn put(&mut self, id: &str, t_s: &[f64], laid: &[Vec<f64>; 4], rng: &mut ChaCha8Rng) -> Option<()> {
        let base = fit(&table(&self.columns)?, &Options::default()).ok();
        let base = base.and_then(|fitted| fitted.solution);
        let axes: Vec<&[f64]> = ["mx_ut", "my_ut", "mz_ut"]
            .iter()
            .map(|name| column(&self.columns, name))
            .collect::<Option<_>>()?;
        let middle = |values: &[f64]| {
            let (least, most) = values.iter().fold((f64::MAX, f64::MIN), |(a, b), v| (a.min(*v), b.max(*v)));
            0.5 * (least + most)
        };
        let (offset, unit_ut) = match &base {
            Some(solution) => (solution.calibration.offset_ut, solution.rms_ut),
            None => ([middle(axes[0]), middle(axes[1]), middle(axes[2])], UNKNOWN_UT),
        };
        let field: Vec<Vector3<f64>> =
            (0..t_s.len()).map(|row| Vector3::from_fn(|axis, _| axes[axis][row] - offset[axis])).collect();
        let [current, warm, lever, _] = laid;
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let step_s = t_s[(t_s.len() as f64 * rng.random_range(0.3..0.7)) as usize];
        let shape: Vec<f64> = match id {
            "offset:current_a" => current.clone(),
            "offset:current_a^2" => current.iter().map(|value| value * value).collect(),
            "offset:throttle" => lever.clone(),
            "step" => t_s.iter().map(|t| f64::from(u8::from(*t >= step_s))).collect(),
            _ => warm.iter().map(|value| value - mean(warm)).collect(),
        };
        let direction = Vector3::from_fn(|_, _| normal(rng)).normalize();
        let added: Vec<Vector3<f64>> = (0..t_s.len())
            .map(|row| {
                let along =
                    if id.starts_with("gain:") { direction.component_mul(&field[row]) } else { direction };
                along * shape[row]
            })
            .collect();
        // What it does to the magnitude, beside what a constant offset does.
        let common = added.iter().sum::<Vector3<f64>>() / added.len() as f64;
        let radial: Vec<f64> =
            added.iter().zip(&field).map(|(own, field)| (own - common).dot(&field.normalize())).collect();
        let level = mean(&radial);
        let rms = (radial.iter().map(|one| (one - level).powi(2)).sum::<f64>() / radial.len() as f64).sqrt();
        let strength = rng.random_range(2.0_f64.ln()..12.0_f64.ln()).exp();
        let field_ut = mean(&field.iter().map(Vector3::norm).collect::<Vec<_>>());
        let peak = added.iter().map(|own| (own - common).norm()).fold(0.0, f64::max);
        let size = ((strength * unit_ut).min(MOST_UT) / rms).min(MOST_SHARE * field_ut / peak);
        for (name, values) in &mut self.columns {
            let Some(axis) = ["mx_ut", "my_ut", "mz_ut"].iter().position(|own| own == name) else { continue };
            values.iter_mut().zip(&added).for_each(|(value, added)| *value += size * added[axis]);
        }
        self.hidden = vec![id.to_owned()];
        self.words += &format!(" {id} {strength:.1} times {unit_ut:.2} uT");
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_put_in_is_in_the_log_and_the_rest_is_as_recorded() {
        let Some(drawn) = Source::Sphere.draw(1) else {
            eprintln!("SKIPPED: the recordings are not here");
            return;
        };
        let plain = read(Source::Sphere.file(1).0, 1.0).expect("it was there");
        assert_eq!(drawn.hidden.len(), 1);
        let same = |name: &str| {
            let (own, recorded) = (column(&drawn.columns, name).unwrap(), column(&plain, name).unwrap());
            recorded.windows(own.len()).any(|part| part == own)
        };
        assert!(same("t_s") && same("az_mps2") && !same("mx_ut"));
        assert_eq!(drawn.words, Source::Sphere.draw(1).unwrap().words, "it comes again");
        assert!(LAID.iter().all(|name| column(&drawn.columns, name).is_some()));
    }
}
