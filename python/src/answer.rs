//! Fits, diagnoses, corrects, checks and exports, with the words and the JSON of the command line.

use crate::log::{Inner, Log};
use crate::options::{self, Asked};
use crate::wait::{on_thread, raised};
use ironout_analysis::outcome::json;
use ironout_analysis::{Options, Table};
use ironout_cli::cal_file::{CalFile, FitObject};
use ironout_cli::checked::judge::judge;
use ironout_cli::cli::{DiagnoseArgs, ExportArgs, ExportForm, FitArgs, Free};
use ironout_cli::corrected::Corrected;
use ironout_cli::diagnosis_words::{self, DiagnosedLog};
use ironout_cli::failure::{Failure, Outcome};
use ironout_cli::input::formats;
use ironout_cli::reading::Reading;
use ironout_cli::registry::REGISTRY;
use ironout_cli::{exported, fit_words, prior, read_block, refusal, source};
use numpy::{PyArray1, PyArray2, PyArrayMethods, ToPyArray};
use pyo3::prelude::*;
use std::path::{Path, PathBuf};
use std::sync::Arc;

fn text(error: serde_json::Error) -> Failure {
    Failure::usage(error.to_string())
}

fn analysis_options(held: &Inner, asked: &Asked, search: bool) -> Outcome<Options> {
    let prior = asked.prior.as_ref().map(PathBuf::from);
    let expected = asked.field.expected()?;
    let read = |path: &PathBuf| prior::read(path, &held.log, &held.arguments);
    let known = prior.as_ref().map(read).transpose()?;
    Ok(Options {
        method: asked.field.method_with(&asked.add, prior.as_ref())?,
        field_ut: expected.field_ut,
        dip_deg: expected.earth.map(|earth| earth.dip_deg),
        add: asked.add.clone(),
        force_effect: asked.force_effect || search,
        search,
        prior: match asked.free {
            Some(Free::Offset) => known.map(|known| known.without_offset()),
            None => known,
        },
        purpose: asked.purpose.unwrap_or_default(),
        registry: REGISTRY,
        ..Options::default()
    })
}

/// The object of `fit --json`, the text of CAL.json if the fit is accepted, and the words.
#[pyfunction]
#[pyo3(signature = (log, asked, progress=None))]
pub fn fit(
    py: Python<'_>,
    log: &Log,
    asked: &str,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<(String, Option<String>, String)> {
    let asked = options::asked(asked).map_err(|failure| raised(&failure))?;
    let held = Arc::clone(&log.inner);
    on_thread(py, "fitting", progress, move || {
        let options = analysis_options(&held, &asked, false)?;
        let fitted = ironout_analysis::fit(&Table::from(&held.log), &options)
            .map_err(|refusal| refusal::failure(refusal, &held.log.path))?;
        let method = options.method.name();
        let mut object = serde_json::to_value(FitObject::of(&fitted, method)).map_err(text)?;
        object["read_as"] = read_block::json(&held.log);
        let cal = if fitted.accepted {
            let mut cal = CalFile::of(&fitted, method);
            let columns: Vec<String> =
                cal.fit.effects.iter().flat_map(|effect| effect.columns.clone()).collect();
            cal.reading = Some(Reading::of(&held.log, &held.arguments, &columns)?);
            Some(serde_json::to_string_pretty(&cal).map_err(text)? + "\n")
        } else {
            None
        };
        let arguments = FitArgs {
            free: asked.free,
            purpose: asked.purpose,
            headings: Vec::new(),
            prior_from: None,
            log: held.arguments.clone(),
            field: asked.field.clone(),
            output: None,
            add: asked.add.clone(),
            force_effect: asked.force_effect,
            prior: asked.prior.clone().map(PathBuf::from),
        };
        let words = fit_words::text(&arguments, &held.log, &fitted, &asked.field.expected()?);
        Ok((object.to_string(), cal, words))
    })
}

/// The object of `diagnose --json`, its sentence and its words.
#[pyfunction]
#[pyo3(signature = (log, asked, progress=None))]
pub fn diagnose(
    py: Python<'_>,
    log: &Log,
    asked: &str,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<(String, String, String)> {
    let asked = options::asked(asked).map_err(|failure| raised(&failure))?;
    let held = Arc::clone(&log.inner);
    on_thread(py, "studying", progress, move || {
        let options = analysis_options(&held, &asked, true)?;
        let diagnosis = ironout_analysis::diagnose(&Table::from(&held.log), &options)
            .map_err(|refusal| refusal::failure(refusal, &held.log.path))?;
        let mut object = json::object(&diagnosis);
        object["read_as"] = read_block::json(&held.log);
        let arguments = DiagnoseArgs {
            log: held.arguments.clone(),
            field: asked.field.clone(),
            add: asked.add.clone(),
            prior: asked.prior.clone().map(PathBuf::from),
        };
        let diagnosed_log = DiagnosedLog { log: &held.log, arguments: &arguments, diagnosis: &diagnosis };
        let words = diagnosis_words::text(&diagnosed_log);
        Ok((object.to_string(), diagnosis_words::sentence(&diagnosis), words))
    })
}

/// A calibration from the text of a file, checked; `name` is the file in the words of an error.
fn calibration(cal: &str, name: &str) -> Outcome<CalFile> {
    CalFile::parse(cal).map_err(|failure| failure.in_file(Path::new(name)))
}

/// Checks the text of CAL.json and gives it back in order.
#[pyfunction]
pub fn parse(cal: &str, name: &str) -> PyResult<String> {
    let cal = calibration(cal, name).map_err(|failure| raised(&failure))?;
    serde_json::to_string(&cal).map_err(|error| raised(&text(error)))
}

/// The matrix of a mounting by its number among those of PX4; none if there is no such number.
#[pyfunction]
pub fn rotation(number: i64) -> Option<[[f64; 3]; 3]> {
    formats::mounting(number)
}

/// Corrected vectors, their residuals and notes.
type Applied<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray1<f64>>, Vec<String>);

/// The corrected vectors of a log, their residuals, and what to know about them.
#[pyfunction]
pub fn apply<'py>(py: Python<'py>, cal: &str, name: &str, log: &Log) -> PyResult<Applied<'py>> {
    let (cal, name, held) = (cal.to_string(), name.to_string(), Arc::clone(&log.inner));
    let (corrected, residual, notes) = on_thread(py, "correcting", None, move || {
        let cal = calibration(&cal, &name)?;
        let table = Table::from(&held.log);
        let mut notes = Vec::new();
        let fitted_to = cal.fitted_to.as_deref();
        let corrector = Corrected::with_notes(cal.extended()?, fitted_to, &held.log, &table, &mut notes)?;
        let (mut corrected, mut residual) = (Vec::with_capacity(3 * held.log.rows), Vec::new());
        for row in 0..held.log.rows {
            let field = corrector.field(row)?;
            corrected.extend(field);
            residual.push(corrector.residual_ut(row, field));
        }
        notes.extend(corrector.extrapolation(&cal.fit.effects).notices(cal.calibration()?.field_ut));
        Ok((corrected, residual, notes))
    })?;
    let rows = residual.len();
    Ok((corrected.to_pyarray(py).reshape([rows, 3])?, residual.to_pyarray(py), notes))
}

/// The object of `check --json` for a log in memory.
#[pyfunction]
#[pyo3(signature = (cal, name, log, declination=None))]
pub fn check(py: Python<'_>, cal: &str, name: &str, log: &Log, declination: Option<f64>) -> PyResult<String> {
    let (cal, name, held) = (cal.to_string(), name.to_string(), Arc::clone(&log.inner));
    on_thread(py, "checking", None, move || {
        let cal = calibration(&cal, &name)?;
        if let Some(reading) = &cal.reading {
            reading.must_fit(Path::new(&name), &held.log, &held.arguments)?;
        }
        Ok(judge(&cal, &held.log, declination, &mut Vec::new())?.json().to_string())
    })
}

/// The object of `check --json` for a file, which is read as the log of the calibration was.
#[pyfunction]
#[pyo3(signature = (cal, name, asked, declination=None))]
pub fn check_file(
    py: Python<'_>,
    cal: &str,
    name: &str,
    asked: &str,
    declination: Option<f64>,
) -> PyResult<String> {
    let arguments = options::reading(asked).map_err(|failure| raised(&failure))?.arguments();
    let (cal, name) = (cal.to_string(), name.to_string());
    on_thread(py, "checking", None, move || {
        let cal = calibration(&cal, &name)?;
        let log = source::read_quietly_for(&arguments, &cal, Path::new(&name))?;
        Ok(judge(&cal, &log, declination, &mut Vec::new())?.json().to_string())
    })
}

/// The calibration for another program, as `export` writes it.
#[pyfunction]
#[pyo3(signature = (cal, name, form, log=None, number=None, device_id=None, euler=false, ut_per_count=None))]
#[allow(clippy::too_many_arguments)]
pub fn export(
    py: Python<'_>,
    cal: &str,
    name: &str,
    form: &str,
    log: Option<&Log>,
    number: Option<usize>,
    device_id: Option<u32>,
    euler: bool,
    ut_per_count: Option<String>,
) -> PyResult<String> {
    let forms = [
        ExportForm::Rust,
        ExportForm::C,
        ExportForm::Json,
        ExportForm::Px4,
        ExportForm::Ardupilot,
        ExportForm::Betaflight,
        ExportForm::Ros,
        ExportForm::Iio,
    ];
    let Some(form) = forms.into_iter().find(|one| one.name() == form) else {
        let names: Vec<&str> = forms.into_iter().map(ExportForm::name).collect();
        let words = format!("export as {form:?}: expected one of {}", names.join(", "));
        return Err(raised(&Failure::usage(words)));
    };
    let (cal, name, held) = (cal.to_string(), name.to_string(), log.map(|log| Arc::clone(&log.inner)));
    on_thread(py, "exporting", None, move || {
        let cal = calibration(&cal, &name)?;
        let arguments = ExportArgs {
            cal: name.clone().into(),
            form,
            output: None,
            log: held.as_ref().map(|held| held.log.path.clone()),
            map: Vec::new(),
            number,
            device_id,
            euler,
            ut_per_count,
        };
        exported::asked(&arguments)?;
        Ok(exported::text(&cal, &arguments, held.as_ref().map(|held| &held.log))?.text)
    })
}
