//! From columns with names to a [`Log`]: scales, mountings, notices.

use crate::failure::{Failure, Outcome};
use crate::input::columns::{self, Column, Role};
use crate::input::log::{Covariate, Log, ReadOptions};
use crate::input::mount::{determinant, rotate};
use crate::input::read_as::{LeftOut, ReadAs, ReadColumn};
use crate::input::repair;
use crate::input::repair_words;
use crate::input::store::Store;
use crate::input::unit::Unit;
use crate::input::words::shorten;
use ironout_analysis::frame::{Frame, IDENTITY};

/// Where everything is, once the header is understood.
pub struct Plan {
    /// The column of time.
    pub time: Option<usize>,
    field: [usize; 3],
    scale: Option<[f64; 3]>,
    accel: Option<[usize; 3]>,
    gyro: Option<[usize; 3]>,
    heading: Option<usize>,
    /// Columns in which only finite numbers are allowed.
    pub strict: Vec<usize>,
    notices: Vec<String>,
}

impl Plan {
    /// Finds what the columns hold.
    ///
    /// # Errors
    /// Counts without a scale, or no magnetometer.
    pub fn new(columns: &[Column], options: &ReadOptions, line: u64) -> Outcome<Self> {
        let covariate = |name: &str| columns.iter().any(|c| c.name == name && c.role == Role::Covariate);
        let mut notices: Vec<String> = options
            .map
            .iter()
            .filter(|(name, _)| covariate(name))
            .map(|(name, from)| {
                format!("ironout reads {from} as the covariate {name}, because no sensor of the log format has that name")
            })
            .collect();
        let find = |role: Role| columns.iter().position(|column| column.role == role);
        let whole = |make: fn(usize) -> Role| -> Option<[usize; 3]> {
            let [x, y, z] = columns::triple(columns, make);
            Some([x?, y?, z?])
        };
        let (ut, counts) = (whole(Role::FieldUt), whole(Role::FieldCounts));
        let (field, scale) = match (ut, counts, options.ut_per_count) {
            (Some(_), Some(counts), Some(scale)) => {
                notices.push(
                    "the log has mx_ut and mx_counts. ironout uses the counts (--ut-per-count is given)"
                        .into(),
                );
                (counts, Some(scale))
            }
            (Some(ut), both, scale) => {
                if both.is_some() {
                    notices.push("the log has mx_ut and mx_counts. ironout uses mx_ut".into());
                }
                if scale.is_some() {
                    notices.push("--ut-per-count is not used: the log is in microtesla".into());
                }
                (ut, None)
            }
            (None, Some(counts), Some(scale)) => (counts, Some(scale)),
            (None, Some(counts), None) if options.default_ut_per_count.is_some() => {
                (counts, options.default_ut_per_count)
            }
            (None, Some(_), None) => {
                return Err(Failure::usage(
                    "the magnetometer is in counts. Give its scale in µT per count with --ut-per-count UT, one number or \
                     three for x,y,z (see the data sheet; 0.1 for values in milligauss)",
                )
                .at_line(line)
                .at_column("mx_counts"));
            }
            (None, None, _) => {
                return Err(Failure::usage(
                    "the log has no mx_ut,my_ut,mz_ut and no mx_counts,my_counts,mz_counts",
                )
                .at_line(line));
            }
        };
        let mut optional = |make: fn(usize) -> Role, what: &str, names: &str| {
            let found = columns::triple(columns, make);
            if found.iter().any(Option::is_some) && found.iter().any(Option::is_none) {
                notices.push(format!("{what} ignored: it needs all of {names}"));
            }
            whole(make)
        };
        let accel = optional(Role::Accel, "the accelerometer is", "ax_mps2,ay_mps2,az_mps2");
        let gyro = optional(Role::Gyro, "the gyroscope is", "gx_radps,gy_radps,gz_radps");
        for (matrix, has, what) in [
            (options.mounting.accelerometer, accel.is_some(), "accelerometer"),
            (options.mounting.gyroscope, gyro.is_some(), "gyroscope"),
        ] {
            // Turning everything at once is not a wish for what is not there.
            if matrix.is_some() && matrix != options.mounting.magnetometer && !has {
                notices.push(format!("--rotate rotates the {what}, which is not in the log"));
            }
        }
        let heading = find(Role::Heading);
        let time = find(Role::Time);
        let strict = time.into_iter().chain(field).collect();
        for (matrix, what) in [
            (options.mounting.magnetometer, "magnetometer"),
            (options.mounting.accelerometer, "accelerometer"),
            (options.mounting.gyroscope, "gyroscope"),
        ] {
            if matrix.is_some_and(|m| determinant(&m) < 0.0) {
                notices.push(format!(
                    "--rotate mirrors the {what}. This is correct only if the log has its axes in the wrong order or sign"
                ));
            }
        }
        Ok(Plan { time, field, scale, accel, gyro, heading, strict, notices })
    }

    /// The log of the columns' values, each in the unit of the file.
    pub fn finish(self, mut stores: Vec<Store>, rows: usize, options: &ReadOptions) -> Outcome<Log> {
        let mut notices = self.notices;
        for (index, store) in stores.iter().enumerate() {
            if let Some((line, cell)) = &store.text {
                notices.push(format!(
                    "ignored column {}: it contains text (\"{cell}\" on line {line})",
                    shorten(&store.header)
                ));
            } else if store.column.role == Role::Unnamed {
                notices.push(format!("ignored column {}: it has no name", index + 1));
            }
        }
        let columns = read_columns(&stores);
        let Repaired { rows, left_out, taken_out, repairs } =
            repaired(&mut stores, self.field, rows, options)?;
        let factor = |index: usize| stores.get(index)?.column.unit.as_ref().map(Unit::factor);
        let own = self.field.map(|index| factor(index).unwrap_or(1.0));
        let frame = Frame { ut_per_number: self.scale.unwrap_or(own), ..Frame::default() };
        for store in &mut stores {
            if let Some(unit) = &store.column.unit {
                store.values.iter_mut().for_each(|value| *value = unit.convert(*value));
            }
        }
        let mut take = |index: usize| std::mem::take(&mut stores[index].values);
        let mut take3 = |indices: [usize; 3]| -> Option<[Vec<f64>; 3]> {
            let columns = indices.map(&mut take);
            // A text column has lost its values.
            columns.iter().all(|column| column.len() == rows).then_some(columns)
        };
        let raw = take3(self.field).unwrap_or_default();
        let mut accel_mps2 = self.accel.and_then(&mut take3);
        let mut gyro_radps = self.gyro.and_then(&mut take3);
        let time_s = self.time.map(&mut take);
        let heading_deg = self.heading.map(&mut take).filter(|column| column.len() == rows);

        let counts = match (self.scale, options.mounting.magnetometer) {
            (Some(_), None) => integers(&raw),
            _ => None,
        };
        let mut field_ut = raw;
        if let Some(scale) = self.scale {
            for (column, scale) in field_ut.iter_mut().zip(scale) {
                column.iter_mut().for_each(|value| *value *= scale);
            }
        }
        turn(&mut field_ut, options.mounting.magnetometer);
        let frame = frame.turned(&options.mounting.magnetometer.unwrap_or(IDENTITY));
        if let Some(columns) = &mut accel_mps2 {
            turn(columns, options.mounting.accelerometer);
        }
        if let Some(columns) = &mut gyro_radps {
            turn(columns, options.mounting.gyroscope);
        }
        let covariates = stores
            .into_iter()
            .filter(|store| store.column.role == Role::Covariate && store.text.is_none())
            .filter(|store| store.values.len() == rows)
            .map(|store| Covariate {
                name: store.column.name,
                values: store.values,
                empty: store.empty,
                not_finite: store.not_finite,
            })
            .collect();
        Ok(Log {
            path: Default::default(),
            rows,
            time_s,
            field_ut,
            frame,
            ut_per_count: self.scale,
            counts,
            accel_mps2,
            gyro_radps,
            heading_deg,
            earth: None,
            declination_deg: None,
            recordings: Vec::new(),
            covariates,
            read_as: ReadAs { columns, left_out, taken_out, repairs, ..ReadAs::default() },
            notices,
        })
    }
}

/// What the repairs of the magnetometer's numbers made of a log.
struct Repaired {
    rows: usize,
    left_out: Vec<LeftOut>,
    taken_out: Vec<String>,
    repairs: Vec<String>,
}

/// Mends the magnetometer's numbers, and takes the rows out that are not readings.
fn repaired(
    stores: &mut [Store],
    field: [usize; 3],
    rows: usize,
    options: &ReadOptions,
) -> Outcome<Repaired> {
    let whole = field.iter().all(|index| stores.get(*index).is_some_and(|store| store.values.len() == rows));
    if !whole {
        return Ok(Repaired { rows, left_out: Vec::new(), taken_out: Vec::new(), repairs: Vec::new() });
    }
    let numbers = field.map(|index| {
        stores.get_mut(index).map(|store| std::mem::take(&mut store.values)).unwrap_or_default()
    });
    let mended = repair::mend(numbers, &options.repair)?;
    if mended.kept.len() < rows {
        for store in stores.iter_mut().filter(|store| store.values.len() == rows) {
            store.values = mended.kept.iter().filter_map(|row| store.values.get(*row)).copied().collect();
            store.empty = store.values.iter().filter(|value| value.is_nan()).count();
        }
    }
    for (index, values) in field.into_iter().zip(mended.numbers) {
        if let Some(store) = stores.get_mut(index) {
            store.values = values;
        }
    }
    let asked = options.repair.iter().map(repair_words::asked);
    Ok(Repaired {
        rows: mended.kept.len(),
        left_out: mended
            .left_out
            .into_iter()
            .map(|(rows, why)| LeftOut { rows, first_line: None, why })
            .collect(),
        taken_out: mended.made,
        repairs: asked.chain(mended.codes).collect(),
    })
}

/// What is read, and under which name it stands in the file.
fn read_columns(stores: &[Store]) -> Vec<ReadColumn> {
    let read = |store: &&Store| store.text.is_none() && store.column.role != Role::Unnamed;
    let own = |store: &Store| store.column.role.quantity().map_or("", |quantity| quantity.own_unit());
    let unit = |store: &Store| {
        store.column.unit.as_ref().map_or(own(store).to_string(), |unit| unit.name.to_string())
    };
    stores
        .iter()
        .filter(read)
        .map(|store| ReadColumn {
            name: store.column.name.clone(),
            source: store.header.clone(),
            unit: unit(store),
        })
        .collect()
}

/// The triple as 16-bit counts, if every value is one.
fn integers(raw: &[Vec<f64>; 3]) -> Option<Vec<[i16; 3]>> {
    let exact = |value: f64| {
        let count = value as i16;
        (f64::from(count) == value).then_some(count)
    };
    let [x, y, z] = raw;
    x.iter().zip(y).zip(z).map(|((&x, &y), &z)| Some([exact(x)?, exact(y)?, exact(z)?])).collect()
}

fn turn(columns: &mut [Vec<f64>; 3], matrix: Option<[[f64; 3]; 3]>) {
    let Some(matrix) = matrix else { return };
    let [x, y, z] = columns;
    for ((x, y), z) in x.iter_mut().zip(y).zip(z) {
        [*x, *y, *z] = rotate(&matrix, [*x, *y, *z]);
    }
}
