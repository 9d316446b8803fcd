//! A magnetometer in each of the 24 ways that a sensor can be mounted by right angles, and behind drivers that mirror it:
//! following what `fit` or `diagnose` advises leads to a right heading, or they said that they cannot tell.

use ironout_analysis::base::axes::Alignment;
use ironout_analysis::base::heading::{HeadingError, difference_deg, heading_deg};
use ironout_analysis::base::mounting::{DecidedBy, OrderStatus};
use ironout_analysis::base::order::AxisOrder;
use ironout_analysis::{Diagnosis, Fitted, Options, Table, diagnose, fit};
use ironout_host_tests::accuracy::simulated::table_of;
use ironout_simulation::{Log, World, WorldOptions};
use nalgebra::{Matrix3, Vector3};

/// Headings are right where they are off by less than this, degrees rms.
const RIGHT_DEG: f64 = 3.0;
const DIP_DEG: f64 = 60.0;

/// The log of a board on the northern or the southern half, before its magnetometer is mounted anyhow.
fn board(dip_deg: f64, seed: u64) -> Log {
    World::new(WorldOptions { seed, seconds: 40.0, dip_deg, ..WorldOptions::default() }).run()
}

/// The same log with the magnetometer's columns as a sensor reads them whose axes stand for `order`.
fn mounted(board: &Log, order: AxisOrder) -> Log {
    turned(board, order.to_board().transpose())
}

/// The same log with `matrix` before the magnetometer's columns.
fn turned(board: &Log, matrix: Matrix3<f64>) -> Log {
    let mut log = board.clone();
    for row in 0..board.columns[1].len() {
        let vector = Vector3::from_fn(|axis, _| board.columns[1 + axis][row]);
        let turned = matrix * vector;
        (0..3).for_each(|axis| log.columns[1 + axis][row] = turned[axis]);
    }
    log
}

/// The log without its reference heading.
fn without_heading(log: &Log) -> Log {
    let mut log = log.clone();
    let index = log.position("heading_deg").expect("a simulated log has a heading");
    log.names.remove(index);
    log.columns.remove(index);
    log
}

/// `--rotate mag:…` as the program reads it: the log's axes that become the board's x, y, z.
fn rotation(option: &str) -> Matrix3<f64> {
    let axes: Vec<&str> = option.strip_prefix("mag:").expect("of the magnetometer").split(',').collect();
    Matrix3::from_fn(|row, column| {
        let (sign, name) = axes[row].strip_prefix('-').map_or((1.0, axes[row]), |name| (-1.0, name));
        if name == ["x", "y", "z"][column] { sign } else { 0.0 }
    })
}

/// The error of the heading that a calibration gives on a log, against the truth of the board.
fn heading_error(fitted: &Fitted, log: &Log, truth: &Log) -> HeadingError {
    let calibration = fitted.solution.as_ref().expect("a solution").calibration;
    let table = table_of(log);
    let accel = table.accel_mps2.expect("an accelerometer");
    let reference = table_of(truth).heading_deg.expect("a truth").to_vec();
    let differences: Vec<f64> = (0..table.rows())
        .filter_map(|row| {
            let a = Vector3::from(accel.map(|axis| axis[row]));
            let down = -a / a.norm();
            let heading = heading_deg(calibration.apply(table.field(row)), down.into())?;
            Some(difference_deg(heading, reference[row]))
        })
        .collect();
    HeadingError::of(&differences).expect("headings")
}

fn options(at_deg: Option<f64>) -> Options {
    Options { dip_deg: at_deg, ..Options::default() }
}

fn fitted(table: &Table, at_deg: Option<f64>) -> Fitted {
    fit(table, &options(at_deg)).expect("a fit")
}

fn diagnosed(table: &Table, at_deg: Option<f64>) -> Diagnosis {
    diagnose(table, &options(at_deg)).expect("a diagnosis")
}

/// How `fit` says that the axes stand.
fn order_status(fitted: &Fitted) -> OrderStatus {
    match fitted.solution.as_ref().expect("a solution").alignment {
        Alignment::Done { order_status, .. }
        | Alignment::Mirrored(order_status)
        | Alignment::Open(order_status) => order_status,
        ref other => panic!("{other:?}"),
    }
}

/// Every mounting, and of the mirrors those that drivers make: one sign, two axes swapped, all signs.
fn sample() -> Vec<AxisOrder> {
    let mirrors = ["-x,y,z", "x,-y,z", "x,y,-z", "y,x,z", "z,y,x", "x,z,y", "-x,-y,-z", "-y,-x,-z"];
    let mirrors = AxisOrder::all().filter(|order| mirrors.contains(&order.to_string().as_str()));
    let all: Vec<AxisOrder> = AxisOrder::mountings().chain(mirrors).collect();
    assert_eq!(all.len(), 32);
    all
}

#[test]
fn with_a_heading_or_a_place_the_mounting_is_named_and_the_advice_is_right() {
    for (dip_deg, seed) in [(DIP_DEG, 5), (-DIP_DEG, 6)] {
        let board = board(dip_deg, seed);
        for order in sample() {
            let log = mounted(&board, order);
            let blind = without_heading(&log);
            for (log, at_deg, by) in
                [(&log, None, DecidedBy::Heading), (&blind, Some(dip_deg + 4.0), DecidedBy::Place)]
            {
                let what = format!("{order} at {dip_deg}°, {by:?}");
                let (fit, diagnosis) = (fitted(&table_of(log), at_deg), diagnosed(&table_of(log), at_deg));
                let found = order_status(&fit);
                assert_eq!((found.order, found.decided), (order, Ok(by)), "{what}");
                let of_diagnosis = diagnosis.order_status.expect("an accelerometer");
                assert_eq!((of_diagnosis.order, of_diagnosis.decided), (order, Ok(by)), "{what}");
                assert_eq!(found.words(), of_diagnosis.words(), "{what}");
                // A mirror image is a driver's fault: nothing is accepted. A mounting stands in the matrix.
                assert_eq!(fit.accepted, !order.is_mirror(), "{what}: {:?}", fit.reasons);
                assert_eq!(found.words().join(" ").contains("driver"), order.is_mirror(), "{what}");
                if fit.accepted {
                    let error = heading_error(&fit, log, &board);
                    assert!(error.rms_deg < RIGHT_DEG, "{what}: {error:?}");
                }
                // The advice, followed.
                let readings = found.readings();
                assert_eq!(readings.len(), usize::from(!order.is_in_order()), "{what}");
                for (option, _) in readings {
                    let read = turned(log, rotation(&option));
                    let again = fitted(&table_of(&read), at_deg);
                    assert!(
                        again.accepted && order_status(&again).order.is_in_order(),
                        "{what}: {:?}",
                        again.reasons
                    );
                    let error = heading_error(&again, &read, &board);
                    assert!(error.rms_deg < RIGHT_DEG, "{what}: {error:?}");
                }
            }
        }
    }
}

#[test]
fn without_either_it_is_said_that_the_log_cannot_tell_and_one_of_the_readings_listed_is_right() {
    let board = board(DIP_DEG, 7);
    for order in sample() {
        let log = without_heading(&mounted(&board, order));
        let (fit, diagnosis) = (fitted(&table_of(&log), None), diagnosed(&table_of(&log), None));
        let found = order_status(&fit);
        assert!(found.decided.is_err(), "{order}: {found:?}");
        let of_diagnosis = diagnosis.order_status.expect("an accelerometer");
        assert_eq!(found.words(), of_diagnosis.words(), "{order}");
        assert!(found.words()[0].contains("--at"), "{order}: {:?}", found.words());
        let mounting = if order.is_mirror() { order.opposite() } else { order };
        assert_eq!((found.order, of_diagnosis.order), (mounting, mounting), "{order}");
        if mounting.is_in_order() {
            // Nothing is out of order, unless every axis is reversed: accepted, and the doubt is said.
            assert!(fit.accepted && found.readings().is_empty(), "{order}: {:?}", fit.reasons);
            continue;
        }
        assert!(!fit.accepted && fit.heading_error_deg.is_none(), "{order}");
        let errors: Vec<f64> = found
            .readings()
            .iter()
            .map(|(option, _)| {
                let read = turned(&log, rotation(option));
                let again = fitted(&table_of(&read), None);
                assert!(again.accepted, "{order} with {option}: {:?}", again.reasons);
                heading_error(&again, &read, &board).rms_deg
            })
            .collect();
        assert_eq!(errors.len(), 2, "{order}");
        assert_eq!(errors.iter().filter(|error| **error < RIGHT_DEG).count(), 1, "{order}: {errors:?}");
        let json = ironout_analysis::outcome::json::object(&diagnosis);
        let rows = json["candidates"].as_array().expect("rows");
        let row = rows.iter().find(|row| row["id"] == "axis-order").expect("a row");
        assert_eq!(row["decided_by"], serde_json::Value::Null);
        assert_eq!(row["order"], mounting.to_string());
        assert_eq!(row["or_order"], mounting.opposite().to_string());
    }
}

#[test]
fn what_is_known_and_does_not_fit_is_said() {
    let board = board(DIP_DEG, 8);
    let order = AxisOrder::mountings().find(|order| order.to_string() == "x,-y,-z").expect("a half turn");
    let log = mounted(&board, order);
    let words = |log: &Log, at_deg| order_status(&fitted(&table_of(log), at_deg)).words().join(" ");
    assert!(words(&without_heading(&log), Some(10.0)).contains("neither this nor its opposite"));
    assert!(words(&without_heading(&log), Some(2.0)).contains("the place is not sufficient"));
    assert!(words(&log, Some(-DIP_DEG)).contains("heading_deg and --at contradict each other"));
    let mut wrong = log.clone();
    let heading = wrong.position("heading_deg").expect("a heading");
    for (row, value) in wrong.columns[heading].iter_mut().enumerate() {
        *value = (row % 360) as f64;
    }
    assert!(words(&wrong, None).contains("Check its column"), "{}", words(&wrong, None));
}
