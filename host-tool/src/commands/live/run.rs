//! Which board, and where its page is.

use crate::board::Address;
use crate::cli::LiveArgs;
use crate::commands::live::link::Link;
use crate::commands::live::server::Serving;
use crate::failure::{EXIT_OK, Outcome};
use crate::interrupt::Interrupt;
use crate::output::line;
use ironout_web::{Mode, Page};

/// Serves the page until Ctrl-C.
pub fn run(arguments: &LiveArgs, json: bool) -> Outcome<u8> {
    let wait = arguments.wait()?;
    let interrupt = Interrupt::noted()?;
    let serial = arguments.port.clone().map(Address::Serial);
    // What goes with the board is put away at the end.
    let (link, _bench) = match serial.or_else(|| arguments.tcp.clone().map(Address::Tcp)) {
        Some(address) => (Link::keep(address.to_string(), wait, move || address.open(wait)), None),
        None => bench(arguments)?,
    };
    let serving = Serving::at(arguments.listen, Page::new(Mode::Live, "live").html(), link)?;
    if json {
        line(&serde_json::json!({ "address": serving.address() }).to_string());
    } else {
        line(&format!("open {} in a browser (Ctrl-C ends)", serving.address()));
    }
    // The address is asked for before anything else happens.
    crate::output::finish()?;
    serving.run(&interrupt)?;
    Ok(EXIT_OK)
}

/// What a board that is not real needs to be put away.
type Bench = Box<dyn std::any::Any>;

#[cfg(feature = "demo")]
fn bench(arguments: &LiveArgs) -> Outcome<(Link, Option<Bench>)> {
    use crate::commands::live::bench;
    match &arguments.replay {
        Some(log) => Ok((bench::replay(log, arguments.speed()?)?, None)),
        None => bench::emulated(arguments.wait()?, arguments.hidden).map(|(link, bench)| (link, Some(bench))),
    }
}

#[cfg(not(feature = "demo"))]
fn bench(_arguments: &LiveArgs) -> Outcome<(Link, Option<Bench>)> {
    Err(crate::failure::Failure::usage(
        "--qemu and --replay need the boards of the project's tests: run it as cargo ironout live, or build with --features demo",
    ))
}
