//! The rate of turn from the readings themselves, where a true field is known at every row and the log has no gyro.
//!
//! In a field that is fixed in the world the corrected vector h turns as `dh/dt = −ω × h`. Eddy currents need `ω × h` alone, so that the
//! part of ω along h, which no magnetometer shows, is not missed.

use crate::derive::Definition;
use crate::input::Log;
use nalgebra::{Matrix4, Vector4};

/// Columns of a gyro as expressions of the readings; `None` where the log has one, has no times or no true field, or the readings do not
/// tell their centre.
pub fn definitions(log: &Log) -> Option<Vec<Definition>> {
    let [field, _] = log.earth.as_ref()?;
    if log.gyro_radps.is_some() || log.time_s.is_none() {
        return None;
    }
    let centre = centre(log, field)?;
    let names = ["mx_ut", "my_ut", "mz_ut"];
    let now = |axis: usize| format!("({} - {:.3})", names[axis], centre[axis]);
    let before = |axis: usize| format!("(prev({}) - {:.3})", names[axis], centre[axis]);
    let after = |axis: usize| format!("(next({}) - {:.3})", names[axis], centre[axis]);
    let square = (0..3).map(|axis| format!("{}^2", now(axis))).collect::<Vec<_>>().join(" + ");
    let axes = ["gx_radps", "gy_radps", "gz_radps"].into_iter().zip([(1, 2), (2, 0), (0, 1)]);
    let one = |(name, (j, k)): (&str, (usize, usize))| Definition {
        name: name.into(),
        // −(h before × h after) / |h|² per time.
        expression: format!(
            "({} * {} - {} * {}) / (({square}) * (next(t_s) - prev(t_s)))",
            before(k),
            after(j),
            before(j),
            after(k)
        ),
    };
    Some(axes.map(one).collect())
}

/// The centre of the readings, µT: `|m|² = F² + 2 b·m − |b|²` is linear in it where F is known at each row.
fn centre(log: &Log, field_ut: &[f64]) -> Option<[f64; 3]> {
    let mut normal = Matrix4::<f64>::zeros();
    let mut right = Vector4::<f64>::zeros();
    for (row, field) in field_ut.iter().enumerate() {
        let m: [f64; 3] = std::array::from_fn(|axis| log.field_ut[axis][row]);
        if m.iter().all(|value| value.is_finite()) {
            let columns = Vector4::new(2.0 * m[0], 2.0 * m[1], 2.0 * m[2], 1.0);
            normal += columns * columns.transpose();
            right += columns * (m.iter().map(|value| value * value).sum::<f64>() - field * field);
        }
    }
    let [x, y, z, _] = normal.cholesky()?.solve(&right).into();
    [x, y, z].iter().all(|value: &f64| value.is_finite()).then_some([x, y, z])
}

#[cfg(test)]
mod tests {
    use super::definitions;
    use crate::derive::add;
    use crate::input::{Log, Mounting};

    #[test]
    fn a_turn_about_z_is_read_off_the_field() {
        let offset = [12.0, -5.0, 3.0];
        let (rate_radps, dip) = (0.4, 0.9_f64);
        let time_s: Vec<f64> = (0..600).map(|i| f64::from(i) * 0.05).collect();
        // A slow nod, so that the centre shows in all directions.
        let vector = |t: f64| {
            let (turn, nod) = (-rate_radps * t, dip + 0.5 * (0.01 * t).sin());
            [nod.cos() * turn.cos(), nod.cos() * turn.sin(), nod.sin()].map(|axis| 50.0 * axis)
        };
        let mut log = Log { rows: time_s.len(), time_s: Some(time_s.clone()), ..Log::default() };
        for axis in 0..3 {
            log.field_ut[axis] = time_s.iter().map(|t| vector(*t)[axis] + offset[axis]).collect();
        }
        log.earth = Some([vec![50.0; time_s.len()], vec![0.0; time_s.len()]]);
        let list = definitions(&log).expect("readings that turn");
        add(&mut log, &list, &Mounting::default()).expect("a gyro");
        let gyro = log.gyro_radps.as_ref().expect("a gyro");
        for row in [50, 300, 598] {
            let (h, own) = (vector(time_s[row]), [0, 1, 2].map(|axis| gyro[axis][row]));
            // ω × h is all that shows of it: the board turns about z.
            let crossed = [own[1] * h[2] - own[2] * h[1], own[2] * h[0] - own[0] * h[2]];
            let truth = [-rate_radps * h[1], rate_radps * h[0]];
            assert!((0..2).all(|axis| (crossed[axis] - truth[axis]).abs() < 0.3), "{crossed:?} {truth:?}");
        }
        assert!(definitions(&log).is_none(), "it has a gyro now");
    }
}
