//! `ironout import`: a log of another program as the program's own CSV.

use crate::cli::ImportArgs;
use crate::failure::{EXIT_OK, Failure, Outcome};
use crate::output::line;
use crate::{atomic, output, read_block, source, written};
use std::io::Write;

/// Reads the log and writes it.
pub fn run(arguments: &ImportArgs, json: bool) -> Outcome<u8> {
    let to_stdout = arguments.output.as_os_str() == "-";
    if to_stdout && json {
        return Err(Failure::usage("-o - and --json both write to standard output. Name a file for the log"));
    }
    if !to_stdout {
        atomic::not_over(&arguments.log.log, &arguments.output)?;
    }
    let log = source::read_raw(&arguments.log, json)?;
    // Counts without a scale stay counts; with one, or in a known unit, they are microtesla.
    let counts = log.ut_per_count.is_some() && arguments.log.ut_per_count.is_none();
    let comment = written::comment(&log, &arguments.log);
    if to_stdout {
        let mut out = std::io::BufWriter::new(std::io::stdout().lock());
        output::note(written::log(&mut out, &log, &comment, counts).and_then(|()| out.flush()));
        return Ok(EXIT_OK);
    }
    atomic::write(&arguments.output, |out| written::log(out, &log, &comment, counts))?;
    if json {
        line(
            &serde_json::json!({
                "log": log.path.display().to_string(), "rows": log.rows, "output": arguments.output.display().to_string(),
                "counts": counts, "read_as": read_block::json(&log),
            })
            .to_string(),
        );
    } else {
        line(&format!("wrote {}: {} rows", arguments.output.display(), log.rows));
        if counts {
            line("the magnetometer is in counts. Give its scale with --ut-per-count when you fit the log");
        }
    }
    Ok(EXIT_OK)
}
