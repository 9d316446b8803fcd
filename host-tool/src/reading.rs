//! How the log of a calibration was read: a calibration is one of a scale, of a mounting and of what its columns mean.

use crate::cli::LogArgs;
use crate::derive::{Definition, needed};
use crate::failure::{Failure, Outcome};
use crate::input::{self, Log, Mounting};
use ironout_analysis::frame::Frame;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Scales that differ by less than this share are the same.
const SAME: f64 = 1e-9;

/// A column of the log, as it was found in the file.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Source {
    /// Its name in the calibration: `mx_ut`, `temp_c`.
    pub name: String,
    /// What it is called in the file.
    pub source: String,
    /// The unit there.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub unit: String,
}

/// The options that decide what the numbers of a log mean, and what the reader found by itself.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Reading {
    /// Scale of a log in counts, µT a count for x, y, z; null for one in microtesla.
    pub ut_per_count: Option<[f64; 3]>,
    /// Each `--rotate`, in turn.
    pub rotate: Vec<String>,
    /// Each `--repair`, and the error codes that were recognised.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub repair: Vec<String>,
    /// From the numbers of the file to the field in body axes, with `rotate` in it; absent in files of earlier programs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frame: Option<Frame>,
    /// The format, in words.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub format: String,
    /// Each `--map`: those that were given, or those that pin what the reader found.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub map: Vec<String>,
    /// Which sensor of the log, where it had several.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub instance: Option<usize>,
    /// Each `--derive` that the calibration needs, in turn.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub derive: Vec<String>,
    /// What is which column, in which unit.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub columns: Vec<Source>,
    /// What the reader undid: an autopilot's calibration.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub taken_out: Vec<String>,
}

impl Reading {
    /// Of a log that was read with these options, for a calibration that reads these columns.
    ///
    /// # Errors
    /// Options that cannot be read.
    pub fn of(log: &Log, arguments: &LogArgs, columns: &[String]) -> Outcome<Self> {
        let definitions =
            arguments.derive.iter().map(|text| Definition::parse(text)).collect::<Outcome<Vec<_>>>()?;
        let pinned = log.read_as.pins.iter().filter(|(option, _)| option == "--map");
        let pinned: Vec<String> = pinned.map(|(_, value)| value.clone()).collect();
        let columns_of_file = log.read_as.columns.iter().map(|column| Source {
            name: column.name.clone(),
            source: column.source.clone(),
            unit: column.unit.clone(),
        });
        Ok(Reading {
            ut_per_count: log.ut_per_count,
            rotate: arguments.rotate.clone(),
            repair: log.read_as.repairs.clone(),
            frame: Some(log.frame.clone()),
            format: log.read_as.format.clone(),
            map: if pinned.is_empty() { arguments.map.clone() } else { pinned },
            instance: log.read_as.instance.as_ref().map(|instance| instance.taken).or(arguments.instance),
            derive: needed(&definitions, columns).into_iter().map(Definition::typed).collect(),
            columns: columns_of_file.collect(),
            taken_out: log.read_as.taken_out.clone(),
        })
    }

    /// Whether the numbers can be meant.
    ///
    /// # Errors
    /// A scale that is not positive, a rotation, a map or a derived column that is none.
    pub fn check(&self) -> Outcome<()> {
        let not = |what: &str| Failure::not_a_calibration(what).at_column("reading");
        let positive = |value: &f64| value.is_finite() && *value > 0.0;
        if self.ut_per_count.is_some_and(|scale| !scale.iter().all(positive)) {
            return Err(not("ut_per_count is not positive"));
        }
        Mounting::parse(&self.rotate).map_err(|failure| not(&failure.message))?;
        input::parse_repair(&self.repair).map_err(|failure| not(&failure.message))?;
        if let Some(frame) = &self.frame {
            frame.check().map_err(not)?;
        }
        input::parse_map(&self.map).map_err(|failure| not(&failure.message))?;
        for text in &self.derive {
            Definition::parse(text).map_err(|failure| not(&failure.message))?;
        }
        Ok(())
    }

    /// From the numbers of the calibration's log to its field. A file of an earlier program says scale and mounting alone.
    ///
    /// # Errors
    /// A rotation that is none.
    pub fn frame(&self) -> Outcome<Frame> {
        let repairs = self.repair.clone();
        if let Some(frame) = &self.frame {
            return Ok(Frame { repairs, ..frame.clone() });
        }
        let plain =
            Frame { ut_per_number: self.ut_per_count.unwrap_or([1.0; 3]), repairs, ..Frame::default() };
        Ok(match Mounting::parse(&self.rotate)?.magnetometer {
            Some(rotation) => plain.turned(&rotation),
            None => plain,
        })
    }

    /// The options with which a log is read for this calibration: those that are given, else those that were kept.
    ///
    /// # Errors
    /// A derived column of a kept name that is given otherwise.
    pub fn fill(&self, file: &Path, given: &LogArgs) -> Outcome<LogArgs> {
        let mut filled = given.clone();
        let or_kept = |given: &mut Vec<String>, kept: &[String]| {
            if given.is_empty() {
                *given = kept.to_vec();
            }
        };
        or_kept(&mut filled.map, &self.map);
        or_kept(&mut filled.rotate, &self.rotate);
        or_kept(&mut filled.repair, &self.repair);
        filled.instance = given.instance.or(self.instance);
        let own = given.derive.iter().map(|text| Definition::parse(text)).collect::<Outcome<Vec<_>>>()?;
        for text in &self.derive {
            let kept = Definition::parse(text)?;
            if let Some(other) = own.iter().find(|other| other.name == kept.name && **other != kept) {
                return Err(differs(file, &[format!("--derive    kept {text}, here {}", other.typed())]));
            }
        }
        let kept = self.derive.iter().filter(|text| !given.derive.contains(text)).cloned();
        filled.derive = kept.chain(given.derive.iter().cloned()).collect();
        Ok(filled)
    }

    /// Whether a log was read as that of the calibration in `file` was. `arguments` are those it was read with.
    ///
    /// # Errors
    /// What differs, line by line: its corrected vectors would be wrong.
    pub fn must_fit(&self, file: &Path, log: &Log, arguments: &LogArgs) -> Outcome<()> {
        let mut lines = Vec::new();
        let words = |scale: [f64; 3]| match scale {
            [x, y, z] if x == y && y == z => x.to_string(),
            all => all.map(|value| value.to_string()).join(","),
        };
        if let (Some(own), Some(given)) = (self.ut_per_count, log.ut_per_count)
            && own.iter().zip(given).any(|(own, given)| (own - given).abs() > SAME * own)
        {
            lines.push(format!("--ut-per-count  stored {}, here {}", words(own), words(given)));
        }
        // Said in so many words: this log stands in body axes already.
        let already = arguments.rotate == ["none"];
        if !already && turned(&self.rotate)? != turned(&arguments.rotate)? {
            lines.push(format!(
                "--rotate    stored {}, here {}",
                typed(&self.rotate),
                typed(&arguments.rotate)
            ));
        }
        let here = log.read_as.instance.as_ref().map(|instance| instance.taken);
        if let (Some(own), Some(here)) = (self.instance, here)
            && own != here
        {
            lines.push(format!("--instance  stored {own}, here {here}"));
        }
        if lines.is_empty() {
            return Ok(());
        }
        lines.extend(self.of_the_files(log));
        Err(differs(file, &lines))
    }

    /// The failure of a log that cannot be read with the kept options: what they are, and what is there.
    pub fn cannot(&self, file: &Path, failure: &Failure) -> Failure {
        let mut lines: Vec<String> = self.map.iter().map(|map| format!("stored  --map {map}")).collect();
        lines.extend(self.derive.iter().map(|text| format!("stored  --derive {text}")));
        if !self.format.is_empty() {
            lines.push(format!("stored  format {}", self.format));
        }
        lines.push(format!("here  {}", failure.message));
        let plain = Failure::usage(format!(
            "this log cannot be read like that of {}:\n{}\nFix: use --map or --instance, or fit again",
            file.display(),
            lines.join("\n")
        ));
        Failure { file: failure.file.clone(), line: failure.line, column: failure.column.clone(), ..plain }
    }

    /// What the two files call things, where they differ: no reason to refuse, but worth a note.
    fn of_the_files(&self, log: &Log) -> Vec<String> {
        let mut lines = Vec::new();
        if !self.format.is_empty() && self.format != log.read_as.format {
            lines.push(format!("format      stored {}, here {}", self.format, log.read_as.format));
        }
        for own in &self.columns {
            let here = log.read_as.columns.iter().find(|column| column.name == own.name);
            if let Some(here) = here.filter(|here| here.source != own.source || here.unit != own.unit) {
                let words = |source: &str, unit: &str| format!("{source} {unit}").trim().to_string();
                lines.push(format!(
                    "{:<11} stored {}, here {}",
                    own.name,
                    words(&own.source, &own.unit),
                    words(&here.source, &here.unit)
                ));
            }
        }
        lines
    }
}

fn differs(file: &Path, lines: &[String]) -> Failure {
    Failure::usage(format!(
        "the log of this calibration was read differently:\n{}\nFix: omit these options (the calibration contains its own), \
         or fit again. If a log is in body axes already, use --rotate none",
        lines.join("\n")
    ))
    .in_file(file)
    .at_column("reading")
}

/// The rotation of the magnetometer, to six digits.
fn turned(rotate: &[String]) -> Outcome<[i64; 9]> {
    let identity = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let matrix = Mounting::parse(rotate)?.magnetometer.unwrap_or(identity);
    let mut rounded = [0; 9];
    for (cell, value) in rounded.iter_mut().zip(matrix.iter().flatten()) {
        *cell = (value * 1e6).round() as i64;
    }
    Ok(rounded)
}

fn typed(rotate: &[String]) -> String {
    match rotate {
        [] => "no --rotate".to_string(),
        all => all.iter().map(|form| format!("--rotate={form}")).collect::<Vec<_>>().join(" "),
    }
}
