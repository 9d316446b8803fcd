//! `ironout diagnose`: find the missing effect.

mod advice;
mod conclusion;
mod curve;
mod found;
mod next;
mod numbers;
mod place;
mod words;

use crate::cal_file::CalFile;
use crate::cli::DiagnoseArgs;
use crate::diagnose::engine::Earlier;
use crate::diagnose::outcome::Verdict;
use crate::diagnose::{Diagnosis, Options, Refusal, Table, diagnose, json};
use crate::failure::{EXIT_OK, EXIT_REFUSED, Failure, Outcome};
use crate::output;
use crate::progress::Working;
use std::path::Path;

/// Diagnoses a log; exit status 1 where the data do not support a calibration.
pub fn run(arguments: &DiagnoseArgs, as_json: bool) -> Outcome<u8> {
    let expected = arguments.field.expected()?;
    let earlier = arguments.prior.as_deref().map(earlier).transpose()?;
    let log = arguments.log.read()?;
    let options = Options { field_ut: expected.field_ut, add: arguments.add.clone(), search: true, earlier };
    let working = Working::new("studying");
    let diagnosis = diagnose(&Table::from(&log), &options).map_err(|refusal| failure(refusal, &log.path))?;
    drop(working);
    if as_json {
        output::line(&json::object(&diagnosis).to_string());
    } else {
        output::text(&words::text(&words::Told { log: &log, arguments, diagnosis: &diagnosis }));
    }
    Ok(status(&diagnosis))
}

fn status(diagnosis: &Diagnosis) -> u8 {
    if diagnosis.verdict == Verdict::Undetermined { EXIT_REFUSED } else { EXIT_OK }
}

/// The failure for a refusal.
pub fn failure(refusal: Refusal, log: &Path) -> Failure {
    match refusal {
        Refusal::BadShape(id) => {
            Failure::usage(format!("the shape of effect {id} is not finite")).in_file(log)
        }
        Refusal::CannotAdd(id, why) => Failure::usage(format!("--add {id}: {why}")),
    }
}

/// What an earlier calibration knows.
pub fn earlier(path: &Path) -> Outcome<Earlier> {
    let file = CalFile::read(path)?;
    let missing = |what: &str| {
        Failure::usage(format!("this calibration has no {what}: fit it again with this program"))
            .in_file(path)
    };
    let offset = file.fit.offset_ut.ok_or_else(|| missing("offset"))?;
    let matrix = file.fit.matrix.ok_or_else(|| missing("matrix"))?;
    let known = file.information.as_ref().ok_or_else(|| missing("information"))?;
    let triangle = triangular(&matrix).ok_or_else(|| missing("invertible matrix"))?;
    if known.matrix.len() < 9 || known.matrix.iter().take(9).any(|row| row.len() < 9) {
        return Err(missing("information about nine parameters"));
    }
    let [x, y, z] = offset;
    let c = triangle;
    Ok(Earlier {
        parameters: [x, y, z, c[0][0], c[0][1], c[0][2], c[1][1], c[1][2], c[2][2]],
        information: core::array::from_fn(|i| core::array::from_fn(|j| known.matrix[i][j])),
    })
}

/// The upper triangular matrix with the same `CᵀC`: an aligned matrix without its rotation.
fn triangular(matrix: &[[f64; 3]; 3]) -> Option<[[f64; 3]; 3]> {
    let c = nalgebra::Matrix3::from_fn(|i, j| matrix[i][j]);
    let upper = (c.transpose() * c).cholesky()?.l().transpose();
    Some(core::array::from_fn(|i| core::array::from_fn(|j| upper[(i, j)])))
}
