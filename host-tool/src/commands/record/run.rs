//! The command: what is recorded, and what is said about it.

use super::follow::{End, Follower, Plan};
use super::rows::{Rows, Tally};
use super::spool::Spool;
use crate::board::{Address, Console};
use crate::failure::{EXIT_OK, Failure, Outcome};
use crate::interrupt::Interrupt;
use crate::link_args::RecordArgs;
use crate::output::line;
use crate::progress::Counting;

/// Records until there is enough, or Ctrl-C.
pub fn run(arguments: &RecordArgs, json: bool) -> Outcome<u8> {
    let (seconds, patience) = arguments.times()?;
    let wait = arguments.link.wait()?;
    let address = Address::of(&arguments.link);
    let interrupt = Interrupt::noted()?;
    let mut spool = Spool::beside(&arguments.output)?;
    let (console, identity) = Console::open(&address, wait)?;
    let Some(ut_per_count) = identity.ut_per_count else {
        return Err(Failure::usage(format!(
            "{address}: the firmware {} does not state the scale of its counts. Fix: update it",
            identity.firmware
        )));
    };
    let mut rows = Rows::new(ut_per_count);
    let mut follower = Follower {
        address: &address,
        identity: &identity,
        plan: Plan { seconds, patience, wait },
        interrupt,
        progress: Counting::new("recording"),
        reconnects: 0,
    };
    let end = follower.follow(console, &mut rows, spool.out());
    let reconnects = follower.reconnects;
    drop(follower);
    let tally = rows.tally();
    if tally.samples == 0 {
        // An error of the board says more than that nothing came.
        return Err(match end {
            Err(failure) | Ok(End::Gone(failure)) => failure,
            Ok(End::Asked) => Failure::refused(format!("{address}: no samples arrived, so there is no log")),
        });
    }
    let [x, y, z] = ut_per_count;
    let comments = [
        format!("recorded from {} ({}), firmware {}", identity.board, identity.sensor, identity.firmware),
        format!("ut_per_count={x},{y},{z}"),
        format!(
            "samples={} lost={} out_of_range={} restarts={} reconnections={reconnects}",
            tally.samples, tally.lost, tally.out_of_range, tally.restarts
        ),
    ];
    // Whatever ended it, what came is kept.
    spool.finish(&comments, rows.names())?;
    if json {
        line(&object(arguments, &tally, reconnects, &rows).to_string());
    } else {
        say(arguments, &tally, reconnects, &rows);
    }
    match end {
        Ok(End::Asked) => Ok(EXIT_OK),
        Ok(End::Gone(failure)) | Err(failure) => {
            let kept = arguments.output.display();
            if json {
                // The object is the one answer on standard output.
                eprintln!("error: {failure}; {kept} contains the samples recorded before that");
                return Ok(failure.exit);
            }
            Err(Failure {
                message: format!("{}; {kept} contains the samples recorded before that", failure.message),
                ..failure
            })
        }
    }
}

fn object(arguments: &RecordArgs, tally: &Tally, reconnects: u32, rows: &Rows) -> serde_json::Value {
    serde_json::json!({
        "output": arguments.output.display().to_string(), "samples": tally.samples, "lost": tally.lost,
        "out_of_range": tally.out_of_range, "restarts": tally.restarts, "reconnections": reconnects,
        "seconds": tally.length_ms as f64 / 1000.0, "columns": rows.names(),
    })
}

fn say(arguments: &RecordArgs, tally: &Tally, reconnects: u32, rows: &Rows) {
    let seconds = tally.length_ms as f64 / 1000.0;
    line(&format!(
        "wrote {}: {} samples in {seconds:.1} s of the board's clock",
        arguments.output.display(),
        tally.samples
    ));
    let names = if rows.names().is_empty() { "none".to_string() } else { rows.names().join(", ") };
    line(&format!("other columns: {names}"));
    for (count, what) in [
        (tally.lost, "samples were lost; the log marks where"),
        (tally.out_of_range, "samples were out of the sensor's range and were skipped"),
        (u64::from(tally.restarts), "times the board restarted; its clock was continued"),
        (u64::from(reconnects), "times the board was disconnected and came back"),
    ] {
        if count > 0 {
            line(&format!("{count} {what}"));
        }
    }
}
