//! `--rotate`: from the axes a sensor is mounted with to the body frame (x forward, y right, z down).

use crate::failure::{Failure, Outcome};

/// Which of the three sensors a rotation is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sensor {
    /// The magnetometer.
    Magnetometer,
    /// The accelerometer.
    Accelerometer,
    /// The gyroscope.
    Gyroscope,
}

/// An orthogonal matrix per sensor, applied as body = R·sensor; `None` leaves the axes alone.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Mounting {
    /// For the magnetometer.
    pub magnetometer: Option<[[f64; 3]; 3]>,
    /// For the accelerometer.
    pub accelerometer: Option<[[f64; 3]; 3]>,
    /// For the gyroscope.
    pub gyroscope: Option<[[f64; 3]; 3]>,
}

/// What `--rotate` takes, for its help and its errors.
pub const FORMS: &str = "a name (roll180, pitch90, yaw270, or several applied in turn: roll180,yaw90), an axis list \
                         for body x,y,z (y,-x,z) or nine numbers of an orthogonal matrix by rows; prefix it with mag:, accel: or gyro: to rotate one sensor only";

impl Mounting {
    /// Reads every `--rotate` in turn. Errors name the argument and the forms it may take.
    pub fn parse(arguments: &[String]) -> Outcome<Self> {
        let mut mounting = Mounting::default();
        for argument in arguments {
            let (sensors, form): (&[Sensor], &str) = match argument.split_once(':') {
                None => (&[Sensor::Magnetometer, Sensor::Accelerometer, Sensor::Gyroscope], argument),
                Some(("mag", form)) => (&[Sensor::Magnetometer], form),
                Some(("accel", form)) => (&[Sensor::Accelerometer], form),
                Some(("gyro", form)) => (&[Sensor::Gyroscope], form),
                Some((other, _)) => {
                    return Err(Failure::usage(format!(
                        "--rotate {argument}: no sensor \"{other}\": use {FORMS}"
                    )));
                }
            };
            let matrix = matrix(form)
                .ok_or_else(|| Failure::usage(format!("--rotate {argument}: expected {FORMS}")))?;
            for sensor in sensors {
                let slot = mounting.slot(*sensor);
                *slot = Some(slot.map_or(matrix, |before| product(matrix, before)));
            }
        }
        Ok(mounting)
    }

    /// What is to be said of `--rotate` on a log that has an accelerometer and a gyroscope or not.
    pub fn notices(&self, has_accelerometer: bool, has_gyroscope: bool) -> Vec<String> {
        let mut notices = Vec::new();
        for (matrix, has, what) in [
            (self.accelerometer, has_accelerometer, "accelerometer"),
            (self.gyroscope, has_gyroscope, "gyroscope"),
        ] {
            // Turning everything at once is not a wish for what is not there.
            if matrix.is_some() && matrix != self.magnetometer && !has {
                notices.push(format!("--rotate rotates the {what}, which is not in the log"));
            }
        }
        for (matrix, what) in [
            (self.magnetometer, "magnetometer"),
            (self.accelerometer, "accelerometer"),
            (self.gyroscope, "gyroscope"),
        ] {
            if matrix.is_some_and(|m| determinant(&m) < 0.0) {
                notices.push(format!(
                    "--rotate mirrors the {what}. This is correct only if the log has its axes in the wrong order or sign"
                ));
            }
        }
        notices
    }

    fn slot(&mut self, sensor: Sensor) -> &mut Option<[[f64; 3]; 3]> {
        match sensor {
            Sensor::Magnetometer => &mut self.magnetometer,
            Sensor::Accelerometer => &mut self.accelerometer,
            Sensor::Gyroscope => &mut self.gyroscope,
        }
    }
}

/// `matrix · vector`.
pub fn rotate(matrix: &[[f64; 3]; 3], vector: [f64; 3]) -> [f64; 3] {
    matrix.map(|row| row[0] * vector[0] + row[1] * vector[1] + row[2] * vector[2])
}

/// Determinant: −1 is a mirror image, which no mounting makes but a swapped axis does.
pub fn determinant(m: &[[f64; 3]; 3]) -> f64 {
    m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
        + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])
}

fn product(a: [[f64; 3]; 3], b: [[f64; 3]; 3]) -> [[f64; 3]; 3] {
    a.map(|row| {
        let mut out = [0.0; 3];
        for (j, out) in out.iter_mut().enumerate() {
            *out = row[0] * b[0][j] + row[1] * b[1][j] + row[2] * b[2][j];
        }
        out
    })
}

fn matrix(form: &str) -> Option<[[f64; 3]; 3]> {
    let parts: Vec<&str> = form.split(',').map(str::trim).collect();
    if parts.len() == 9 {
        return nine_numbers(&parts);
    }
    if parts.len() == 3 && parts.iter().all(|part| axis(part).is_some()) {
        let rows = [axis(parts[0])?, axis(parts[1])?, axis(parts[2])?];
        // Every sensor axis once, or the matrix is singular.
        return (determinant(&rows).abs() == 1.0).then_some(rows);
    }
    let mut total = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    for part in parts {
        total = product(named(part)?, total);
    }
    Some(total)
}

fn axis(text: &str) -> Option<[f64; 3]> {
    let (sign, name) = match text.strip_prefix('-') {
        Some(rest) => (-1.0, rest),
        None => (1.0, text.strip_prefix('+').unwrap_or(text)),
    };
    Some(match name {
        "x" => [sign, 0.0, 0.0],
        "y" => [0.0, sign, 0.0],
        "z" => [0.0, 0.0, sign],
        _ => return None,
    })
}

fn nine_numbers(parts: &[&str]) -> Option<[[f64; 3]; 3]> {
    let mut m = [[0.0; 3]; 3];
    for (cell, part) in m.iter_mut().flatten().zip(parts) {
        *cell = part.parse().ok().filter(|value: &f64| value.is_finite())?;
    }
    let orthogonal = (0..3).all(|i| {
        (0..3).all(|j| {
            let dot: f64 = (0..3).map(|k| m[i][k] * m[j][k]).sum();
            (dot - f64::from(u8::from(i == j))).abs() < 1e-3
        })
    });
    orthogonal.then_some(m)
}

/// `rollA`, `pitchA`, `yawA` by A degrees: the sensor is turned by that angle about the body's x, y, z axis,
/// right-handed, so body = R·sensor with R the rotation by that angle.
fn named(text: &str) -> Option<[[f64; 3]; 3]> {
    if text == "none" {
        return Some([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    }
    let split = text.find(|c: char| !c.is_ascii_alphabetic())?;
    let (name, angle) = text.split_at(split);
    let degrees: f64 = angle.parse().ok().filter(|value: &f64| value.is_finite())?;
    let (sin, cos) = exact_sin_cos(degrees);
    Some(match name {
        "roll" => [[1.0, 0.0, 0.0], [0.0, cos, -sin], [0.0, sin, cos]],
        "pitch" => [[cos, 0.0, sin], [0.0, 1.0, 0.0], [-sin, 0.0, cos]],
        "yaw" => [[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]],
        _ => return None,
    })
}

/// Quarter turns exactly, so that counts stay counts.
fn exact_sin_cos(degrees: f64) -> (f64, f64) {
    match degrees.rem_euclid(360.0) {
        0.0 => (0.0, 1.0),
        90.0 => (1.0, 0.0),
        180.0 => (0.0, -1.0),
        270.0 => (-1.0, 0.0),
        other => other.to_radians().sin_cos(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn turned(form: &str, v: [f64; 3]) -> [f64; 3] {
        rotate(&matrix(form).expect(form), v)
    }

    #[test]
    fn names_lists_and_numbers_agree() {
        let v = [1.0, 2.0, 3.0];
        assert_eq!(turned("roll180", v), [1.0, -2.0, -3.0]);
        assert_eq!(turned("x,-y,-z", v), [1.0, -2.0, -3.0]);
        assert_eq!(turned("1,0,0,0,-1,0,0,0,-1", v), [1.0, -2.0, -3.0]);
        // A sensor turned 90 degrees to the right: its x axis is the body's y axis.
        assert_eq!(turned("yaw90", [1.0, 0.0, 0.0]), [0.0, 1.0, 0.0]);
        assert_eq!(turned("roll180,yaw90", v), [2.0, 1.0, -3.0]);
    }

    #[test]
    fn what_is_no_mounting_is_refused() {
        for form in ["", "yaw", "x,x,z", "turn90", "1,0,0,0,1,0,0,0,2", "1,2,3", "yawnan", "x,y", "mag"] {
            assert_eq!(matrix(form), None, "{form:?}");
        }
        assert!(Mounting::parse(&["imu:x,y,z".into()]).is_err());
    }

    #[test]
    fn one_sensor_can_be_turned_alone() {
        let mounting = Mounting::parse(&["mag:y,x,-z".into()]).expect("valid");
        assert!(mounting.accelerometer.is_none());
        assert_eq!(mounting.magnetometer.map(|m| determinant(&m)), Some(1.0));
    }
}
