//! The calls of the Python package `ironout` that are computed here. Results leave as the JSON text that the program prints with
//! `--json`, so that both have the same digits.

mod answer;
mod columns;
mod log;
mod options;
mod sums;
mod wait;

use pyo3::prelude::*;
use wait::IronoutError;

#[pymodule]
fn _ironout(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add("IronoutError", module.py().get_type::<IronoutError>())?;
    module.add_class::<log::Log>()?;
    module.add_class::<sums::Moments>()?;
    for function in [
        wrap_pyfunction!(log::read, module)?,
        wrap_pyfunction!(log::from_columns, module)?,
        wrap_pyfunction!(log::simulate, module)?,
        wrap_pyfunction!(answer::fit, module)?,
        wrap_pyfunction!(answer::diagnose, module)?,
        wrap_pyfunction!(answer::apply, module)?,
        wrap_pyfunction!(answer::check, module)?,
        wrap_pyfunction!(answer::check_file, module)?,
        wrap_pyfunction!(answer::export, module)?,
        wrap_pyfunction!(answer::parse, module)?,
        wrap_pyfunction!(answer::rotation, module)?,
    ] {
        module.add_function(function)?;
    }
    Ok(())
}
