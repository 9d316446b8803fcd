//! Headings of vehicles that are not turned over: what a fit for their attitudes gives, on logs of the second generator.

use crate::accuracy::snapshot;
use crate::accuracy::truths::in_parallel;
use crate::measured;
use crate::rate::Rate;
use ironout::calibration::Calibration;
use ironout_analysis::confined::guided::{KnownHeading, attitude, of_course};
use ironout_analysis::outcome::request::Purpose;
use ironout_analysis::samples::samples::Samples;
use ironout_analysis::table::ATTITUDE;
use ironout_analysis::{Options, Table, fit};
use nalgebra::{Matrix3, Quaternion, Rotation3, UnitQuaternion, Vector3};
use second_generator::{Drawn, Kind, draw};
use serde_json::{Value, json};
use std::f64::consts::TAU;
use std::io;
use std::path::PathBuf;

/// Logs of each kind.
pub const LOGS: u64 = 40;
/// Numbers apart from those on which the fit was made (7000 to 7039).
const FIRST: u64 = 8100;
/// An error is beyond what is predicted above so many standard deviations.
const MAX_ERRORS_PREDICTED: f64 = 3.0;
const KINDS: [Kind; 3] = [Kind::Flight, Kind::Car, Kind::Boat];
/// Times of the known headings, as shares of the log, and their error, degrees (1σ): a runway, a quay, a compass beside the vehicle.
const KNOWN_AT: [f64; 3] = [0.15, 0.5, 0.85];
const KNOWN_ERROR_DEG: f64 = 2.0;
/// What a GPS receiver says of a car, and the standard deviation of its course, degrees.
const SPEED_MPS: f64 = 8.0;
const COURSE_ERROR_DEG: f64 = 1.0;
/// Headings, and directions to tilt to.
const HEADINGS: usize = 24;
const TILTS: usize = 8;

/// Where the yaw comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Yaw {
    /// The autopilot's attitude.
    Logged,
    /// Nowhere.
    Unknown,
    /// Three known headings.
    Known,
    /// The course of a GPS receiver.
    Course,
}

/// The kinds with an attitude as it was drawn, and those without one next to those with headings.
const ROWS: [(&str, Kind, Yaw); 8] = [
    ("flight", KINDS[0], Yaw::Logged),
    ("car", KINDS[1], Yaw::Logged),
    ("boat", KINDS[2], Yaw::Logged),
    ("car, no attitude", KINDS[1], Yaw::Unknown),
    ("car, 3 headings", KINDS[1], Yaw::Known),
    ("car, GPS course", KINDS[1], Yaw::Course),
    ("boat, no attitude", KINDS[2], Yaw::Unknown),
    ("boat, 3 headings", KINDS[2], Yaw::Known),
];

/// One log.
#[derive(Debug, Clone, Copy)]
pub struct Judged {
    /// Whether a calibration for all attitudes is accepted.
    all: bool,
    /// True and predicted error of a heading while level and at the tilts that the calibration is for, degrees rms; `None` where it is
    /// refused or for all attitudes.
    headings: Option<[(f64, f64); 2]>,
}

/// The specific force that a log shows beside the true direction down, in the mean.
pub(super) fn shown_beside_true(drawn: &Drawn, table: &Table) -> (Vector3<f64>, Vector3<f64>) {
    let samples = Samples::take(table, &vec![false; table.rows()], [true; 3]);
    let (mut beside, mut mean, mut count) = (Vector3::zeros(), Vector3::zeros(), 0.0_f64);
    for (reading, row) in samples.readings.iter().zip(&samples.row) {
        let [w, x, y, z] = drawn.truth.attitude[*row];
        let down = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)).inverse() * Vector3::z();
        let Some(shown) = reading.down else { continue };
        beside += Vector3::from(shown) - down;
        mean += Vector3::from(shown);
        count += 1.0;
    }
    (beside / count.max(1.0), mean.normalize())
}

/// True error of headings at this tilt, degrees rms about `constant`, and their mean.
pub(super) fn heading_error(
    drawn: &Drawn,
    calibration: &Calibration<f64>,
    shown: &(Vector3<f64>, Vector3<f64>),
    tilt: f64,
) -> Vec<f64> {
    let truth = &drawn.truth;
    let soft = Matrix3::from_fn(|i, j| truth.matrix[i][j]);
    let (sine, cosine) = truth.dip_deg.to_radians().sin_cos();
    let field = Vector3::new(cosine, 0.0, sine) * truth.field_ut;
    let (beside, mean) = shown;
    let upright = Rotation3::rotation_between(mean, &Vector3::z()).unwrap_or_else(Rotation3::identity);
    let turn = |part: usize, of: usize| TAU * part as f64 / of as f64;
    let attitudes = (0..HEADINGS)
        .flat_map(|heading| (0..TILTS).map(move |way| (turn(heading, HEADINGS), turn(way, TILTS))));
    attitudes
        .map(|(heading, way)| {
            let lean = Rotation3::new(Vector3::new(way.cos(), way.sin(), 0.0) * tilt.to_radians());
            let to_world = Rotation3::from_euler_angles(0.0, 0.0, heading) * lean * upright;
            let reading = soft * (to_world.inverse() * field) + Vector3::from(truth.offset_ut);
            let corrected = Vector3::from(calibration.apply(reading.into()));
            let down = (to_world.inverse() * Vector3::z() + beside).normalize();
            let east = to_world.inverse() * Vector3::y();
            down.dot(&east.cross(&down.cross(&corrected).normalize())).clamp(-1.0, 1.0).asin().to_degrees()
        })
        .collect()
}

/// A number from about −1.7 to 1.7 with a standard deviation of one.
fn even(number: u64, place: u64) -> f64 {
    let mixed = (number.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ place.wrapping_mul(0xD1B5_4A32_D192_ED03))
        .wrapping_mul(0x94D0_49BB_1331_11EB);
    12f64.sqrt() * ((mixed >> 40) as f64 / (1_u64 << 24) as f64 - 0.5)
}

/// The log with its yaw from elsewhere.
fn with_yaw(mut drawn: Drawn, number: u64, yaw: Yaw) -> Drawn {
    if yaw == Yaw::Logged {
        return drawn;
    }
    drawn.columns.retain(|(name, _)| !ATTITUDE.contains(&name.as_str()));
    let named = drawn.columns.iter().map(|(name, values)| (name.as_str(), values.as_slice()));
    let Ok(table) = Table::from_columns(named) else { return drawn };
    let rows = table.rows();
    let heading_deg = |row: usize| {
        let [w, x, y, z] = drawn.truth.attitude[row];
        f64::atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)).to_degrees()
    };
    let known = match (yaw, table.time_s) {
        (Yaw::Known, Some(time_s)) => KNOWN_AT
            .map(|share| (share * rows as f64) as usize)
            .map(|row| KnownHeading {
                time_s: time_s[row],
                heading_deg: heading_deg(row) + KNOWN_ERROR_DEG * even(number, row as u64),
            })
            .to_vec(),
        (Yaw::Course, _) => {
            let course = |row: usize| heading_deg(row) + COURSE_ERROR_DEG * even(number, row as u64);
            of_course(&table, &(0..rows).map(course).collect::<Vec<_>>(), &vec![SPEED_MPS; rows], None)
        }
        _ => return drawn,
    };
    if let Some(columns) = attitude(&table, &known) {
        drawn.columns.extend(ATTITUDE.into_iter().map(str::to_owned).zip(columns));
    }
    drawn
}

/// One log of the second generator.
pub fn judged(kind: Kind, number: u64, yaw: Yaw) -> Judged {
    let drawn = with_yaw(draw(kind, number), number, yaw);
    let named = drawn.columns.iter().map(|(name, values)| (name.as_str(), values.as_slice()));
    let refused = Judged { all: false, headings: None };
    let Ok(table) = Table::from_columns(named) else { return refused };
    let of = |purpose| {
        fit(&table, &Options { purpose, ..Options::default() }).ok().filter(|fitted| fitted.accepted)
    };
    if of(Purpose::All).is_some() {
        return Judged { all: true, headings: None };
    }
    let Some(fitted) = of(Purpose::AsShown) else { return refused };
    let (Some(holds_for), Some(solution)) = (&fitted.holds_for, &fitted.solution) else { return refused };
    let shown = shown_beside_true(&drawn, &table);
    let errors = |tilt| heading_error(&drawn, &solution.calibration, &shown, tilt);
    let level = errors(0.0);
    let constant = level.iter().sum::<f64>() / level.len() as f64;
    let rms = |errors: &[f64]| {
        (errors.iter().map(|error| (error - constant).powi(2)).sum::<f64>() / errors.len() as f64).sqrt()
    };
    let tilted = (rms(&errors(holds_for.tilt_deg)), fitted.heading_error_deg.unwrap_or(f64::NAN));
    Judged {
        all: false,
        headings: Some([(rms(&level), holds_for.heading_errors[0].heading_error_deg), tilted]),
    }
}

/// One kind.
struct Row<'a> {
    kind: &'a str,
    all: Rate,
    shown: Rate,
    /// While level and tilted: median and greatest true error, rms of true over predicted, how many are beyond.
    errors: [(f64, f64, f64, Rate); 2],
}

/// The table, a line a kind.
pub struct Vehicles(Vec<(String, Vec<Judged>)>);

impl Vehicles {
    /// Runs so many logs of each kind; `say` hears each kind as it begins.
    pub fn measure(logs: u64, say: impl Fn(&str)) -> Self {
        let of = |(name, kind, yaw): (&str, Kind, Yaw)| {
            say(name);
            (name.to_owned(), in_parallel(FIRST..FIRST + logs, |number| judged(kind, number, yaw)))
        };
        Vehicles(ROWS.map(of).into())
    }

    fn rows(&self) -> impl Iterator<Item = Row<'_>> {
        self.0.iter().map(|(kind, logs)| {
            let of = logs.len() as u64;
            let errors = [0, 1].map(|place| {
                let mut pairs: Vec<(f64, f64)> =
                    logs.iter().filter_map(|one| Some(one.headings?[place])).collect();
                pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
                let n = pairs.len();
                let ratios = pairs.iter().map(|(error, predicted)| error / predicted);
                let beyond = ratios.clone().filter(|ratio| *ratio > MAX_ERRORS_PREDICTED).count() as u64;
                (
                    pairs.get(n / 2).map_or(f64::NAN, |pair| pair.0),
                    pairs.last().map_or(f64::NAN, |pair| pair.0),
                    (ratios.map(|ratio| ratio * ratio).sum::<f64>() / n.max(1) as f64).sqrt(),
                    Rate { count: beyond, of: n as u64 },
                )
            });
            Row {
                kind,
                all: Rate { count: logs.iter().filter(|one| one.all).count() as u64, of },
                shown: Rate { count: logs.iter().filter(|one| one.headings.is_some()).count() as u64, of },
                errors,
            }
        })
    }

    /// What the snapshot holds.
    pub fn text(&self) -> String {
        let mut text = format!(
            "{:<18}{:<28}{:<28}{:>8}{:>8}{:>7}  {:<26}{:>8}{:>8}{:>7}  beyond 3\n",
            "kind",
            "for all attitudes",
            "for those shown",
            "level °",
            "worst °",
            "rms",
            "beyond 3",
            "tilted °",
            "worst °",
            "rms"
        );
        for Row { kind, all, shown, errors } in self.rows() {
            let [level, tilted] = errors.map(|(median, worst, rms, beyond)| {
                format!("{median:>8.2}{worst:>8.2}{rms:>7.2}  {:<26}", beyond.to_string())
            });
            text += &format!(
                "{kind:<18}{:<28}{:<28}{level}{}\n",
                all.to_string(),
                shown.to_string(),
                tilted.trim_end()
            );
        }
        text
    }

    /// One object a kind.
    pub fn json(&self) -> Value {
        let of = |rate: Rate| json!({ "count": rate.count, "of": rate.of });
        let rows = self.rows().map(|row| {
            let [level, tilted] = row.errors.map(|(median, worst, rms, beyond)| {
                json!({ "median_deg": median, "worst_deg": worst, "rms_of_true_over_predicted": rms, "beyond_3": of(beyond) })
            });
            json!({
                "kind": row.kind, "accepted_for_all": of(row.all), "accepted_for_shown": of(row.shown), "level": level, "tilted": tilted,
            })
        });
        rows.collect()
    }

    /// Where the snapshot lies.
    pub fn snapshot_path() -> PathBuf {
        PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/snapshots/vehicles.txt"))
    }

    /// Writes the snapshot and the table of the document.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn store(&self) -> io::Result<()> {
        std::fs::write(Self::snapshot_path(), self.text())?;
        measured::write(&[("accuracy-vehicles", self.text())])
    }

    /// Holds the table to its snapshot.
    ///
    /// # Errors
    /// It differs, or there is no snapshot.
    pub fn hold(&self) -> io::Result<()> {
        snapshot::hold(&Self::snapshot_path(), &self.text())
    }
}
