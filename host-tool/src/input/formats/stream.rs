//! What a recording holds: columns that share a time base of their own.

use ironout_analysis::frame::Frame;
use ironout_analysis::table::{ATTITUDE, OTHER};

const ANGLES: [&str; 3] = ["roll_deg", "pitch_deg", "yaw_deg"];

/// How a column is read between two of its samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Between {
    /// On the straight line between them.
    #[default]
    Line,
    /// The earlier one holds: switches, modes, commands.
    Hold,
    /// The shorter way round a circle of 360: degrees of longitude.
    Circle,
}

/// One column of a stream, already in the program's unit.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Column {
    /// Its name in the log: `ax_mps2`, `current_a`, …
    pub name: String,
    /// What it is called in the file: `sensor_combined.accelerometer_m_s2[0]`.
    pub source: String,
    /// The unit there.
    pub unit: String,
    /// What a number of the file is multiplied with, but for a sign: its unit in the log's own.
    pub scale: f64,
    /// How it is read between two samples.
    pub between: Between,
    /// One value a sample, NaN where it has none.
    pub values: Vec<f64>,
}

/// Columns on one time base.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Stream {
    /// What the file calls it, with its instance: `battery_status[0]`.
    pub name: String,
    /// Seconds since the beginning of the log; in the order of the file.
    pub time_s: Vec<f64>,
    /// The columns, each as long as the time.
    pub columns: Vec<Column>,
}

impl Stream {
    /// An empty stream.
    pub fn new(name: impl Into<String>) -> Self {
        Stream { name: name.into(), ..Stream::default() }
    }

    /// Adds an empty column whose numbers are in the log's own unit.
    #[must_use]
    pub fn with(self, name: &str, source: &str, unit: &str, between: Between) -> Self {
        self.scaled(name, source, unit, 1.0, between)
    }

    /// Adds an empty column whose numbers are in `unit`, which is `scale` of the log's own.
    #[must_use]
    pub fn scaled(mut self, name: &str, source: &str, unit: &str, scale: f64, between: Between) -> Self {
        self.columns.push(Column {
            name: name.into(),
            source: source.into(),
            unit: unit.into(),
            scale,
            between,
            values: Vec::new(),
        });
        self
    }

    /// The column of that name.
    pub fn column(&self, name: &str) -> Option<&Column> {
        self.columns.iter().find(|column| column.name == name)
    }

    /// Adds one sample; values that are not there are NaN.
    pub fn push(&mut self, time_s: f64, values: &[f64]) {
        self.time_s.push(time_s);
        for (index, column) in self.columns.iter_mut().enumerate() {
            column.values.push(values.get(index).copied().unwrap_or(f64::NAN));
        }
    }

    /// Makes a quaternion of `roll_deg`, `pitch_deg` and `yaw_deg`, where the stream has these.
    pub fn attitude_of_angles(&mut self) {
        let places = ANGLES.map(|name| self.columns.iter().position(|column| column.name == name));
        let [Some(roll), Some(pitch), Some(yaw)] = places else { return };
        let half = |at: usize| -> Vec<(f64, f64)> {
            let values = self.columns.get(at).map(|column| column.values.as_slice()).unwrap_or_default();
            values.iter().map(|degrees| (0.5 * degrees).to_radians().sin_cos()).collect()
        };
        let angles = half(roll).into_iter().zip(half(pitch)).zip(half(yaw));
        let mut made: [Vec<f64>; 4] = Default::default();
        for (((sr, cr), (sp, cp)), (sy, cy)) in angles {
            let quaternion = [
                cr * cp * cy + sr * sp * sy,
                sr * cp * cy - cr * sp * sy,
                cr * sp * cy + sr * cp * sy,
                cr * cp * sy - sr * sp * cy,
            ];
            made.iter_mut().zip(quaternion).for_each(|(column, value)| column.push(value));
        }
        let source = format!("roll, pitch and yaw of {}", self.name);
        self.columns.retain(|column| !ANGLES.contains(&column.name.as_str()));
        for (name, values) in ATTITUDE.into_iter().zip(made) {
            let (name, source) = (name.to_string(), source.clone());
            self.columns.push(Column { name, source, scale: 1.0, values, ..Column::default() });
        }
    }

    /// A quaternion and its negative are one attitude: takes of both the one nearer to the sample before, so that a line between two
    /// samples is the way between them.
    pub fn continuous_attitude(&mut self) {
        let [Some(w), Some(x), Some(y), Some(z)] =
            ATTITUDE.map(|name| self.columns.iter().position(|column| column.name == name))
        else {
            return;
        };
        let Ok([w, x, y, z]) = self.columns.get_disjoint_mut([w, x, y, z]) else { return };
        let mut last: Option<[f64; 4]> = None;
        for (((w, x), y), z) in w.values.iter_mut().zip(&mut x.values).zip(&mut y.values).zip(&mut z.values) {
            let own = [*w, *x, *y, *z];
            let along: f64 = last.map_or(1.0, |last| last.iter().zip(own).map(|(one, two)| one * two).sum());
            let now = if along < 0.0 { own.map(|value| -value) } else { own };
            [*w, *x, *y, *z] = now;
            if now.iter().all(|value| value.is_finite()) {
                last = Some(now);
            }
        }
    }

    /// The three columns of these names, turned by `matrix` in place.
    pub fn turn(&mut self, names: [&str; 3], matrix: &[[f64; 3]; 3]) {
        let [Some(x), Some(y), Some(z)] = names.map(|name| self.columns.iter().position(|c| c.name == name))
        else {
            return;
        };
        let Ok([x, y, z]) = self.columns.get_disjoint_mut([x, y, z]) else { return };
        for ((x, y), z) in x.values.iter_mut().zip(&mut y.values).zip(&mut z.values) {
            let v = [*x, *y, *z];
            [*x, *y, *z] = matrix.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2]);
        }
    }
}

/// A file read: the magnetometer that gives the rows, what else was measured, and what is to be said of it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Recording {
    /// The format in words.
    pub format: String,
    /// The magnetometer: `mx_ut,my_ut,mz_ut` (or `mx_counts,…`) first, then what comes with it.
    pub magnetometer: Stream,
    /// From its numbers in the file to the field in body axes.
    pub frame: Frame,
    /// The rest. Where two columns have one name, the first stream with values in it wins.
    pub others: Vec<Stream>,
    /// What was undone or turned.
    pub taken_out: Vec<String>,
    /// Which of the magnetometers: its number, and all that are there with a word on each.
    pub instance: Option<(usize, Vec<(usize, String)>)>,
    /// Identifier of the vehicle.
    pub vehicle: Option<String>,
    /// Identifier of the magnetometer that was taken.
    pub sensor: Option<String>,
    /// Rows of the magnetometer that could not be used: how many, and why.
    pub left_out: Vec<(usize, String)>,
    /// What the user should know.
    pub notices: Vec<String>,
}

impl Stream {
    /// The field alone, as that of another magnetometer.
    pub fn into_other(mut self) -> Stream {
        self.columns.retain_mut(|column| {
            let place = ["mx_ut", "my_ut", "mz_ut"].iter().position(|name| *name == column.name);
            place.map(|place| column.name = OTHER[place].into()).is_some()
        });
        self
    }
}

/// Speed, course and the error of the speed of a GPS receiver. Only a vehicle on wheels has them: of others a course is no heading.
pub const GROUND: [&str; 3] = ["gps_speed_mps", "gps_course_deg", "gps_speed_error_mps"];

/// Whether another magnetometer is read often enough to be compared.
pub fn is_as_dense(other: &Stream, own: &Stream) -> bool {
    2 * other.time_s.len() > own.time_s.len()
}

/// Takes speed and course out of the streams of a vehicle that is not on wheels.
pub fn without_course(streams: &mut Vec<Stream>) {
    streams
        .iter_mut()
        .for_each(|stream| stream.columns.retain(|column| !GROUND.contains(&column.name.as_str())));
    streams.retain(|stream| !stream.columns.is_empty());
}

/// The instance to read: the one that was asked for, or the first that is there.
///
/// # Errors
/// An instance was asked for that is not there; what is there is named.
pub fn choose(
    wanted: Option<usize>,
    there: &[(usize, String)],
    what: &str,
) -> crate::failure::Outcome<usize> {
    let listing =
        || there.iter().map(|(number, words)| format!("{number} ({words})")).collect::<Vec<_>>().join(", ");
    match (wanted, there.first()) {
        (Some(number), _) if there.iter().any(|(known, _)| *known == number) => Ok(number),
        (None, Some((number, _))) => Ok(*number),
        (Some(number), Some(_)) => Err(crate::failure::Failure::usage(format!(
            "--instance {number}: there is no such {what} in the log. It has {}",
            listing()
        ))),
        (_, None) => Err(crate::failure::Failure::usage(format!("there is no {what} in the log"))),
    }
}
