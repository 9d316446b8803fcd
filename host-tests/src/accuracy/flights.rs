//! Calibrations from ordinary flights, cars, boats and quick turns: offset and motor vector beside the least squares that ArduPilot's MAGFit
//! describes, on logs of the second generator whose attitude or gyro is right or wrong.

use crate::accuracy::snapshot;
use crate::accuracy::truths::in_parallel;
use crate::accuracy::vehicles::{heading_error, shown_beside_true};
use crate::measured;
use ironout_analysis::outcome::request::Purpose;
use ironout_analysis::table::{ATTITUDE, Earth};
use ironout_analysis::{Options, Table, fit};
use nalgebra::{DMatrix, DVector, Matrix3, Quaternion, UnitQuaternion, Vector3};
use second_generator::{Drawn, Kind, draw};
use std::io;
use std::path::PathBuf;

/// What becomes of the attitude and the gyro that a log has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Logged {
    /// As the second generator has it: errors of tilt of 0.2 to 1°, of yaw of 0.7 to 2.5°, that last 4 to 40 s.
    AsDrawn,
    /// Its yaw follows this compass, with a quarter of the field left of the offset.
    SteeredByCompass,
    /// 0.2 s late.
    Late,
    /// Rolled by 4° in its own axes.
    Rolled,
    /// Of a controller that is mounted the other way round.
    TurnedRound,
    /// None.
    Absent,
    /// No attitude, and a gyro with a bias of 0.05 rad/s.
    GyroBiased,
    /// No attitude, and a gyro that is 0.1 s late.
    GyroLate,
}

impl Logged {
    /// All of them.
    pub const ALL: [Logged; 8] = [
        Logged::AsDrawn,
        Logged::SteeredByCompass,
        Logged::Late,
        Logged::Rolled,
        Logged::TurnedRound,
        Logged::Absent,
        Logged::GyroBiased,
        Logged::GyroLate,
    ];

    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Logged::AsDrawn => "attitude as logged",
            Logged::SteeredByCompass => "yaw follows the compass",
            Logged::Late => "attitude 0.2 s late",
            Logged::Rolled => "attitude rolled by 4°",
            Logged::TurnedRound => "attitude turned by 180°",
            Logged::Absent => "no attitude",
            Logged::GyroBiased => "gyro off by 0.05 rad/s",
            Logged::GyroLate => "gyro 0.1 s late",
        }
    }

    fn of(self, drawn: &mut Drawn) {
        let own: Vec<UnitQuaternion<f64>> = quaternions(drawn);
        let truth = drawn.truth.clone();
        let n = own.len();
        let becomes: Vec<UnitQuaternion<f64>> = match self {
            Logged::AsDrawn => own,
            Logged::Absent | Logged::GyroBiased | Logged::GyroLate => Vec::new(),
            Logged::Late => {
                let late = ((0.2 * truth.rate_hz).round() as usize).max(1);
                (0..n).map(|at| own[at.saturating_sub(late)]).collect()
            }
            Logged::Rolled => {
                let roll = UnitQuaternion::from_euler_angles(4.0_f64.to_radians(), 0.0, 0.0);
                own.iter().map(|q| q * roll).collect()
            }
            Logged::TurnedRound => {
                let round = UnitQuaternion::from_euler_angles(0.0, std::f64::consts::PI, 0.0);
                own.iter().map(|q| q * round).collect()
            }
            Logged::SteeredByCompass => {
                // What its heading is wrong by with this much offset left, and the motor's field, slowly followed.
                let left = Vector3::new(0.6, -0.5, 0.62) * 0.25 * truth.field_ut;
                let disturbances = truth.disturbance_ut();
                let inverse = Matrix3::from_fn(|i, j| truth.matrix[i][j]).try_inverse().unwrap_or_default();
                let per_sample = 1.0 - (-1.0 / (2.0 * truth.rate_hz)).exp();
                let mut error = None;
                (0..n)
                    .map(|at| {
                        let to_ned = of(truth.attitude[at]);
                        let seen = Vector3::from(truth.field_body_ut[at])
                            + inverse * (left + Vector3::from(disturbances[at]));
                        let ned = to_ned * seen;
                        let off = ned.y.atan2(ned.x) - truth.declination_deg.to_radians();
                        let off = off.sin().atan2(off.cos());
                        let slow: f64 = error.map_or(off, |last: f64| {
                            last + per_sample * (off - last).sin().atan2((off - last).cos())
                        });
                        error = Some(slow);
                        // The compass shows the field turned by so much, and the estimate turns against it.
                        UnitQuaternion::from_euler_angles(0.0, 0.0, -slow) * own[at]
                    })
                    .collect()
            }
        };
        drawn.columns.retain(|(name, _)| !becomes.is_empty() || !ATTITUDE.contains(&name.as_str()));
        let gyro_late = ((0.1 * truth.rate_hz).round() as usize).max(1);
        for (name, values) in &mut drawn.columns {
            let is_gyro = GYRO.contains(&name.as_str());
            match self {
                Logged::GyroBiased if is_gyro => {
                    values.iter_mut().for_each(|value| *value += GYRO_BIAS_RADPS)
                }
                Logged::GyroLate if is_gyro => {
                    *values = (0..n).map(|at| values[at.saturating_sub(gyro_late)]).collect();
                }
                _ => {}
            }
            let Some(place) = ATTITUDE.iter().position(|own| own == name) else { continue };
            *values = becomes.iter().map(|q| [q.w, q.i, q.j, q.k][place]).collect();
        }
    }
}

const GYRO: [&str; 3] = ["gx_radps", "gy_radps", "gz_radps"];
/// Of each axis: the standard deviation that the fit expects (3°/s).
const GYRO_BIAS_RADPS: f64 = 0.05;

fn of([w, x, y, z]: [f64; 4]) -> UnitQuaternion<f64> {
    UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z))
}

fn quaternions(drawn: &Drawn) -> Vec<UnitQuaternion<f64>> {
    let columns = ATTITUDE.map(|name| drawn.column(name).unwrap_or_default());
    (0..columns[0].len()).map(|at| of(columns.map(|column| column[at]))).collect()
}

/// The truth of a log with its effect's column at its mean.
struct Truth {
    offset_ut: Vector3<f64>,
    /// Offset per unit of the column, and the column's standard deviation.
    motor: Option<(Vector3<f64>, f64)>,
}

impl Truth {
    fn of(drawn: &Drawn) -> Truth {
        let disturbances: Vec<Vector3<f64>> =
            drawn.truth.disturbance_ut().into_iter().map(Vector3::from).collect();
        let n = disturbances.len() as f64;
        let mean = disturbances.iter().sum::<Vector3<f64>>() / n;
        let column = drawn.truth.hidden.first().and_then(|hidden| drawn.column(hidden.columns.first()?));
        let motor = column.filter(|column| column.iter().all(|value| value.is_finite())).map(|column| {
            let middle = column.iter().sum::<f64>() / n;
            let variance = column.iter().map(|value| (value - middle).powi(2)).sum::<f64>() / n;
            let moved: Vector3<f64> =
                disturbances.iter().zip(column).map(|(d, value)| d * (value - middle)).sum();
            (moved / n / variance, variance.sqrt())
        });
        Truth { offset_ut: Vector3::from(drawn.truth.offset_ut) + mean, motor }
    }
}

/// What one method makes of one log.
#[derive(Debug, Clone, Copy)]
pub struct Found {
    /// Error of the offset, µT, and rms of its three errors over the predicted ones.
    pub offset: (f64, Option<f64>),
    /// The same of the motor vector, µT at the standard deviation of the current.
    pub motor: Option<(f64, Option<f64>)>,
    /// Error of a heading while level, degrees, and over the predicted one.
    pub level: (f64, Option<f64>),
}

/// One log.
#[derive(Debug, Clone, Copy)]
pub struct Flight {
    /// The least squares that MAGFit describes.
    pub magfit: Option<Found>,
    /// This program's, where it accepts the log for level headings.
    pub own: Option<Found>,
}

/// An error, and that over the predicted one.
type Pair = (f64, Option<f64>);

/// Offset, matrix and motor vector.
type Solved = ([f64; 3], [[f64; 3]; 3], Vector3<f64>);

/// Least squares of offsets, diagonals, off-diagonals and motor compensation against the field that the attitude says, as ArduPilot's
/// documents describe MAGFit.
fn magfit(drawn: &Drawn, truth: &Truth, column: Option<&[f64]>) -> Option<Solved> {
    let (sine, cosine) = drawn.truth.dip_deg.to_radians().sin_cos();
    let (east, north) = drawn.truth.declination_deg.to_radians().sin_cos();
    let ned = Vector3::new(cosine * north, cosine * east, sine) * drawn.truth.field_ut;
    let attitude = quaternions(drawn);
    let field = ["mx_ut", "my_ut", "mz_ut"].map(|name| drawn.column(name).unwrap_or_default());
    let mean = column.map_or(0.0, |column| column.iter().sum::<f64>() / column.len() as f64);
    let size = if column.is_some() { 12 } else { 9 };
    let (mut normal, mut right) = (DMatrix::<f64>::zeros(size, size), DVector::<f64>::zeros(size));
    for (at, attitude) in attitude.iter().enumerate() {
        let expected = attitude.inverse() * ned;
        let m = field.map(|axis| axis[at]);
        for axis in 0..3 {
            let mut row = DVector::zeros(size);
            row[axis] = m[axis];
            // Off-diagonals xy, xz, yz.
            for (place, (i, j)) in [(0, 1), (0, 2), (1, 2)].into_iter().enumerate() {
                if axis == i {
                    row[3 + place] = m[j];
                } else if axis == j {
                    row[3 + place] = m[i];
                }
            }
            row[6 + axis] = 1.0;
            if let Some(column) = column {
                row[9 + axis] = column[at] - mean;
            }
            normal += &row * row.transpose();
            right += row * expected[axis];
        }
    }
    let solved = normal.cholesky()?.solve(&right);
    let matrix = Matrix3::new(
        solved[0], solved[3], solved[4], solved[3], solved[1], solved[5], solved[4], solved[5], solved[2],
    );
    let inverse = matrix.try_inverse()?;
    let offset = -inverse * Vector3::new(solved[6], solved[7], solved[8]);
    let motor = match truth.motor {
        Some(_) if size == 12 => -inverse * Vector3::new(solved[9], solved[10], solved[11]),
        _ => Vector3::zeros(),
    };
    let rows = std::array::from_fn(|i| std::array::from_fn(|j| matrix[(i, j)]));
    Some((offset.into(), rows, motor))
}

fn ratio(errors: impl Iterator<Item = (f64, f64)>) -> f64 {
    let squares: Vec<f64> = errors.map(|(error, predicted)| (error / predicted).powi(2)).collect();
    (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt()
}

/// One log of the second generator.
pub fn flight(kind: Kind, number: u64, logged: Logged) -> Flight {
    let mut drawn = draw(kind, number);
    logged.of(&mut drawn);
    let truth = Truth::of(&drawn);
    let nothing = Flight { magfit: None, own: None };
    let named = drawn.columns.iter().map(|(name, values)| (name.as_str(), values.as_slice()));
    let Ok(mut table) = Table::from_columns(named) else { return nothing };
    table.earth = Some(Earth {
        field_ut: drawn.truth.field_ut,
        dip_deg: drawn.truth.dip_deg,
        declination_deg: drawn.truth.declination_deg,
    });
    let hidden = drawn.truth.hidden.first();
    let add = hidden.filter(|_| truth.motor.is_some()).map(|hidden| hidden.id.clone());
    let options =
        Options { purpose: Purpose::Tilt(5.0), add: add.into_iter().collect(), ..Options::default() };
    let mut level_truth = drawn.truth.clone();
    level_truth.offset_ut = truth.offset_ut.into();
    let level_drawn = Drawn { columns: Vec::new(), truth: level_truth };
    let shown = shown_beside_true(&drawn, &table);
    let level = |calibration: &ironout::calibration::Calibration<f64>| {
        let errors = heading_error(&level_drawn, calibration, &shown, 0.0);
        let constant = errors.iter().sum::<f64>() / errors.len() as f64;
        (errors.iter().map(|error| (error - constant).powi(2)).sum::<f64>() / errors.len() as f64).sqrt()
    };
    let own = fit(&table, &options).ok().filter(|fitted| fitted.accepted).and_then(|fitted| {
        let solution = fitted.solution?;
        let off = Vector3::from(solution.calibration.offset_ut) - truth.offset_ut;
        let z = ratio((0..3).map(|axis| (off[axis], solution.std_errors.offset_ut[axis])));
        let motor = truth.motor.and_then(|(vector, spread)| {
            let effect = solution.effects.first()?;
            let off = Vector3::from_column_slice(&effect.coefficients) - vector;
            Some((off.norm() * spread, Some(ratio((0..3).map(|axis| (off[axis], effect.std_errors[axis]))))))
        });
        let error = level(&solution.calibration);
        let predicted =
            fitted.holds_for.as_ref().map(|holds| error / holds.heading_errors[0].heading_error_deg);
        Some(Found { offset: (off.norm(), Some(z)), motor, level: (error, predicted) })
    });
    let column =
        hidden.and_then(|hidden| drawn.column(hidden.columns.first()?)).filter(|_| truth.motor.is_some());
    let has_attitude = drawn.column(ATTITUDE[0]).is_some();
    let magfit =
        has_attitude.then(|| magfit(&drawn, &truth, column)).flatten().map(|(offset, matrix, motor)| {
            let calibration = ironout::calibration::Calibration {
                offset_ut: offset,
                matrix,
                field_ut: drawn.truth.field_ut,
            };
            Found {
                offset: ((Vector3::from(offset) - truth.offset_ut).norm(), None),
                motor: truth.motor.map(|(vector, spread)| ((motor - vector).norm() * spread, None)),
                level: (level(&calibration), None),
            }
        });
    Flight { magfit, own }
}

/// Median, ninth tenth, and rms of ratios.
fn line(values: &[(f64, Option<f64>)]) -> String {
    let mut sizes: Vec<f64> = values.iter().map(|value| value.0).collect();
    sizes.sort_by(f64::total_cmp);
    let at = |share: f64| sizes.get((share * sizes.len().saturating_sub(1) as f64).round() as usize);
    let ratios: Vec<f64> = values.iter().filter_map(|value| value.1).collect();
    let rms = (ratios.iter().map(|value| value * value).sum::<f64>() / ratios.len().max(1) as f64).sqrt();
    let said = |value: Option<&f64>| value.map_or_else(|| "-".to_string(), |value| format!("{value:.2}"));
    let beyond = ratios.iter().filter(|ratio| **ratio > 3.0).count();
    let ratio = if ratios.is_empty() { "-".to_string() } else { format!("{rms:.2}") };
    let beyond = if ratios.is_empty() { "-".to_string() } else { beyond.to_string() };
    format!("{:>7}{:>7}{ratio:>7}{beyond:>4}", said(at(0.5)), said(at(0.9)))
}

/// Logs of a table.
pub const LOGS: u64 = 40;
/// Numbers apart from those on which the fit was made (7000 to 7059).
const FIRST: u64 = 8400;

/// The methods of the table; the last is the first on those logs that the fit accepts.
const METHODS: [&str; 3] = ["MAGFit", "fit", "MAGFit*"];

/// Kinds of the table with what their logs have.
const ROWS: [(Kind, &[Logged]); 4] = {
    use Logged::{Absent, AsDrawn, GyroBiased, GyroLate, Late, Rolled};
    [
        (Kind::Flight, &Logged::ALL),
        (Kind::Car, &[AsDrawn, Late, Rolled, Absent, GyroBiased, GyroLate]),
        (Kind::Boat, &[AsDrawn, Late, Rolled, Absent, GyroBiased, GyroLate]),
        (Kind::Quick, &[AsDrawn, Absent]),
    ]
};

/// The logs of a table, by kind and attitude.
pub struct Flights(Vec<(Kind, Logged, Vec<Flight>)>);

impl Flights {
    /// Runs so many flights with each attitude; `say` hears each as it begins.
    pub fn measure(first: u64, logs: u64, say: impl Fn(&str)) -> Self {
        let rows = ROWS.iter().flat_map(|(kind, list)| list.iter().map(|logged| (*kind, *logged)));
        Flights(
            rows.map(|(kind, logged)| {
                say(&format!("{}: {}", kind.name(), logged.words()));
                (kind, logged, in_parallel(first..first + logs, |number| flight(kind, number, logged)))
            })
            .collect(),
        )
    }

    /// The same as the document has it.
    pub fn unseen(say: impl Fn(&str)) -> Self {
        Self::measure(FIRST, LOGS, say)
    }

    /// What the snapshot holds: a line an attitude and method.
    pub fn text(&self) -> String {
        let mut text = format!(
            "{:<8}{:<26}{:<8}{:>5}  {:>7}{:>7}{:>7}{:>4}  {:>7}{:>7}{:>7}{:>4}  {:>7}{:>7}{:>7}{:>4}\n",
            "kind",
            "attitude",
            "method",
            "n",
            "offset",
            "90 %",
            "z rms",
            ">3",
            "motor",
            "90 %",
            "z rms",
            ">3",
            "level °",
            "90 %",
            "ratio",
            ">3"
        );
        for (kind, logged, flights) in &self.0 {
            for method in METHODS {
                let pick = |flight: &Flight| match method {
                    "MAGFit" => flight.magfit,
                    "fit" => flight.own,
                    _ => flight.own.and(flight.magfit),
                };
                let list: Vec<Found> = flights.iter().filter_map(pick).collect();
                if list.is_empty() {
                    continue;
                }
                let of = |pick: &dyn Fn(&Found) -> Option<Pair>| -> Vec<Pair> {
                    list.iter().filter_map(pick).collect()
                };
                text += &format!(
                    "{:<8}{:<26}{method:<8}{:>5}  {}  {}  {}\n",
                    kind.name(),
                    logged.words(),
                    list.len(),
                    line(&of(&|found| Some(found.offset))),
                    line(&of(&|found| found.motor)),
                    line(&of(&|found| Some(found.level)))
                );
            }
        }
        text
    }

    /// Where the snapshot lies.
    pub fn snapshot_path() -> PathBuf {
        PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/snapshots/flights.txt"))
    }

    /// Writes the snapshot and the table of the document.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn store(&self) -> io::Result<()> {
        std::fs::write(Self::snapshot_path(), self.text())?;
        measured::write(&[("accuracy-flights", self.text())])
    }

    /// Holds the table to its snapshot.
    ///
    /// # Errors
    /// It differs, or there is no snapshot.
    pub fn hold(&self) -> io::Result<()> {
        snapshot::hold(&Self::snapshot_path(), &self.text())
    }
}
