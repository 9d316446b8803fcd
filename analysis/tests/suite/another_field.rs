//! A field that is another one from place to place, which the magnitude hardly shows and the gyro does.

use ironout_analysis::{Options, Table, fit};
use ironout_simulation::{Log, World, WorldOptions};
use nalgebra::{Rotation3, Vector3};

/// A log whose field turns by up to `share` rad while the board is carried about, its magnitude nearly the same everywhere. The sensor is a
/// true one: what it reads is the field in its own axes.
fn carried(seed: u64, share: f64) -> Log {
    let soft_iron = Some([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    let options = WorldOptions { seed, hard_iron_ut: Some([0.0; 3]), soft_iron, ..WorldOptions::default() };
    let mut log = World::new(options).run();
    let column = |name: &str| log.column(name).unwrap().to_vec();
    let time = column("t_s");
    let [rate, field] = [["gx_radps", "gy_radps", "gz_radps"], ["mx_ut", "my_ut", "mz_ut"]].map(|names| {
        let [x, y, z] = names.map(column);
        (0..time.len()).map(|at| Vector3::new(x[at], y[at], z[at])).collect::<Vec<_>>()
    });
    // The room is the board as it was at first.
    let mut to_room = Rotation3::identity();
    let (room_ut, mut disturbed) = (field[0], Vec::new());
    let [one, two] = [room_ut.cross(&Vector3::x()), room_ut.cross(&Vector3::y())];
    let two = (two - one * one.dot(&two) / one.norm_squared()).normalize() * room_ut.norm();
    let one = one.normalize() * room_ut.norm();
    for at in 0..time.len() {
        if at > 0 {
            to_room *= Rotation3::new(0.5 * (rate[at - 1] + rate[at]) * (time[at] - time[at - 1]));
        }
        let there = (one * (1.1 * time[at]).sin() + two * (0.8 * time[at]).sin()) * share;
        disturbed.push(field[at] + to_room.inverse() * there);
    }
    for (axis, name) in ["mx_ut", "my_ut", "mz_ut"].into_iter().enumerate() {
        let position = log.position(name).unwrap();
        log.columns[position].iter_mut().zip(&disturbed).for_each(|(value, field)| *value = field[axis]);
    }
    log
}

#[test]
fn a_field_that_differs_from_place_to_place_is_refused_by_the_gyro() {
    for seed in 1..=6 {
        for (share, varies) in [(0.0, false), (0.03, false), (0.25, true), (0.4, true)] {
            let log = carried(seed, share);
            let fitted = fit(&Table::from_columns(log.named()).unwrap(), &Options::default()).unwrap();
            let solution = fitted.solution.as_ref().unwrap();
            let beside = fitted.beside_gyro.expect("the log has a gyro");
            let said = fitted.reasons.iter().any(|reason| reason.contains("The field is not uniform"));
            let what = format!(
                "seed {seed}, {share}: {beside:?}, along {:.4}, {:?}",
                solution.rms_ut / solution.calibration.field_ut,
                fitted.reasons
            );
            println!("{what}");
            assert_eq!(said, varies, "{what}");
            assert!(!(varies && fitted.accepted), "{what}");
        }
    }
}
