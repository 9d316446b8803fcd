//! The exact sums of a log in parts.

use crate::wait::raised;
use ironout::fit::{FitOptions, Method};
use ironout::moments::Moments as Core;
use ironout::scatter::Scatter;
use ironout_cli::failure::Failure;
use numpy::PyReadonlyArray2;
use pyo3::prelude::*;

/// Exact integer sums of 16-bit samples. Sums of parts merge exactly, in any order.
#[pyclass(frozen, module = "ironout._ironout")]
pub struct Moments {
    inner: Core,
}

fn refuse(words: impl Into<String>) -> PyErr {
    raised(&Failure::usage(words))
}

#[pymethods]
impl Moments {
    /// Of counts, one row per sample.
    #[new]
    #[pyo3(signature = (counts=None))]
    fn new(py: Python<'_>, counts: Option<PyReadonlyArray2<'_, i16>>) -> PyResult<Self> {
        let mut inner = Core::new();
        let Some(counts) = counts else { return Ok(Moments { inner }) };
        let counts = counts.as_array();
        if counts.ncols() != 3 {
            return Err(refuse(format!("{} columns: expected three, x, y and z", counts.ncols())));
        }
        py.detach(|| counts.rows().into_iter().for_each(|row| inner.push([row[0], row[1], row[2]])));
        Ok(Moments { inner })
    }

    /// Number of samples.
    #[getter]
    fn count(&self) -> u64 {
        self.inner.count()
    }

    /// The 35 sums as text, for another process.
    fn sums(&self) -> Vec<String> {
        self.inner.sums().iter().map(i128::to_string).collect()
    }

    /// The sums of [`Self::sums`].
    #[staticmethod]
    fn from_sums(sums: Vec<String>) -> PyResult<Self> {
        let parsed: Option<Vec<i128>> = sums.iter().map(|sum| sum.parse().ok()).collect();
        let all = parsed.and_then(|sums| sums.try_into().ok());
        match all.and_then(|sums| Core::from_sums(&sums)) {
            Some(inner) => Ok(Moments { inner }),
            None => Err(refuse("these are not sums of samples: expected the 35 integers of Moments.sums()")),
        }
    }

    /// The sums of both.
    fn __add__(&self, other: &Self) -> PyResult<Self> {
        let mut inner = self.inner;
        match inner.merge(&other.inner) {
            true => Ok(Moments { inner }),
            false => Err(refuse("more than 2^32 - 1 samples do not fit into one sum")),
        }
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.inner == other.inner
    }

    fn __reduce__(slf: &Bound<'_, Self>) -> PyResult<(Py<PyAny>, (Vec<String>,))> {
        let make = slf.get_type().getattr("from_sums")?.unbind();
        Ok((make, (slf.get().sums(),)))
    }

    /// Offset, matrix, field, their standard errors and the noise, of the sums alone, as JSON.
    #[pyo3(signature = (ut_per_count, field_ut=None, method="adjusted"))]
    fn fit_json(&self, ut_per_count: [f64; 3], field_ut: Option<f64>, method: &str) -> PyResult<String> {
        let method = Method::parse(method).ok_or_else(|| {
            refuse(format!("method {method:?}: expected \"adjusted\", \"trace\" or \"constant\""))
        })?;
        let options = FitOptions { method, field_ut, ..FitOptions::default() };
        let report = Scatter::from_moments(&self.inner, ut_per_count)
            .and_then(|scatter| ironout::fit::fit(&scatter, &options))
            .map_err(|error| refuse(error.to_string()))?;
        Ok(serde_json::json!({
            "offset_ut": report.calibration.offset_ut, "matrix": report.calibration.matrix,
            "field_ut": report.calibration.field_ut, "samples_used": self.inner.count(), "rms_ut": report.rms_ut,
            "noise_ut": report.noise_ut, "method": method.name(),
            "std_errors": {"offset_ut": report.std_errors.offset_ut, "matrix": report.std_errors.matrix},
        })
        .to_string())
    }
}
