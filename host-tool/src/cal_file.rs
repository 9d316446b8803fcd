//! `CAL.json`: what `fit --json` prints, with a version and the information behind it.

use crate::failure::{Failure, Outcome};
use crate::reading::Reading;
use crate::registry::REGISTRY;
use ironout::calibration::Calibration;
use ironout::effect::Need;
use ironout::fit::Method;
use ironout_analysis::Fitted;
use ironout_analysis::base::beside_gyro::BesideGyro;
use ironout_analysis::calibration::Accelerometer;
use ironout_analysis::calibration::{EffectEntry, HoldsFor, Information, StdErrors};
use ironout_analysis::effects::{Calibrated, calibrated};
use ironout_analysis::outcome::contradiction::Contradiction;
use ironout_analysis::samples::samples::Condition;
use ironout_analysis::unlogged::recordings::Recordings;
use nalgebra::Matrix3;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::io::Read;
use std::path::Path;

/// The version this program writes and reads.
pub const VERSION: u32 = 1;
/// No soft iron that the core accepts stretches one axis this many times as much as another.
const MOST_STRETCH: f64 = 20.0;
/// A calibration file is a few kilobytes; more is something else.
const MAX_BYTES: u64 = 4 << 20;

/// The object of `fit --json`. Unknown values are null.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs)] // docs/command-line.md explains each key
pub struct FitObject {
    pub method: String,
    pub samples_used: u64,
    pub samples_set_aside: u64,
    pub field_ut: Option<f64>,
    pub offset_ut: Option<[f64; 3]>,
    pub matrix: Option<[[f64; 3]; 3]>,
    pub effects: Vec<EffectEntry>,
    pub std_errors: Option<StdErrors>,
    pub rms_ut: Option<f64>,
    pub holdout_rms_ut: Option<f64>,
    pub noise_floor_ut: Option<f64>,
    pub residual_floor_ut: Option<f64>,
    #[serde(default)]
    pub residual_floor_least_ut: Option<f64>,
    #[serde(default)]
    pub predicted_error_ut: Option<f64>,
    pub heading_error_deg: Option<f64>,
    pub coverage: Option<f64>,
    pub gap_deg: Option<f64>,
    pub accepted: bool,
    pub reasons: Vec<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub contradiction: Option<Contradiction>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub beside_gyro: Option<BesideGyro>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub accelerometer: Option<Accelerometer>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub holds_for: Option<HoldsFor>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub recordings: Option<Recordings>,
}

impl FitObject {
    /// Of a fit by `method`.
    pub fn of(fitted: &Fitted, method: &str) -> Self {
        let solution = fitted.solution.as_ref();
        FitObject {
            method: method.to_string(),
            samples_used: fitted.used as u64,
            samples_set_aside: fitted.set_aside() as u64,
            field_ut: solution.map(|s| s.calibration.field_ut),
            offset_ut: solution.map(|s| s.calibration.offset_ut),
            matrix: solution.map(|s| s.calibration.matrix),
            effects: solution.map_or(Vec::new(), |s| s.effects.iter().map(EffectEntry::from).collect()),
            std_errors: solution.map(|s| s.std_errors.clone()),
            rms_ut: solution.map(|s| s.rms_ut),
            holdout_rms_ut: fitted.holdout_rms_ut,
            noise_floor_ut: fitted.noise_floor_ut,
            residual_floor_ut: fitted.residual_floor_ut,
            residual_floor_least_ut: fitted.residual_floor_least_ut,
            predicted_error_ut: solution.map(|s| s.vector_error_ut()).filter(|error| error.is_finite()),
            heading_error_deg: fitted.heading_error_deg,
            coverage: fitted.coverage,
            gap_deg: fitted.gap_deg,
            accepted: fitted.accepted,
            reasons: fitted.reasons.iter().map(ToString::to_string).collect(),
            contradiction: fitted.contradiction.clone(),
            beside_gyro: fitted.beside_gyro,
            accelerometer: fitted.accelerometer,
            holds_for: fitted.holds_for.clone(),
            recordings: fitted.recordings.clone(),
        }
    }
}

/// A calibration file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CalFile {
    /// [`VERSION`].
    pub version: u32,
    /// The fit.
    #[serde(flatten)]
    pub fit: FitObject,
    /// What the fit knows, to build on; null where the fit gave none.
    pub information: Option<Information>,
    /// How the log's columns were over the samples of the fit; absent in files of earlier programs and of boards.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub conditions: BTreeMap<String, Condition>,
    /// Which log the fit is of, by its first and last readings; absent in files of earlier programs and of boards. What goes by the
    /// time is applied to that log alone.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fitted_to: Option<String>,
    /// How the log was read; absent in files of earlier programs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reading: Option<Reading>,
}

impl CalFile {
    /// Of a fit by `method`.
    pub fn of(fitted: &Fitted, method: &str) -> Self {
        let information = fitted.solution.as_ref().and_then(|solution| solution.information.clone());
        CalFile {
            version: VERSION,
            fit: FitObject::of(fitted, method),
            information,
            conditions: fitted.conditions.clone(),
            fitted_to: Some(fitted.log.clone()),
            reading: None,
        }
    }

    /// Reads and checks a calibration file: every number finite, the matrix invertible, the information
    /// positive definite, the version known. Errors name file, line and what to do.
    pub fn read(path: &Path) -> Outcome<Self> {
        let mut text = String::new();
        let file = std::fs::File::open(path).map_err(|error| Failure::io("open", path, &error))?;
        file.take(MAX_BYTES + 1).read_to_string(&mut text).map_err(|error| match error.kind() {
            std::io::ErrorKind::InvalidData => {
                Failure::not_a_calibration("not text. Did you swap LOG and CAL?").in_file(path)
            }
            _ => Failure::io("read", path, &error),
        })?;
        if text.len() as u64 > MAX_BYTES {
            return Err(Failure::not_a_calibration("it is larger than 4 MB").in_file(path));
        }
        Self::parse(&text).map_err(|failure| failure.in_file(path))
    }

    /// [`CalFile::read`] from the text of the file.
    pub fn parse(text: &str) -> Outcome<Self> {
        let place = |error: serde_json::Error, what: String| {
            let failure = Failure::not_a_calibration(&what);
            if error.line() == 0 { failure } else { failure.at_line(error.line() as u64) }
        };
        let value: serde_json::Value = serde_json::from_str(text).map_err(|error| {
            if text.trim().is_empty() {
                return Failure::not_a_calibration("it is empty");
            }
            match text.trim_start().starts_with('{') {
                true => place(error, "damaged JSON".into()),
                false => Failure::not_a_calibration("not JSON. Did you swap LOG and CAL?"),
            }
        })?;
        // The version first: the rest may differ between versions.
        match value.get("version").and_then(serde_json::Value::as_u64) {
            Some(version) if version == u64::from(VERSION) => {}
            Some(version) => {
                return Err(Failure::usage(format!(
                    "this calibration has version {version}, but this program reads version {VERSION}. Use the program that \
                     wrote it, or fit again"
                ))
                .at_column("version"));
            }
            None => return Err(Failure::not_a_calibration("it has no version").at_column("version")),
        }
        let cal: CalFile = serde_json::from_value(value).map_err(|error| {
            let what = error.to_string();
            place(error, what)
        })?;
        cal.check()?;
        Ok(cal)
    }

    /// The calibration in it.
    pub fn calibration(&self) -> Outcome<Calibration<f64>> {
        let unknown = |key: &str| Failure::not_a_calibration(&format!("{key} is null")).at_column(key);
        Ok(Calibration {
            offset_ut: self.fit.offset_ut.ok_or_else(|| unknown("offset_ut"))?,
            matrix: self.fit.matrix.ok_or_else(|| unknown("matrix"))?,
            field_ut: self.fit.field_ut.ok_or_else(|| unknown("field_ut"))?,
        })
    }

    /// The columns that its effects read, a gyro among them.
    pub fn read_columns(&self) -> Vec<String> {
        let effects = &self.fit.effects;
        let mut columns: Vec<String> = effects.iter().flat_map(|effect| effect.columns.clone()).collect();
        let turns = |effect: &EffectEntry| {
            let named = REGISTRY.parse(&effect.id);
            named.is_some_and(|named| named.family.need(named.form) == Some(Need::Gyro))
        };
        if effects.iter().any(turns) {
            columns.extend(["gx_radps", "gy_radps", "gz_radps"].map(String::from));
        }
        columns
    }

    /// The calibration with its effects.
    pub fn extended(&self) -> Outcome<Calibrated> {
        calibrated(self.calibration()?, &self.fit.effects, REGISTRY)
            .map_err(|why| Failure::not_a_calibration(&why).at_column("effects"))
    }

    fn check(&self) -> Outcome<()> {
        let calibration = self.calibration()?;
        if !(calibration.field_ut.is_finite() && (0.1..=1e5).contains(&calibration.field_ut)) {
            return Err(Failure::not_a_calibration(&format!(
                "field_ut is {} and should be a magnitude in microtesla",
                calibration.field_ut
            ))
            .at_column("field_ut"));
        }
        if !calibration.is_sound() {
            return Err(
                Failure::not_a_calibration("the matrix is singular or mirrors the axes").at_column("matrix")
            );
        }
        if calibration.offset_ut.iter().any(|value| value.abs() > 1e6) {
            return Err(
                Failure::not_a_calibration("the offset is beyond any magnetometer").at_column("offset_ut")
            );
        }
        if calibration.matrix.iter().flatten().any(|value| value.abs() > 1e3) {
            return Err(
                Failure::not_a_calibration("the matrix is beyond any magnetometer").at_column("matrix")
            );
        }
        let ranges = self.fit.effects.iter().filter_map(|entry| entry.range.as_ref()).flatten();
        for (column, [least, most]) in ranges {
            if least.is_nan() || least > most {
                return Err(Failure::not_a_calibration(&format!(
                    "the range of {column} ends before it begins"
                ))
                .at_column("effects"));
            }
        }
        if let Some((column, _)) = self.conditions.iter().find(|(_, condition)| !condition.is_sound()) {
            return Err(Failure::not_a_calibration(&format!("the mean of {column} is implausible"))
                .at_column("conditions"));
        }
        if !self.extended()?.is_sound() {
            return Err(Failure::not_a_calibration("an effect contains a number that is not finite")
                .at_column("effects"));
        }
        if Method::parse(&self.fit.method).is_none() {
            return Err(Failure::not_a_calibration(&format!("there is no method {:?}", self.fit.method))
                .at_column("method"));
        }
        let c = Matrix3::from_fn(|i, j| calibration.matrix[i][j]);
        let stretch = c.singular_values();
        if !(stretch.min() > MOST_STRETCH.recip() * stretch.max()) {
            return Err(Failure::not_a_calibration("the matrix is nearly singular").at_column("matrix"));
        }
        let fit = &self.fit;
        for (key, value) in [
            ("rms_ut", fit.rms_ut),
            ("holdout_rms_ut", fit.holdout_rms_ut),
            ("noise_floor_ut", fit.noise_floor_ut),
            ("residual_floor_ut", fit.residual_floor_ut),
            ("residual_floor_least_ut", fit.residual_floor_least_ut),
        ] {
            if value.is_some_and(|value| !(value >= 0.0 && value.is_finite())) {
                return Err(Failure::not_a_calibration(&format!("{key} is negative")).at_column(key));
            }
        }
        if !self.fit.accepted {
            return Err(Failure::not_a_calibration(&format!(
                "the fit was refused ({})",
                self.fit.reasons.join("; ")
            )));
        }
        if let Some(information) = &self.information {
            information.check().map_err(|what| Failure::not_a_calibration(what).at_column("information"))?;
        }
        if let Some(reading) = &self.reading {
            reading.check()?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample() -> CalFile {
        let mut covariance = [[0.0; 9]; 9];
        for (i, row) in covariance.iter_mut().enumerate() {
            row[i] = if i < 3 { 1e-4 } else { 1e-8 };
        }
        CalFile {
            version: VERSION,
            fit: FitObject {
                holds_for: None,
                method: "adjusted".into(),
                samples_used: 3000,
                samples_set_aside: 0,
                field_ut: Some(48.125),
                offset_ut: Some([0.1, 1.0 / 3.0, -7.0]),
                matrix: Some([[1.0, 0.1, 0.0], [0.0, 1.0, 0.2], [0.0, 0.0, 0.9]]),
                effects: vec![],
                std_errors: None,
                rms_ut: Some(0.3),
                holdout_rms_ut: None,
                noise_floor_ut: None,
                residual_floor_ut: None,
                residual_floor_least_ut: None,
                predicted_error_ut: None,
                heading_error_deg: None,
                coverage: None,
                gap_deg: None,
                accepted: true,
                reasons: vec![],
                contradiction: None,
                beside_gyro: None,
                accelerometer: None,
                recordings: None,
            },
            information: Information::from_covariance(&covariance),
            conditions: BTreeMap::from([("temp_c".into(), Condition { mean: 21.5, mean_square: 463.0 })]),
            fitted_to: None,
            reading: Some(Reading {
                ut_per_count: Some([0.1; 3]),
                rotate: vec!["roll180".into()],
                ..Reading::default()
            }),
        }
    }

    fn effect(id: &str) -> serde_json::Value {
        serde_json::json!([{
            "id": id, "name": "", "columns": ["temp_c"], "coefficients": [0.1, 0.2, 0.3], "std_errors": [0.01, 0.01, 0.01],
            "unit": "", "reference": {"temp_c": 25.0}, "parameters": {},
        }])
    }

    #[test]
    fn effects_are_read_and_wrong_ones_named() {
        let cal = reread(|v| v["effects"] = effect("offset:temp_c")).expect("sound");
        let extended = cal.extended().expect("sound");
        let mut conditions = ironout::extended::Conditions::unknown();
        conditions.inputs[0][0] = 35.0;
        let plain = extended.base.apply([9.0, 8.0, 7.0]);
        assert_eq!(extended.apply([10.0, 10.0, 10.0], &conditions), Ok(plain));
        for (word, change) in [
            ("3 coefficients", ("coefficients", serde_json::json!([0.1]))),
            ("no reference", ("reference", serde_json::json!({}))),
        ] {
            let failure = reread(|v| {
                v["effects"] = effect("offset:temp_c");
                v["effects"][0][change.0] = change.1.clone();
            })
            .expect_err(word);
            assert!(failure.message.contains(word), "{failure}");
        }
        let five = serde_json::Value::Array(vec![effect("gain:temp_c")[0].clone(); 5]);
        assert!(reread(|v| v["effects"] = five).expect_err("too many").message.contains("more than 4"));
    }

    fn reread(change: impl FnOnce(&mut serde_json::Value)) -> Outcome<CalFile> {
        let mut value = serde_json::to_value(sample()).expect("serialises");
        change(&mut value);
        CalFile::parse(&value.to_string())
    }

    #[test]
    fn a_file_reads_back_to_the_same_bits() {
        let cal = sample();
        assert!(cal.information.is_some());
        assert_eq!(CalFile::parse(&serde_json::to_string_pretty(&cal).expect("serialises")), Ok(cal));
    }

    #[test]
    fn what_is_no_calibration_is_named() {
        let cases: [(&str, Outcome<CalFile>); 17] = [
            ("nearly singular", reread(|v| v["matrix"][2][2] = 1e-3.into())),
            ("rms_ut is negative", reread(|v| v["rms_ut"] = (-1.0).into())),
            ("no method", reread(|v| v["method"] = "zzz".into())),
            ("no effect wobble", reread(|v| v["effects"] = effect("wobble"))),
            ("version 7", reread(|v| v["version"] = 7.into())),
            ("no version", reread(|v| drop(v.as_object_mut().map(|o| o.remove("version"))))),
            ("singular", reread(|v| v["matrix"][2][2] = 0.0.into())),
            ("null", reread(|v| v["offset_ut"] = serde_json::Value::Null)),
            ("length 2", reread(|v| v["offset_ut"] = serde_json::json!([1, 2]))),
            ("microtesla", reread(|v| v["field_ut"] = (-4.0).into())),
            ("refused", reread(|v| v["accepted"] = false.into())),
            ("positive definite", reread(|v| v["information"]["matrix"][4][4] = (-1.0).into())),
            ("ut_per_count", reread(|v| v["reading"]["ut_per_count"][1] = 0.0.into())),
            ("sideways", reread(|v| v["reading"]["rotate"][0] = "sideways".into())),
            ("no =", reread(|v| v["reading"]["derive"] = serde_json::json!(["drive"]))),
            ("NAME=HEADER", reread(|v| v["reading"]["map"] = serde_json::json!(["mx_ut"]))),
            ("symmetric", reread(|v| v["information"]["matrix"][4][5] = 1e3.into())),
        ];
        for (word, outcome) in cases {
            let failure = outcome.expect_err(word);
            assert!(failure.message.contains(word), "{word}: {failure}");
            assert_eq!(failure.exit, 2);
        }
        for text in ["", "{", "[]", "null", "{\"version\": 1}", "\u{0}", "{\"version\":1e999}"] {
            assert!(CalFile::parse(text).is_err(), "{text:?}");
        }
        assert_eq!(CalFile::parse("{\n\"a\": 1,\n!").expect_err("broken").line, Some(3));
    }
}
