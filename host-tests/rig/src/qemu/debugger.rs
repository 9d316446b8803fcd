//! A debugger of the smallest kind, to provoke faults that a sound firmware has no way to run into.

use super::error::Error;
use std::io::{Read, Write};
use std::os::unix::net::UnixStream;
use std::time::Duration;

/// The number of the stack pointer among the registers.
const SP: u8 = 13;
/// The number of the program counter among the registers.
const PC: u8 = 15;

/// A client of QEMU's debugger stub (GDB's remote protocol). The machine stands still while it is attached.
pub struct Debugger {
    socket: UnixStream,
}

impl Debugger {
    /// Attaches, which stops the machine.
    pub(super) fn new(socket: UnixStream) -> Result<Self, Error> {
        socket
            .set_read_timeout(Some(Duration::from_secs(15)))
            .map_err(Error::io("set the debugger's time limit"))?;
        let mut debugger = Self { socket };
        debugger.ask("?", "the reason it stands still")?;
        // The stub takes single registers only from a client that has asked for their description.
        debugger.ask("qXfer:features:read:target.xml:0,ffb", "the registers' description")?;
        Ok(debugger)
    }

    /// Sends the processor to `address`.
    pub fn set_pc(&mut self, address: u32) -> Result<(), Error> {
        self.set(PC, address)
    }

    /// Moves the stack.
    pub fn set_sp(&mut self, address: u32) -> Result<(), Error> {
        self.set(SP, address)
    }

    /// Detaches, and lets the machine run.
    pub fn detach(mut self) -> Result<(), Error> {
        self.ask("D", "OK").map(drop)
    }

    fn set(&mut self, register: u8, value: u32) -> Result<(), Error> {
        let bytes: String = value.to_le_bytes().iter().map(|byte| format!("{byte:02x}")).collect();
        match self.ask(&format!("P{register:x}={bytes}"), "OK")?.as_str() {
            "OK" => Ok(()),
            other => Err(Error::Protocol { line: other.to_owned(), expected: "`OK` to setting a register" }),
        }
    }

    /// Sends a packet and returns the answer.
    fn ask(&mut self, packet: &str, expected: &str) -> Result<String, Error> {
        let sum = packet.bytes().fold(0u8, u8::wrapping_add);
        self.socket
            .write_all(format!("${packet}#{sum:02x}").as_bytes())
            .map_err(Error::io("write to the debugger stub"))?;
        loop {
            let answer = self.answer(expected)?;
            // That the machine stopped is told a second time, at any moment after attaching.
            if packet == "?" || !answer.starts_with(['T', 'S']) {
                return Ok(answer);
            }
        }
    }

    /// Reads a packet: `$…#` and two digits of checksum.
    fn answer(&mut self, expected: &str) -> Result<String, Error> {
        let mut received = Vec::new();
        loop {
            let mut byte = [0];
            self.socket
                .read_exact(&mut byte)
                .map_err(Error::io(format!("read {expected} from the debugger stub")))?;
            received.push(byte[0]);
            let Some((body, sum)) = received
                .iter()
                .position(|&byte| byte == b'$')
                .and_then(|start| std::str::from_utf8(&received[start + 1..]).ok())
                .and_then(|text| text.split_once('#'))
            else {
                continue;
            };
            if sum.len() == 2 {
                let body = body.to_owned();
                self.socket.write_all(b"+").map_err(Error::io("write to the debugger stub"))?;
                return Ok(body);
            }
        }
    }
}
