//! Writes the calibration in the form asked for.

use crate::cal_file::CalFile;
use crate::cli::ExportArgs;
use crate::commands::export::log;
use crate::exported::{self, Exported};
use crate::failure::{EXIT_OK, Outcome};
use crate::output::json_number;
use crate::wrap::hang;
use crate::{atomic, output};
use ironout_analysis::export::refit::Cost;
use ironout_analysis::export::words::{costs, not_held};

/// Lines are at most this wide.
const WIDTH: usize = 110;

/// Writes the calibration in the form asked for.
pub fn run(arguments: &ExportArgs, json: bool) -> Outcome<u8> {
    let cal = CalFile::read(&arguments.cal)?;
    if cal.reading.is_none() {
        eprintln!(
            "note: {}: an earlier program wrote it, without scale and mounting of its log. ironout assumes none",
            arguments.cal.display()
        );
    }
    if let Some(holds_for) = &cal.fit.holds_for {
        eprintln!("note: {}: {}", arguments.cal.display(), holds_for.notice());
    }
    let exported = exported::asked(arguments).and_then(|()| {
        let log = log::read(arguments, &cal, true)?;
        exported::text(&cal, arguments, log.as_ref())
    });
    let exported = exported.map_err(|failure| match failure.file {
        Some(_) => failure,
        None => failure.in_file(&arguments.cal),
    })?;
    match arguments.output.as_ref().filter(|path| !output::is_standard(path)) {
        Some(path) => {
            atomic::not_over(&arguments.cal, path)?;
            atomic::write(path, |out| out.write_all(exported.text.as_bytes()))?;
            if !json {
                output::line(&format!("wrote {}", path.display()));
                told(&exported).iter().flat_map(|text| hang(text, "  ", "    ", WIDTH)).for_each(|line| {
                    output::line(&line);
                });
            }
        }
        None if !json => output::line(exported.text.trim_end()),
        None => {}
    }
    if json {
        output::line(&object(arguments, &exported).to_string());
    }
    Ok(EXIT_OK)
}

/// What people are told next to the file, which says the same at its top.
fn told(exported: &Exported) -> Vec<String> {
    let Some(held) = &exported.held else { return Vec::new() };
    let lost = not_held(held).into_iter().map(|text| format!("{} cannot represent: {text}", held.room.name));
    lost.chain(costs(held, exported.cost.as_ref())).collect()
}

fn object(arguments: &ExportArgs, exported: &Exported) -> serde_json::Value {
    let output = arguments.output.as_ref().map(|path| path.display().to_string());
    let mut object =
        serde_json::json!({ "as": arguments.form.name(), "output": output, "text": exported.text });
    if let (Some(held), Some(map)) = (&exported.held, object.as_object_mut()) {
        let cost = |cost: &Cost| {
            let heading = cost.heading.map(|heading| {
                serde_json::json!({
                    "between_deg": json_number(Some(heading.between_deg)),
                    "error_deg": heading.errors_deg.map(|errors| errors[0]),
                    "held_error_deg": heading.errors_deg.map(|errors| errors[1]),
                })
            });
            serde_json::json!({
                "samples": cost.samples, "rms_ut": json_number(Some(cost.whole_rms_ut)),
                "held_rms_ut": json_number(Some(cost.held_rms_ut)), "heading": heading,
            })
        };
        map.insert("not_held".into(), not_held(held).into());
        map.insert("lost_rotation_deg".into(), json_number(held.lost_deg));
        map.insert("fitted_anew".into(), held.refitted.into());
        map.insert("cost".into(), exported.cost.as_ref().map_or(serde_json::Value::Null, cost));
    }
    object
}
