//! `ironout send`: a calibration onto a board.

use crate::board::{Address, Carried, Console, Identity, Trouble, carried, dump, load};
use crate::cal_file::CalFile;
use crate::failure::{EXIT_OK, Failure, Outcome};
use crate::link_args::SendArgs;
use crate::output::line;
use crate::progress::Progress;
use ironout::record::Record;

/// A line that noise has spoilt is worth another try; more of them are a bad cable.
const ATTEMPTS: usize = 3;

/// Sends, stores, and compares what the board has then.
pub fn run(arguments: &SendArgs, json: bool) -> Outcome<u8> {
    let cal = CalFile::read(&arguments.cal)?;
    let address = Address::of(&arguments.link);
    let (mut console, board) = Console::open(&address, arguments.link.wait()?)?;
    let Carried { record, mut notices } =
        carried(&cal, &board).map_err(|failure| failure.in_file(&arguments.cal))?;
    notices.extend(cal.fit.holds_for.as_ref().map(|holds_for| {
        format!("{}. The board warns if it is tilted further and has an accelerometer", holds_for.limit())
    }));
    let failed = |trouble: Trouble| trouble.at(&address);
    // Nobody reads a stream meanwhile.
    console.ok("stream off").map_err(failed)?;
    let encoded = record.encode().map_err(|error| Failure::usage(error.to_string()))?;
    transfer(&mut console, encoded.as_bytes(), !json).map_err(failed)?;
    let stored = console.ok("cal accept").map_err(failed)?;
    let back = dump(&mut console).map_err(failed)?;
    // The board gives a number, and says how its sensor is mounted.
    let same = Record { sequence: record.sequence, axes: record.axes, ..back.record };
    let same = same.encode().map_err(|error| Failure::usage(error.to_string()))?;
    if same.as_bytes() != encoded.as_bytes() {
        return Err(Failure::refused(format!(
            "{address}: the board's stored record differs from the one sent. Send it again, and check its memory"
        )));
    }
    say(
        arguments,
        &board,
        &record,
        encoded.as_bytes().len(),
        &notices,
        stored.value("slot"),
        back.record.sequence,
        json,
    );
    Ok(EXIT_OK)
}

/// The lines, again from the first where one was spoilt on its way.
fn transfer(console: &mut Console, bytes: &[u8], bar: bool) -> Result<(), Trouble> {
    let mut attempt = 1;
    loop {
        let mut progress = Progress::new("sending", bytes.len() as u64, bar);
        let done = load(console, bytes, |line, of| progress.at((line * bytes.len() / of.max(1)) as u64));
        match done {
            Ok(_) => return Ok(()),
            Err(Trouble::Refused { answer, .. }) if attempt < ATTEMPTS && is_spoilt(&answer) => attempt += 1,
            Err(trouble) => return Err(trouble),
        }
    }
}

/// Whether an answer is one to a line that did not arrive as it was sent.
fn is_spoilt(answer: &str) -> bool {
    ["refused crc", "usage", "unknown", "long", "state byte", "state no calibration"]
        .iter()
        .any(|start| answer.starts_with(start))
}

#[allow(clippy::too_many_arguments, reason = "everything that is printed")]
fn say(
    arguments: &SendArgs,
    board: &Identity,
    record: &Record,
    bytes: usize,
    notices: &[String],
    slot: Option<&str>,
    sequence: u32,
    json: bool,
) {
    let effects: Vec<String> =
        record.effects.iter().map(|fitted| ironout::effect::Id(&fitted.effect).to_string()).collect();
    if json {
        line(
            &serde_json::json!({
                "cal": arguments.cal.display().to_string(), "board": board.board, "sensor": board.sensor,
                "firmware": board.firmware, "bytes": bytes, "effects": effects,
                "slot": slot.and_then(|slot| slot.parse::<u8>().ok()), "sequence": sequence, "notes": notices,
            })
            .to_string(),
        );
        return;
    }
    let with = if effects.is_empty() { "no effects".into() } else { effects.join(", ") };
    line(&format!("{} ({}), firmware {}", board.board, board.sensor, board.firmware));
    line(&format!("sent {} bytes: field {:.3} µT, {with}", bytes, record.calibration.field_ut));
    line(&format!("stored as record {sequence} in slot {}, read back the same, in use", slot.unwrap_or("-")));
    notices.iter().for_each(|notice| line(&format!("note: {notice}")));
}
