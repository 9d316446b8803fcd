//! `ironout effects`: what can be tested on a log.

use crate::cli::Form;
use crate::cli_help::EffectsArgs;
use crate::failure::{EXIT_OK, Outcome};
use crate::plausible::Known;
use crate::registry::REGISTRY;
use crate::wrap::{WIDTH, hang};
use crate::{output, source};
use ironout_analysis::{Allowed, Options, Table, allowed};
use serde_json::json;

/// Lists the effects that the columns of a log allow, and what is missing for the others.
pub fn run(arguments: &EffectsArgs, form: Form) -> Outcome<u8> {
    let (log, _) = source::read_held(&arguments.log, None, &Known::Earth, form)?;
    let list = allowed(&Table::from(&log), &Options { registry: REGISTRY, ..Options::default() });
    match form {
        Form::Json => output::line(&object(&list).to_string()),
        Form::Line => output::line(&ids(&list).join(" ")),
        Form::Brief | Form::Full => output::text(&text(&list, &arguments.log.typed())),
    }
    Ok(EXIT_OK)
}

fn ids(list: &Allowed) -> Vec<&str> {
    let of_columns = list.columns.iter().flat_map(|(_, ids)| ids);
    of_columns.chain(&list.others).map(String::as_str).collect()
}

fn object(list: &Allowed) -> serde_json::Value {
    json!({
        "columns": list.columns.iter().map(|(name, ids)| json!({"name": name, "effects": ids})).collect::<Vec<_>>(),
        "others": list.others,
        "untestable": list.untestable.iter().map(|one| json!({"id": one.id, "name": one.name, "why": one.why})).collect::<Vec<_>>(),
    })
}

fn text(list: &Allowed, log: &str) -> String {
    let mut out = vec![format!("{} effects can be tested on this log.", ids(list).len()), String::new()];
    let width = list.columns.iter().map(|(name, _)| name.chars().count()).max().unwrap_or(0).max(8);
    let blank = " ".repeat(width + 4);
    let mut row = |name: &str, ids: &[String]| {
        out.extend(hang(&ids.join(", "), &format!("  {name:<width$}  "), &blank, WIDTH));
    };
    list.columns.iter().for_each(|(name, ids)| row(name, ids));
    row("any log", &list.others);
    let mut groups: Vec<(&str, Vec<&str>)> = Vec::new();
    for one in &list.untestable {
        match groups.iter_mut().find(|(why, _)| *why == one.why) {
            Some((_, members)) => members.push(&one.id),
            None => groups.push((&one.why, vec![&one.id])),
        }
    }
    if !groups.is_empty() {
        out.extend([String::new(), "Not testable with this log".into()]);
        for (why, members) in groups {
            out.extend(hang(&format!("{}: {why}", members.join(", ")), "  ", "    ", WIDTH));
        }
    }
    out.extend([String::new(), "Next steps".into(), "  Test all of them:".into()]);
    out.push(format!("    ironout diagnose {log}"));
    if let Some(id) = list.columns.iter().find_map(|(_, ids)| ids.first()).or(list.others.first()) {
        out.push("  Fit one of them:".into());
        out.push(format!("    ironout fit {log} --add {id}"));
    }
    out.iter().map(|line| format!("{line}\n")).collect()
}
