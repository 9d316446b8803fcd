//! `ironout apply`: correct a log, and show the error before and after.

use crate::cal_file::CalFile;
use crate::cli::ApplyArgs;
use crate::corrected::Corrected;
use crate::failure::{EXIT_OK, EXIT_REFUSED, Failure, Outcome};
use crate::field_unit::{fixed, symbol};
use crate::input::{Lines, Log};
use crate::output::{json_number, line};
use crate::{atomic, output, progress::Progress, read_block, source, written};
use ironout::calibration::norm;
use ironout_analysis::Table;
use ironout_analysis::effects::Calibrated;
use ironout_analysis::fit::confined::beyond;
use ironout_analysis::fit::fitted::spread_of_magnitude;
use std::path::Path;

/// What the corrected log gains.
const NEW_COLUMNS: [&str; 5] = ["cx_ut", "cy_ut", "cz_ut", "norm_ut", "residual_ut"];

/// Applies the calibration to each log, prints the errors, writes the corrected log if asked.
pub fn run(arguments: &ApplyArgs, json: bool) -> Outcome<u8> {
    output::leave_to(arguments.output.as_deref(), json)?;
    let cal = CalFile::read(&arguments.cal)?;
    if let Some(output) = &arguments.output {
        if !arguments.log.more.is_empty() {
            return Err(Failure::usage(
                "-o writes one corrected log, but several logs are given. Apply them one by one",
            ));
        }
        atomic::not_over(&arguments.cal, output)?;
    }
    let calibration = cal.extended().map_err(|failure| failure.in_file(&arguments.cal))?;
    let (mut objects, mut worse) = (Vec::new(), false);
    for (place, log) in source::read_each_for(&arguments.log, &cal, &arguments.cal, json)?.iter().enumerate()
    {
        if place > 0 && !json {
            line("");
        }
        let object = one(arguments, &cal, calibration, log, json)?;
        worse |= object["worse"] == true;
        objects.push(object);
    }
    if json {
        let all = |objects: Vec<serde_json::Value>| serde_json::json!({ "logs": objects });
        // One log is the object, as ever.
        let object = if objects.len() == 1 { objects.pop() } else { None };
        line(&object.unwrap_or_else(|| all(objects)).to_string());
    }
    Ok(if worse { EXIT_REFUSED } else { EXIT_OK })
}

/// One log: the object of `--json`; without it the words are printed.
fn one(
    arguments: &ApplyArgs,
    cal: &CalFile,
    calibration: Calibrated,
    log: &Log,
    json: bool,
) -> Outcome<serde_json::Value> {
    let table = Table::from(log);
    let corrector = Corrected::new(calibration, cal.fitted_to.as_deref(), log, &table)?;
    let fields = corrector.fields(&cal.fit.effects)?;
    if let Some(output) = &arguments.output {
        // The program's own file keeps its lines and comments; another program's is written again.
        if log.read_as.own_csv && log.path != Path::new("-") {
            write(log, &corrector, &fields, output)?;
        } else {
            write_anew(arguments, log, &corrector, &fields, output)?;
        }
    }
    let samples = log.samples();
    let (mean, before) = spread_of_magnitude(samples.iter().map(|&row| norm(log.field(row))));
    let residuals: Vec<f64> = samples.iter().map(|&row| corrector.residual_ut(row, fields[row])).collect();
    let after = (residuals.iter().map(|r| r * r).sum::<f64>() / samples.len() as f64).sqrt();
    let worst = residuals.iter().map(|r| r.abs()).fold(0.0, f64::max);
    let field = calibration.base.field_ut;
    let (before_share, after_share) = (before / mean, after / field);
    let worse = after_share > before_share;
    let extrapolation = corrector.extrapolation(&cal.fit.effects);
    let tilted = cal.fit.holds_for.as_ref().and_then(|holds_for| beyond(holds_for, &table));
    let object = serde_json::json!({
        "log": log.path.display().to_string(), "samples": samples.len(), "field_ut": field,
        "effects": cal.fit.effects.iter().map(|effect| &effect.id).collect::<Vec<_>>(),
        "before": {"mean_ut": json_number(Some(mean)), "rms_ut": json_number(Some(before)),
                   "rms_percent": json_number(Some(before_share * 100.0))},
        "after": {"rms_ut": json_number(Some(after)), "rms_percent": json_number(Some(after_share * 100.0)),
                  "worst_ut": json_number(Some(worst))},
        "worse": worse,
        "tilted": tilted, "outside": extrapolation.outside, "range_unknown": extrapolation.unknown,
        "read_as": read_block::json(log),
        "output": arguments.output.as_ref().map(|path| path.display().to_string()),
    });
    if json {
        return Ok(object);
    }
    let unit = symbol();
    let ut = |value: f64, decimals: usize| fixed(Some(value), decimals);
    line(&format!("{}: {} samples, corrected to {} {unit}", log.path.display(), samples.len(), ut(field, 3)));
    if !cal.fit.effects.is_empty() {
        let names: Vec<&str> = cal.fit.effects.iter().map(|effect| effect.id.as_str()).collect();
        line(&format!("with the effects {}", names.join(", ")));
    }
    line(&format!(
        "error before  {:>9} {unit}  {:6.2} %   measured magnitude, about its mean of {} {unit}",
        ut(before, 3),
        before_share * 100.0,
        ut(mean, 1)
    ));
    line(&format!(
        "error after   {:>9} {unit}  {:6.2} %   of the corrected magnitude about {} {unit}; worst {} {unit}",
        ut(after, 3),
        after_share * 100.0,
        ut(field, 1),
        ut(worst, 2)
    ));
    if worse {
        line(&format!(
            "WORSE: this calibration increases the error of this log. It probably belongs to another sensor or another \
             mounting. To check, run: ironout check {} --cal {}",
            log.path.display(),
            arguments.cal.display()
        ));
    }
    extrapolation
        .notices(field)
        .iter()
        .chain(&tilted)
        .for_each(|notice| line(&format!("outside the range: {notice}")));
    if let Some(path) = arguments.output.as_ref().filter(|path| !output::is_standard(path)) {
        line(&format!("wrote {} with {} added", path.display(), NEW_COLUMNS.join(", ")));
    }
    Ok(object)
}

/// Writes the log as the program's own CSV with the corrected columns.
fn write_anew(
    arguments: &ApplyArgs,
    log: &Log,
    corrector: &Corrected,
    fields: &[[f64; 3]],
    output: &Path,
) -> Outcome<()> {
    atomic::not_over(&log.path, output)?;
    let columns = written::columns(log, false);
    if let Some(name) = NEW_COLUMNS.iter().find(|name| columns.iter().any(|(known, _)| known == *name)) {
        return Err(Failure::usage(
            "the log already has this column, so it is already corrected. Use the original log",
        )
        .in_file(&log.path)
        .at_column(*name));
    }
    atomic::write(output, |out| {
        for line in written::comment(log, &arguments.log).lines() {
            writeln!(out, "# {line}")?;
        }
        let names: Vec<String> = columns.iter().map(|(name, _)| written::cell(name)).collect();
        writeln!(out, "{},{}", names.join(","), NEW_COLUMNS.join(","))?;
        for (row, &corrected) in fields.iter().enumerate() {
            written::line(out, &columns, row)?;
            let [x, y, z] = corrected;
            let residual = corrector.residual_ut(row, corrected);
            writeln!(out, ",{x:.5},{y:.5},{z:.5},{:.5},{residual:.5}", norm(corrected))?;
        }
        Ok(())
    })
}

/// Copies the log line by line, comments too, and adds the corrected columns to each.
fn write(log: &Log, corrector: &Corrected, fields: &[[f64; 3]], output: &Path) -> Outcome<()> {
    atomic::not_over(&log.path, output)?;
    let file = std::fs::File::open(&log.path).map_err(|error| Failure::io("open", &log.path, &error))?;
    let mut lines = Lines::new(file);
    let total = std::fs::metadata(&log.path).map_or(0, |metadata| metadata.len());
    let mut progress = Progress::new("writing", total, true);
    let mut trouble = None;
    let written = atomic::write(output, |out| {
        let (mut row, mut done) = (None, 0);
        while let Some(line) = lines.next_line().map_err(std::io::Error::other)? {
            let text = line.text;
            done += text.len() as u64 + 1;
            out.write_all(text)?;
            // The first line that is not a comment is the header.
            if !line.is_row() {
                writeln!(out)?;
                continue;
            }
            match row {
                None => {
                    let header = String::from_utf8_lossy(text);
                    trouble =
                        NEW_COLUMNS.iter().find(|name| header.split(',').any(|cell| cell.trim() == **name));
                    writeln!(out, ",{}", NEW_COLUMNS.join(","))?;
                    row = Some(0);
                }
                Some(at) => {
                    let Some(&corrected) = fields.get(at) else {
                        return Err(std::io::Error::other(
                            "the log grew during reading. Stop the recording first",
                        ));
                    };
                    let [x, y, z] = corrected;
                    writeln!(
                        out,
                        ",{x:.5},{y:.5},{z:.5},{:.5},{:.5}",
                        norm(corrected),
                        corrector.residual_ut(at, corrected)
                    )?;
                    row = Some(at + 1);
                    progress.at(done);
                }
            }
            if trouble.is_some() {
                return Err(std::io::Error::other("column twice"));
            }
        }
        Ok(())
    });
    match trouble {
        Some(name) => Err(Failure::usage(
            "the log already has this column, so it is already corrected. Use the original log",
        )
        .in_file(&log.path)
        .at_column(*name)),
        None => written,
    }
}
