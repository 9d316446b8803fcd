//! `ironout fetch`: a board's calibration as a file.

use crate::atomic;
use crate::board::{Address, Console, cal_file, dump};
use crate::failure::{EXIT_OK, Failure, Outcome};
use crate::link_args::FetchArgs;
use crate::output::line;

/// Fetches and writes.
pub fn run(arguments: &FetchArgs, json: bool) -> Outcome<u8> {
    let address = Address::of(&arguments.link);
    let (mut console, board) = Console::open(&address, arguments.link.wait()?)?;
    console.ok("stream off").map_err(|trouble| trouble.at(&address))?;
    let dumped = dump(&mut console).map_err(|trouble| trouble.at(&address))?;
    let cal = cal_file(&dumped.record, dumped.covariance.as_ref(), &board)?;
    let text = serde_json::to_string_pretty(&cal).map_err(|error| Failure::usage(error.to_string()))?;
    atomic::write(&arguments.output, |out| writeln!(out, "{text}"))?;
    let effects: Vec<&str> = cal.fit.effects.iter().map(|entry| entry.id.as_str()).collect();
    let mut notes = Vec::new();
    if !dumped.stored {
        notes.push("it is not yet accepted on the board (cal accept), and is not in use there");
    }
    if cal.information.is_none() {
        notes.push(
            "the board has no covariance for it (information is null): effects were added or removed after the calibration, \
             or need its memory. fit --prior needs a log",
        );
    }
    if json {
        line(
            &serde_json::json!({
                "output": arguments.output.display().to_string(), "board": board.board, "sensor": board.sensor,
                "firmware": board.firmware, "sequence": dumped.record.sequence, "stored": dumped.stored,
                "effects": effects, "information": cal.information.is_some(), "notes": notes,
            })
            .to_string(),
        );
        return Ok(EXIT_OK);
    }
    let with = if effects.is_empty() { "no effects".into() } else { effects.join(", ") };
    line(&format!("{} ({}), firmware {}", board.board, board.sensor, board.firmware));
    line(&format!(
        "wrote {}: field {:.3} µT, {} samples, {with}",
        arguments.output.display(),
        dumped.record.calibration.field_ut,
        dumped.record.samples
    ));
    notes.iter().for_each(|note| line(&format!("note: {note}")));
    Ok(EXIT_OK)
}
