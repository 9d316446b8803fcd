use super::*;
use nalgebra::{Rotation3, Vector3};

/// A board turned about all its axes, at 50 Hz: time, rate, field, specific force.
struct Board {
    time: Vec<f64>,
    rate: [Vec<f64>; 3],
    field: [Vec<f64>; 3],
    force: [Vec<f64>; 3],
}

fn board() -> Board {
    let step = 0.02;
    let mut turned = Rotation3::identity();
    let mut board = Board {
        time: vec![],
        rate: [vec![], vec![], vec![]],
        field: [vec![], vec![], vec![]],
        force: [vec![], vec![], vec![]],
    };
    let rate_at =
        |t: f64| Vector3::new((0.7 * t).sin(), 0.9 * (0.45 * t).cos(), 0.8 * (0.31 * t + 1.0).sin());
    for i in 0..3000 {
        let t = f64::from(i) * step;
        let rate = rate_at(t);
        let back = turned.inverse();
        let field = back * Vector3::new(20.0, 0.0, 43.0);
        let iron = Vector3::new(1.05 * field.x + 0.04 * field.y, 0.97 * field.y, 1.1 * field.z);
        let force = back * Vector3::new(0.0, 0.0, -9.81);
        let noise = |k: u32| f64::from((i as u32).wrapping_mul(2_654_435_761 ^ k) >> 16) / 65_536.0 - 0.5;
        board.time.push(t);
        for axis in 0..3 {
            board.rate[axis].push(rate[axis] + 0.02 * noise(axis as u32));
            board.field[axis].push(iron[axis] + 30.0 * (axis as f64 - 1.0) + noise(axis as u32 + 7));
            board.force[axis].push(force[axis] + 0.3 * noise(axis as u32 + 13));
        }
        turned *= Rotation3::new(rate_at(t + step / 2.0) * step);
    }
    board
}

/// The axes as a sensor in this order would have them: `--rotate` with the order undoes it.
fn mounted(axes: &[Vec<f64>; 3], order: Order, factor: f64) -> [Vec<f64>; 3] {
    let back = order.back();
    [0, 1, 2].map(|i| axes[back.axis[i]].iter().map(|value| factor * back.sign(i) * value).collect())
}

fn judged(
    board: &Board,
    gyro: &[Vec<f64>; 3],
    field: &[Vec<f64>; 3],
    force: Option<&[Vec<f64>; 3]>,
) -> Turning {
    let triple = |axes: &'_ [Vec<f64>; 3]| -> [Vec<f64>; 3] { axes.clone() };
    let (gyro, field, force) = (triple(gyro), triple(field), force.map(triple));
    judge(&Table {
        time_s: Some(&board.time),
        field_ut: field.each_ref().map(Vec::as_slice),
        gyro_radps: Some(gyro.each_ref().map(Vec::as_slice)),
        accel_mps2: force.as_ref().map(|axes| axes.each_ref().map(Vec::as_slice)),
        ..Table::default()
    })
}

#[test]
fn sensors_that_agree_are_left_alone() {
    let b = board();
    assert_eq!(judged(&b, &b.rate, &b.field, Some(&b.force)), Turning::default());
    assert_eq!(judged(&b, &b.rate, &b.field, None), Turning::default());
}

#[test]
fn every_order_of_the_gyro_is_named() {
    let b = board();
    for order in Order::all().filter(|order| !order.is_own()) {
        for force in [None, Some(&b.force)] {
            let found = judged(&b, &mounted(&b.rate, order, 1.0), &b.field, force);
            let axes = found.axes.unwrap_or_else(|| panic!("{}", order.name()));
            assert_eq!(axes.orders, [order], "{}", order.name());
            let whose = if force.is_some() { Whose::Gyro } else { Whose::GyroOrMagnetometer };
            assert_eq!((axes.whose, found.rate), (whose, None));
        }
    }
}

#[test]
fn the_odd_one_of_three_sensors_is_found() {
    let b = board();
    for order in Order::all().filter(|order| !order.is_own()) {
        // A vector and its opposite turn alike: of the two orders the one that a mounting can have.
        let named = if order.is_mirrored() { order.opposite() } else { order };
        if named.is_own() {
            continue;
        }
        let found = judged(&b, &b.rate, &b.field, Some(&mounted(&b.force, order, 1.0))).axes;
        assert_eq!(found.map(|axes| (axes.whose, axes.orders)), Some((Whose::Accelerometer, vec![named])));
        let found = judged(&b, &b.rate, &mounted(&b.field, order, 1.0), Some(&b.force)).axes;
        assert_eq!(found.map(|axes| (axes.whose, axes.orders)), Some((Whose::Magnetometer, vec![named])));
    }
}

#[test]
fn units_of_the_gyro_are_told_whatever_its_axes() {
    let b = board();
    for (unit, size) in UNITS {
        for order in Order::all().step_by(11) {
            let found = judged(&b, &mounted(&b.rate, order, 1.0 / size), &b.field, None);
            let rate = found.rate.unwrap_or_else(|| panic!("{unit}"));
            assert_eq!(rate.unit.map(|(name, _)| name), Some(unit), "{rate:?}");
            assert!((rate.factor / size - 1.0).abs() < 0.1, "{rate:?}");
            assert_eq!(found.axes.is_none(), order.is_own());
        }
    }
    let counts = judged(&b, &mounted(&b.rate, Order::all().next().expect("one"), 7506.0), &b.field, None);
    assert!(counts.rate.is_some_and(|rate| rate.unit.is_none() && (rate.factor * 7506.0 - 1.0).abs() < 0.1));
}

#[test]
fn a_board_at_rest_or_turned_about_one_axis_names_no_order() {
    let mut b = board();
    let still = [0, 1, 2].map(|axis| {
        b.field[axis].iter().enumerate().map(|(i, _)| f64::from(i as u32 % 3)).collect::<Vec<_>>()
    });
    assert_eq!(judged(&b, &b.rate, &still, None), Turning::default());
    for i in 0..b.time.len() {
        let angle: f64 = 0.8 * b.time[i];
        for (axis, rate) in [0.0, 0.0, 0.8].into_iter().enumerate() {
            b.rate[axis][i] = rate;
        }
        for (axis, field) in [20.0 * angle.cos(), -20.0 * angle.sin(), 43.0].into_iter().enumerate() {
            b.field[axis][i] = field;
        }
    }
    assert_eq!(judged(&b, &b.rate, &b.field, None), Turning::default());
    let swapped = Order::all().find(|order| order.name() == "z,y,x").expect("an order");
    let found = judged(&b, &mounted(&b.rate, swapped, 1.0), &b.field, None).axes;
    assert!(found.is_some_and(|axes| axes.orders.len() > 1 && axes.orders.contains(&swapped)));
}

/// A board whose accelerometer measures as much of its own shaking as of gravity.
fn shaken(by_mps2: f64) -> Board {
    let mut b = board();
    for (i, t) in b.time.iter().enumerate() {
        for axis in 0..3 {
            b.force[axis][i] += by_mps2 * (2.1 * t + 2.0 * axis as f64).sin();
        }
    }
    b
}

#[test]
fn where_the_accelerometer_is_shaken_the_dip_tells_whose_axes_are_odd() {
    let b = shaken(7.0);
    let alone = by_gravity(
        &Table { accel_mps2: Some(b.force.each_ref().map(Vec::as_slice)), ..Table::default() },
        &b.time,
        b.rate.each_ref().map(Vec::as_slice),
    );
    assert!(alone.is_none_or(|follow| follow.best.explained < FITS), "it does not show how the board turns");
    for order in Order::all().filter(|order| !order.is_own() && !order.opposite().is_own()) {
        // A vector and its opposite turn alike.
        let named = if order.is_mirrored() { order.opposite() } else { order };
        let found = judged(&b, &b.rate, &mounted(&b.field, order, 1.0), Some(&b.force)).axes;
        assert_eq!(found.map(|axes| (axes.whose, axes.orders)), Some((Whose::Magnetometer, vec![named])));
        let found = judged(&b, &mounted(&b.rate, order, 1.0), &b.field, Some(&b.force)).axes;
        assert_eq!(found.map(|axes| (axes.whose, axes.orders)), Some((Whose::Gyro, vec![order])));
    }
}

#[test]
fn where_nothing_tells_the_magnetometer_is_the_likelier_one() {
    let b = shaken(60.0);
    let order = Order::all().find(|order| order.name() == "y,z,x").expect("an order");
    let found = judged(&b, &b.rate, &mounted(&b.field, order, 1.0), Some(&b.force)).axes;
    assert_eq!(found.map(|axes| (axes.whose, axes.orders)), Some((Whose::LikelyMagnetometer, vec![order])));
}
