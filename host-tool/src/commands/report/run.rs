//! What is fitted, searched and written.

use crate::cli::{MethodArg, ReportArgs};
use crate::commands::report::plots::plots;
use crate::failure::{EXIT_OK, EXIT_REFUSED, Failure, Outcome};
use crate::input::Log;
use crate::page::{Held, LookAsked, ReadAsked, look, under};
use crate::plausible::Known;
use crate::progress::Working;
use crate::{atomic, output, source};
use ironout_web::{Mode, Page};
use serde_json::{Value, json};
use std::path::Path;

/// Fits, searches, and writes the page.
pub fn run(arguments: &ReportArgs, as_json: bool) -> Outcome<u8> {
    let expected = arguments.field.expected()?;
    if arguments.field.method != MethodArg::Adjusted {
        return Err(Failure::usage("--method: a page uses adjusted least squares only. Omit it"));
    }
    if let Some(path) = &arguments.output {
        output::leave_to(Some(path), as_json)?;
        arguments.log.logs().chain(&arguments.cal).try_for_each(|log| atomic::not_over(log, path))?;
    }
    let known = Known::given(expected.field_ut);
    let held = |log: Log| Held { log, asked: ReadAsked::of(&arguments.log) };
    let (log, _) = source::read_held(&arguments.log, None, &known, as_json)?;
    let held_log = held(log);
    let working = Working::new("studying");
    let asked = LookAsked {
        add: arguments.add.clone(),
        search: !arguments.no_search,
        field_ut: arguments.field.field,
        at: arguments.field.at.clone(),
        floor_ut: None,
    };
    let looked = look(&held_log, &asked)?;
    let mut beside = Vec::new();
    for path in &arguments.cal {
        let text = std::fs::read_to_string(path).map_err(|error| Failure::io("read", path, &error))?;
        beside.push(under(&held_log, &text, &path.display().to_string())?);
    }
    if let Some(path) = &arguments.compare {
        let other = source::read_held(&arguments.log.alone(path), None, &known, as_json)?.0;
        beside.push(fitted_beside(&Held { log: other, ..held_log.clone() }, path, &asked)?);
    }
    drop(working);
    let accepted = looked.pointer("/fit/accepted") == Some(&Value::Bool(true));
    let (packed, rounded) = held_log.pack();
    let mut said = held_log.json();
    if !rounded.is_empty() {
        let words = format!(
            "this page stores {} in single precision: a new fit may differ in the sixth digit",
            rounded.join(", ")
        );
        if let Some(notices) = said.get_mut("notices").and_then(Value::as_array_mut) {
            notices.push(words.into());
        }
    }
    let mut written = Vec::new();
    if let Some(path) = &arguments.output {
        let name = held_log.log.path.display().to_string();
        let html = Page::new(Mode::Report, &name)
            .with("report", &json!({"log": said, "look": looked, "beside": beside}))
            .with_bytes("log", &packed)
            .html();
        atomic::write(path, |out| out.write_all(html.as_bytes()))?;
        if !output::is_standard(path) {
            written.push((path.display().to_string(), html.len()));
        }
    }
    if let Some(folder) = &arguments.plots {
        std::fs::create_dir_all(folder).map_err(|error| Failure::io("make the folder", folder, &error))?;
        for (name, svg) in plots(&looked) {
            let path = folder.join(name);
            atomic::write(&path, |out| out.write_all(svg.as_bytes()))?;
            written.push((path.display().to_string(), svg.len()));
        }
    }
    if as_json {
        let files: Vec<Value> =
            written.iter().map(|(path, bytes)| json!({"output": path, "bytes": bytes})).collect();
        output::line(&json!({"written": files, "accepted": accepted, "fit": looked["fit"]}).to_string());
    } else {
        let verdict = |key: &str| looked["verdict"][key].as_str().unwrap_or_default();
        output::line(&format!("{}: {}", verdict("name"), verdict("sentence")));
        output::line(verdict("calibration"));
        for (path, bytes) in &written {
            output::line(&format!("wrote {path} ({})", size(*bytes)));
        }
    }
    Ok(if accepted { EXIT_OK } else { EXIT_REFUSED })
}

fn size(bytes: usize) -> String {
    if bytes < 1_000_000 {
        format!("{:.0} KB", bytes as f64 / 1e3)
    } else {
        format!("{:.1} MB", bytes as f64 / 1e6)
    }
}

/// Another log, fitted by itself, as the page compares it.
fn fitted_beside(held: &Held, path: &Path, asked: &LookAsked) -> Outcome<Value> {
    let mut looked = look(held, &LookAsked { search: false, ..asked.clone() })?;
    let field_ut = looked.pointer("/fit/field_ut").and_then(Value::as_f64);
    let rms_ut = looked.pointer("/fit/rms_ut").and_then(Value::as_f64);
    Ok(json!({
        "name": path.display().to_string(), "fit": looked["fit"].take(), "picture": looked["picture"].take(),
        "rms_ut": rms_ut, "percent": rms_ut.zip(field_ut).map(|(rms, field)| 100.0 * rms / field),
    }))
}
