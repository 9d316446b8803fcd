//! The board itself, in QEMU: faults leave a trace and restart it, and it logs.
#![cfg(unix)]

use defmt_decoder::{DecodeError, Table};
use ironout_host_tests::qemu::{self, Emulator, Firmware, Options};

fn firmware() -> Firmware {
    Firmware::build().unwrap_or_else(|error| panic!("{error}"))
}

/// The firmware's log as text. A frame cut off by a reset is passed over.
fn log(firmware: &Firmware, board: &Emulator) -> Vec<String> {
    let table = Table::parse(&firmware.bytes().unwrap()).unwrap().expect("the ELF holds the log's texts");
    let mut decoder = table.new_stream_decoder();
    decoder.received(&board.log().unwrap());
    let mut lines = Vec::new();
    loop {
        match decoder.decode() {
            Ok(frame) => lines.push(frame.display_message().to_string()),
            Err(DecodeError::UnexpectedEof) => return lines,
            Err(DecodeError::Malformed) => {}
        }
    }
}

#[test]
fn try_it() {
    if !qemu::available("try_it") {
        return;
    }
    let firmware = firmware();
    println!("{:?}", firmware.footprint().unwrap());
    let mut board = Emulator::start(&firmware, &Options { debugger: true, ..Options::default() }).unwrap();
    println!("{:#?}", board.console.drain(std::time::Duration::from_millis(200)));
    let mut dbg = board.debugger().unwrap();
    dbg.set_pc(0x6000_0000).unwrap();
    dbg.detach().unwrap();
    println!("{:#?}", board.console.drain(std::time::Duration::from_millis(200)));
    let mut dbg = board.debugger().unwrap();
    dbg.set_pc(firmware.symbol("DefaultHandler").unwrap() as u32 & !1).unwrap();
    dbg.detach().unwrap();
    println!("{:#?}", board.console.drain(std::time::Duration::from_millis(200)));
    let mut dbg = board.debugger().unwrap();
    dbg.set_sp(0x2000_0008).unwrap();
    dbg.detach().unwrap();
    println!("{:#?}", board.console.drain(std::time::Duration::from_millis(200)));
    for l in log(&firmware, &board) {
        println!("{l}");
    }
}
