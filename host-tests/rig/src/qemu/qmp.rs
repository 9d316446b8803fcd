//! QEMU's machine protocol: one JSON object a line.

use super::error::Error;
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Write};
use std::os::unix::net::UnixStream;
use std::time::Duration;

/// How long QEMU may take to answer. It answers from its main loop, as soon as a busy machine lets it run.
const LIMIT: Duration = Duration::from_secs(300);

/// A client of the machine protocol.
pub struct Qmp {
    socket: BufReader<UnixStream>,
}

impl Qmp {
    /// Takes the greeting and enters command mode.
    pub fn new(socket: UnixStream) -> Result<Self, Error> {
        socket.set_read_timeout(Some(LIMIT)).map_err(Error::io("set QMP's time limit"))?;
        let mut qmp = Self { socket: BufReader::new(socket) };
        qmp.message()?;
        qmp.execute("qmp_capabilities", json!({}))?;
        Ok(qmp)
    }

    /// Runs a command and returns its result; events are passed over.
    pub fn execute(&mut self, command: &str, arguments: Value) -> Result<Value, Error> {
        let request = json!({ "execute": command, "arguments": arguments });
        self.socket
            .get_mut()
            .write_all(format!("{request}\n").as_bytes())
            .map_err(Error::io(format!("send `{command}` to QEMU")))?;
        loop {
            let mut message = self.message()?;
            if let Some(result) = message.get_mut("return") {
                return Ok(result.take());
            }
            if let Some(error) = message.get("error") {
                let reason = error.get("desc").and_then(Value::as_str).unwrap_or("no reason given");
                return Err(Error::Qmp { command: request.to_string(), reason: reason.to_owned() });
            }
        }
    }

    /// Sets a property of a device.
    pub fn set(&mut self, path: &str, property: &str, value: i64) -> Result<(), Error> {
        let arguments = json!({ "path": path, "property": property, "value": value });
        self.execute("qom-set", arguments).map(drop)
    }

    fn message(&mut self) -> Result<Value, Error> {
        let mut line = String::new();
        self.socket.read_line(&mut line).map_err(Error::io("read QEMU's answer"))?;
        serde_json::from_str(&line)
            .map_err(|_| Error::Protocol { line, expected: "a JSON object of QEMU's machine protocol" })
    }
}
