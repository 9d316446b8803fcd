//! Derived columns of a log.

use crate::derive::definition::Definition;
use crate::derive::expression::{Columns, compute};
use crate::failure::{Failure, Outcome};
use crate::input::{Covariate, Log, Mounting, rotate};

const FIELD: [&str; 3] = ["mx_ut", "my_ut", "mz_ut"];
const ACCEL: [&str; 3] = ["ax_mps2", "ay_mps2", "az_mps2"];
const GYRO: [&str; 3] = ["gx_radps", "gy_radps", "gz_radps"];

/// Adds these columns, one after the other: each can read those before it. All three axes of an accelerometer or a gyro make
/// a sensor, in the axes that it is mounted with (`mounting` turns it); `heading_deg` is the reference heading.
///
/// # Errors
/// A name that the log has already, an expression that cannot be computed, a column without a single value.
pub fn add(log: &mut Log, definitions: &[Definition], mounting: &Mounting) -> Outcome<()> {
    for definition in definitions {
        let Definition { name, expression } = definition;
        let fail = |why: String| Failure::usage(format!("--derive {name}={expression}: {why}"));
        let there = named(log).iter().any(|(own, _)| own == name);
        if there || name == "t_s" || name == "t_us" || FIELD.contains(&name.as_str()) {
            return Err(fail(format!("the log already uses the column name {name}. Choose another name")));
        }
        let all = named(log).into_iter().chain(by_source(log)).collect();
        let columns = Columns { rows: log.rows, time_s: log.time_s.as_deref(), named: all };
        let computed = compute(expression, &columns).map_err(fail)?;
        let empty = computed.values.iter().filter(|value| !value.is_finite()).count();
        if empty == log.rows {
            return Err(fail(format!("no row of the log gives a value ({} rows)", log.rows)));
        }
        if computed.without_value > 0 {
            log.notices.push(format!(
                "{name} = {expression} has no finite value in {} of {} rows, and stays empty there",
                computed.without_value, log.rows
            ));
        }
        if name == "heading_deg" {
            log.heading_deg = Some(computed.values);
        } else {
            let name = name.clone();
            log.covariates.push(Covariate { name, values: computed.values, empty, not_finite: 0 });
        }
    }
    if log.accel_mps2.is_none() {
        log.accel_mps2 = sensor(log, definitions, ACCEL, mounting.accelerometer);
    }
    if log.gyro_radps.is_none() {
        log.gyro_radps = sensor(log, definitions, GYRO, mounting.gyroscope);
    }
    Ok(())
}

/// Every column that has a name.
fn named(log: &Log) -> Vec<(&str, &[f64])> {
    let mut list: Vec<(&str, &[f64])> = Vec::new();
    let triples =
        [(FIELD, Some(&log.field_ut)), (ACCEL, log.accel_mps2.as_ref()), (GYRO, log.gyro_radps.as_ref())];
    for (names, axes) in triples {
        list.extend(axes.into_iter().flat_map(|axes| names.into_iter().zip(axes.iter().map(Vec::as_slice))));
    }
    list.extend(log.heading_deg.as_deref().map(|values| ("heading_deg", values)));
    list.extend(log.covariates.iter().map(|own| (own.name.as_str(), own.values.as_slice())));
    list
}

/// What has another name here by that of the file: an expression may use either.
fn by_source(log: &Log) -> impl Iterator<Item = (&str, &[f64])> {
    let sources = log.read_as.columns.iter().filter(|column| column.name != column.source);
    sources.filter_map(|column| {
        let own = log.covariate(&column.name).filter(|_| log.covariate(&column.source).is_none())?;
        Some((column.source.as_str(), own.values.as_slice()))
    })
}

/// Takes the three axes of a sensor out of the covariates, where all of them were derived.
fn sensor(
    log: &mut Log,
    definitions: &[Definition],
    names: [&str; 3],
    mounting: Option<[[f64; 3]; 3]>,
) -> Option<[Vec<f64>; 3]> {
    let derived = |name: &&str| definitions.iter().any(|definition| definition.name == **name);
    if !names.iter().all(derived) {
        return None;
    }
    let mut axes = names.map(|name| {
        let at = log.covariates.iter().position(|own| own.name == name);
        at.map(|at| log.covariates.remove(at).values).unwrap_or_default()
    });
    if let Some(matrix) = mounting {
        let [x, y, z] = &mut axes;
        for ((x, y), z) in x.iter_mut().zip(y).zip(z) {
            [*x, *y, *z] = rotate(&matrix, [*x, *y, *z]);
        }
    }
    Some(axes)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn log() -> Log {
        let column = |name: &str, values: [f64; 2]| Covariate {
            name: name.into(),
            values: values.to_vec(),
            empty: 0,
            not_finite: 0,
        };
        Log {
            rows: 2,
            field_ut: [vec![1.0, 2.0], vec![3.0, 4.0], vec![5.0, 6.0]],
            covariates: vec![column("gx", [180.0, 0.0]), column("gy", [0.0, 90.0]), column("gz", [0.0; 2])],
            ..Log::default()
        }
    }

    fn definitions(list: &[&str]) -> Vec<Definition> {
        list.iter().map(|text| Definition::parse(text).expect("valid")).collect()
    }

    #[test]
    fn three_axes_make_a_sensor_and_stand_in_body_axes() {
        let mut log = log();
        let all = definitions(&[
            "gx_radps=gx*pi/180",
            "gy_radps=gy*pi/180",
            "gz_radps=gz*pi/180",
            "twice=2*gx_radps",
        ]);
        let mounting = Mounting::parse(&["roll180".into()]).expect("valid");
        add(&mut log, &all, &mounting).expect("valid");
        let gyro = log.gyro_radps.as_ref().expect("a gyro");
        assert!((gyro[0][0] - std::f64::consts::PI).abs() < 1e-12);
        assert!((gyro[1][1] + std::f64::consts::FRAC_PI_2).abs() < 1e-12, "{gyro:?}");
        assert!(log.covariate("gx_radps").is_none());
        assert!(
            log.covariate("twice").is_some_and(|own| (own.values[0] - std::f64::consts::TAU).abs() < 1e-12)
        );
    }

    #[test]
    fn names_that_are_taken_and_columns_without_a_value_are_refused() {
        for (text, word) in [
            ("gx=2*gy", "another name"),
            ("t_s=gx", "another name"),
            ("mx_ut=gx", "another name"),
            ("a=ln(-1-gz)", "no row"),
        ] {
            let failure = add(&mut log(), &definitions(&[text]), &Mounting::default()).expect_err(text);
            assert!(failure.message.contains(word) && failure.message.contains("--derive"), "{failure}");
        }
    }
}
