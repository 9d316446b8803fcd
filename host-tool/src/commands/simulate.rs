//! `ironout simulate`: a log whose truth is known.

use crate::cli::{SimulateArgs, quoted};
use crate::failure::Outcome;
use crate::simulated::{simulated, truth_json};
use crate::{atomic, output};

/// Writes the log and says what is in it.
pub fn run(arguments: &SimulateArgs, json: bool) -> Outcome<u8> {
    output::leave_to(Some(&arguments.output), json)?;
    let (log, truth) = simulated(arguments)?;
    atomic::write(&arguments.output, |out| log.write_csv(out, &truth))?;
    if json {
        output::line(
            &serde_json::json!({
                "log": arguments.output.display().to_string(), "rows": log.rows(), "columns": log.names,
                "truth": truth_json(arguments, &log),
            })
            .to_string(),
        );
    } else {
        output::line(&format!(
            "{}: {} rows, columns {}",
            if output::is_standard(&arguments.output) {
                "standard output".into()
            } else {
                arguments.output.display().to_string()
            },
            log.rows(),
            log.names.join(", ")
        ));
        output::line("the truth, also in the log as # comments:");
        truth.lines().skip(1).for_each(|line| output::line(&format!("  {line}")));
        if !output::is_standard(&arguments.output) {
            output::line(&format!("next: ironout fit {}", quoted(&arguments.output.display().to_string())));
        }
    }
    Ok(0)
}
