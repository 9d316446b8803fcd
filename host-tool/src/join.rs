//! Several logs of one sensor as one.

use crate::failure::{Failure, Outcome};
use crate::input::{Covariate, Log};

/// Between two logs lie this many of their own steps: enough that nothing is taken for a change from one row to the next,
/// and too few to pass for rows that are missing.
const GAP_STEPS: f64 = 10.0;
/// The gap of logs that have no time step of their own, s.
const LEAST_GAP_S: f64 = 0.1;

/// Puts logs one after the other. Their times follow each other with a short gap, whatever clocks they are from, so a drift
/// or a step is one of all logs in turn; a column that one of them lacks is empty there.
///
/// # Errors
/// Logs of another scale or another sensor; none at all.
pub fn join(logs: Vec<Log>) -> Outcome<Log> {
    let timed = logs.iter().all(|log| log.time_s.is_some());
    let gap_s = GAP_STEPS * logs.iter().filter_map(mean_step_s).fold(f64::INFINITY, f64::min);
    let gap_s = if gap_s.is_finite() && gap_s > 0.0 { gap_s } else { LEAST_GAP_S };
    let mut logs = logs.into_iter();
    let mut whole = logs.next().ok_or_else(|| Failure::usage("no log is given"))?;
    for next in logs {
        alike(&whole, &next)?;
        append(&mut whole, next, timed, gap_s);
    }
    Ok(whole)
}

fn mean_step_s(log: &Log) -> Option<f64> {
    let time = log.time_s.as_ref()?;
    let seconds = time.last()? - time.first()?;
    (log.rows > 1 && seconds > 0.0).then(|| seconds / (log.rows - 1) as f64)
}

/// Whether two logs can be of one calibration.
fn alike(first: &Log, next: &Log) -> Outcome<()> {
    let words = |scale: Option<[f64; 3]>| match scale {
        None => "microtesla".to_string(),
        Some(scale) => format!("counts of {} µT", scale.map(|value| value.to_string()).join(",")),
    };
    let fail = |what: String| {
        Failure::usage(format!(
            "{what}. One calibration is for one sensor, read in one way. Fit the logs separately"
        ))
        .in_file(&next.path)
    };
    if first.ut_per_count != next.ut_per_count {
        return Err(fail(format!(
            "this log contains {}, but {} contains {}",
            words(next.ut_per_count),
            first.path.display(),
            words(first.ut_per_count)
        )));
    }
    let instance = |log: &Log| log.read_as.instance.as_ref().map(|instance| instance.taken);
    if let (Some(own), Some(other)) = (instance(first), instance(next))
        && own != other
    {
        return Err(fail(format!(
            "this log's magnetometer is number {other}, but that of {} is number {own}",
            first.path.display()
        )));
    }
    Ok(())
}

fn append(whole: &mut Log, next: Log, timed: bool, gap_s: f64) {
    let (before, rows) = (whole.rows, next.rows);
    let name = next.path.display().to_string();
    match (&mut whole.time_s, &next.time_s) {
        (Some(time), Some(own)) if timed => {
            let begins = time.last().copied().unwrap_or_default() + gap_s;
            let first = own.first().copied().unwrap_or_default();
            time.extend(own.iter().map(|t| begins + (t - first)));
            whole.notices.push(format!(
                "{name} is appended ({rows} rows) at t = {begins:.2} s. A step found at that time means that something \
                 changed between the two recordings"
            ));
        }
        _ => {
            if whole.time_s.take().is_some() || next.time_s.is_some() {
                whole.notices.push(format!(
                    "{name}: not every log has a time column, so ironout reads all without time"
                ));
            }
        }
    }
    if next.frame != whole.frame {
        whole.notices.push(format!(
            "{name}: its numbers are in another frame (axes, unit or removed calibration). Exports are for the numbers of \
             the first log"
        ));
    }
    for (column, own) in whole.field_ut.iter_mut().zip(next.field_ut) {
        column.extend(own);
    }
    whole.counts = match (whole.counts.take(), next.counts) {
        (Some(mut counts), Some(own)) => {
            counts.extend(own);
            Some(counts)
        }
        _ => None,
    };
    sensor(&mut whole.accel_mps2, next.accel_mps2, before, rows);
    sensor(&mut whole.gyro_radps, next.gyro_radps, before, rows);
    if whole.heading_deg.is_some() || next.heading_deg.is_some() {
        let mut heading = whole.heading_deg.take().unwrap_or_else(|| vec![f64::NAN; before]);
        heading.extend(next.heading_deg.unwrap_or_else(|| vec![f64::NAN; rows]));
        whole.heading_deg = Some(heading);
    }
    // What is known of the field of one of the logs says nothing about the others.
    whole.earth = whole.earth.take().zip(next.earth).map(|([mut field, mut dip], [own, own_dip])| {
        field.extend(own);
        dip.extend(own_dip);
        [field, dip]
    });
    covariates(whole, next.covariates, before, rows, &name);
    whole.recordings.push(before);
    whole.recordings.extend(next.recordings.iter().map(|first| before + first));
    whole.rows = before + rows;
    whole.read_as.left_out.extend(next.read_as.left_out);
    whole.path = format!("{} + {name}", whole.path.display()).into();
}

/// A sensor that one of the logs lacks is missing there.
fn sensor(whole: &mut Option<[Vec<f64>; 3]>, next: Option<[Vec<f64>; 3]>, before: usize, rows: usize) {
    if whole.is_none() && next.is_none() {
        return;
    }
    let mut axes = whole.take().unwrap_or_else(|| [0, 1, 2].map(|_| vec![f64::NAN; before]));
    let own = next.unwrap_or_else(|| [0, 1, 2].map(|_| vec![f64::NAN; rows]));
    for (column, own) in axes.iter_mut().zip(own) {
        column.extend(own);
    }
    *whole = Some(axes);
}

fn covariates(whole: &mut Log, next: Vec<Covariate>, before: usize, rows: usize, name: &str) {
    let mut lacking: Vec<String> = Vec::new();
    for column in &mut whole.covariates {
        if !next.iter().any(|own| own.name == column.name) {
            column.values.extend(std::iter::repeat_n(f64::NAN, rows));
            column.empty += rows;
            lacking.push(column.name.clone());
        }
    }
    for own in next {
        match whole.covariates.iter_mut().find(|column| column.name == own.name) {
            Some(column) => {
                column.values.extend(own.values);
                column.empty += own.empty;
                column.not_finite += own.not_finite;
            }
            None => {
                let mut values = vec![f64::NAN; before];
                values.extend(own.values);
                whole.notices.push(format!("{name}: column {} exists only from here on", own.name));
                whole.covariates.push(Covariate { values, empty: own.empty + before, ..own });
            }
        }
    }
    if !lacking.is_empty() {
        whole.notices.push(format!("{name}: it lacks {}, which stay empty there", lacking.join(", ")));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn log(name: &str, time: Option<[f64; 3]>, covariate: Option<&str>) -> Log {
        let covariates = covariate.map(|name| Covariate {
            name: name.into(),
            values: vec![1.0, 2.0, 3.0],
            empty: 0,
            not_finite: 0,
        });
        Log {
            path: name.into(),
            rows: 3,
            time_s: time.map(|time| time.to_vec()),
            field_ut: [0.0, 1.0, 2.0].map(|v| vec![v; 3]),
            covariates: covariates.into_iter().collect(),
            ..Log::default()
        }
    }

    #[test]
    fn times_follow_each_other_and_columns_stay_where_they_are_known() {
        let mut second = log("b", Some([100.0, 100.1, 100.2]), Some("vbat"));
        second.accel_mps2 = Some([0, 1, 2].map(|_| vec![9.8; 3]));
        let joined = join(vec![log("a", Some([5.0, 5.1, 5.2]), Some("temp_c")), second]).expect("alike");
        let time = joined.time_s.expect("time");
        assert!(time.windows(2).all(|pair| pair[1] > pair[0]) && (time[3] - 6.2).abs() < 1e-9, "{time:?}");
        assert_eq!(joined.rows, 6);
        assert_eq!(joined.path.display().to_string(), "a + b");
        assert_eq!(joined.covariates.iter().map(|c| c.empty).collect::<Vec<_>>(), [3, 3]);
        assert!(joined.covariates.iter().all(|column| column.values.len() == 6));
        assert!(joined.accel_mps2.is_some_and(|accel| accel[0][0].is_nan() && accel[2][5] == 9.8));
        assert!(
            joined.notices.iter().any(|notice| notice.contains("it lacks temp_c")),
            "{:?}",
            joined.notices
        );
    }

    #[test]
    fn one_without_time_takes_it_from_all_and_says_so() {
        let joined = join(vec![log("a", Some([0.0, 0.1, 0.2]), None), log("b", None, None)]).expect("alike");
        assert!(
            joined.time_s.is_none()
                && joined.notices.iter().any(|notice| notice.contains("reads all without time"))
        );
    }

    #[test]
    fn another_scale_or_sensor_is_refused() {
        let other = Log { ut_per_count: Some([0.1; 3]), ..log("b", None, None) };
        let failure = join(vec![log("a", None, None), other]).expect_err("another scale");
        assert!(
            failure.message.contains("counts of 0.1") && failure.file.as_deref() == Some("b"),
            "{failure}"
        );
        let taken = |name: &str, taken: usize| {
            let mut log = log(name, None, None);
            log.read_as.instance = Some(crate::input::Instance { taken, there: vec![] });
            log
        };
        assert!(join(vec![taken("a", 0), taken("b", 1)]).is_err());
        assert!(join(vec![taken("a", 1), taken("b", 1)]).is_ok());
        assert!(join(vec![]).is_err());
    }
}
