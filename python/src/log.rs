//! A log in memory.

use crate::wait::{on_thread, raised};
use crate::{columns, options};
use ironout_cli::cli::{LogArgs, SimulateArgs};
use ironout_cli::failure::Failure;
use ironout_cli::plausible::Known;
use ironout_cli::simulated::{simulated, truth_json};
use ironout_cli::{input, read_block, source};
use numpy::{PyArray1, PyReadonlyArray1, ToPyArray};
use pyo3::prelude::*;
use std::sync::Arc;

/// A log with its columns, and the options that it was read with.
#[pyclass(frozen, module = "ironout._ironout")]
pub struct Log {
    pub inner: Arc<Inner>,
}

/// What threads share.
pub struct Inner {
    pub log: input::Log,
    pub arguments: LogArgs,
}

impl Log {
    fn new(log: input::Log, arguments: LogArgs) -> Self {
        Log { inner: Arc::new(Inner { log, arguments }) }
    }
}

#[pymethods]
impl Log {
    /// Name of the file, or of the table.
    #[getter]
    fn name(&self) -> String {
        self.inner.log.path.display().to_string()
    }

    /// Number of rows.
    #[getter]
    fn rows(&self) -> usize {
        self.inner.log.rows
    }

    /// What to know about how the log was read.
    #[getter]
    fn notices(&self) -> Vec<String> {
        self.inner.log.notices.clone()
    }

    /// JSON of how the log was read.
    fn read_as(&self) -> String {
        read_block::json(&self.inner.log).to_string()
    }

    /// How the log was read, in words.
    fn read_words(&self) -> String {
        read_block::text(&self.inner.log)
    }

    /// Vehicle, sensor and start, as far as the file names them.
    #[getter]
    fn origin(&self) -> (Option<String>, Option<String>, Option<String>) {
        let origin = self.inner.log.read_as.origin.clone();
        (origin.vehicle, origin.sensor, origin.start)
    }

    /// Names of the columns.
    #[getter]
    fn columns(&self) -> Vec<String> {
        self.inner.names()
    }

    /// One column as an array.
    fn column<'py>(&self, py: Python<'py>, name: &str) -> Option<Bound<'py, PyArray1<f64>>> {
        self.inner.column(name).map(|values| values.to_pyarray(py))
    }

    fn __len__(&self) -> usize {
        self.inner.log.rows
    }
}

const FIELD: [&str; 3] = ["mx_ut", "my_ut", "mz_ut"];
const ACCEL: [&str; 3] = ["ax_mps2", "ay_mps2", "az_mps2"];
const GYRO: [&str; 3] = ["gx_radps", "gy_radps", "gz_radps"];

impl Inner {
    fn names(&self) -> Vec<String> {
        let log = &self.log;
        let optional = |there: bool, names: [&'static str; 3]| there.then_some(names).into_iter().flatten();
        let time = log.time_s.is_some().then_some("t_s").into_iter();
        let known = time
            .chain(FIELD)
            .chain(optional(log.accel_mps2.is_some(), ACCEL))
            .chain(optional(log.gyro_radps.is_some(), GYRO))
            .chain(log.heading_deg.is_some().then_some("heading_deg"))
            .map(String::from);
        known.chain(log.covariates.iter().map(|column| column.name.clone())).collect()
    }

    fn column(&self, name: &str) -> Option<&[f64]> {
        let log = &self.log;
        let axis = |names: [&str; 3]| names.iter().position(|own| *own == name);
        if name == "t_s" {
            return log.time_s.as_deref();
        }
        if name == "heading_deg" {
            return log.heading_deg.as_deref();
        }
        if let Some(axis) = axis(FIELD) {
            return Some(&log.field_ut[axis]);
        }
        if let Some(axis) = axis(ACCEL) {
            return log.accel_mps2.as_ref().map(|axes| axes[axis].as_slice());
        }
        if let Some(axis) = axis(GYRO) {
            return log.gyro_radps.as_ref().map(|axes| axes[axis].as_slice());
        }
        log.covariate(name).map(|column| column.values.as_slice())
    }
}

/// Reads a file of any format.
#[pyfunction]
#[pyo3(signature = (asked, field_ut=None, progress=None))]
pub fn read(
    py: Python<'_>,
    asked: &str,
    field_ut: Option<f64>,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Log> {
    let arguments = options::reading(asked).map_err(|failure| raised(&failure))?.arguments();
    on_thread(py, "reading", progress, move || {
        let log = source::read_quietly(&arguments, &Known::given(field_ut))?;
        Ok(Log::new(log, arguments))
    })
}

/// The log of columns in memory.
#[pyfunction]
#[pyo3(signature = (names, values, asked, field_ut=None))]
pub fn from_columns(
    py: Python<'_>,
    names: Vec<String>,
    values: Vec<PyReadonlyArray1<'_, f64>>,
    asked: &str,
    field_ut: Option<f64>,
) -> PyResult<Log> {
    let arguments = options::reading(asked).map_err(|failure| raised(&failure))?.arguments();
    // The log owns its columns: the caller may change the arrays meanwhile.
    let values: Vec<Vec<f64>> = values.iter().map(|column| column.as_array().to_vec()).collect();
    on_thread(py, "reading", None, move || {
        let log = columns::log(names, values, &arguments)?;
        let log = source::finish_quietly(log, &arguments, &Known::given(field_ut))?;
        Ok(Log::new(log, arguments))
    })
}

/// A simulated log as `ironout simulate` writes it, and its truth as JSON.
#[pyfunction]
#[allow(clippy::too_many_arguments)]
pub fn simulate(
    py: Python<'_>,
    seed: u64,
    seconds: f64,
    rate: f64,
    noise: f64,
    effect: Vec<String>,
    recording: u64,
    motion: String,
    ramp: bool,
    without: Vec<String>,
) -> PyResult<(Log, String)> {
    let output = "simulated".into();
    let asked = SimulateArgs { output, seed, seconds, rate, noise, effect, recording, motion, ramp, without };
    on_thread(py, "simulating", None, move || {
        let (log, words) = simulated(&asked)?;
        let mut csv = Vec::new();
        log.write_csv(&mut csv, &words).map_err(|error| Failure::usage(error.to_string()))?;
        let truth = truth_json(&asked, &log).to_string();
        let arguments = LogArgs::of(&asked.output);
        let read = source::read_bytes(&arguments, &csv, &Known::Earth)?;
        Ok((Log::new(read, arguments), truth))
    })
}
