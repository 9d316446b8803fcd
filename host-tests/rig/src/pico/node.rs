//! The emulator's process: requests and answers as lines of JSON, in lockstep.

use super::error::Error;
use super::program::{FOLDER, NODE, missing};
use serde_json::Value;
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

/// The process; it ends with this value.
pub struct Node {
    child: Child,
    requests: ChildStdin,
    answers: BufReader<ChildStdout>,
}

impl Node {
    /// Starts it with the image in the flash.
    pub fn start(image: &Path) -> Result<Self, Error> {
        if let Some(missing) = missing() {
            return Err(Error::NotInstalled(missing));
        }
        let image = image.canonicalize().map_err(Error::io(format!("find the image {}", image.display())))?;
        let mut child = Command::new(NODE)
            .arg(Path::new(FOLDER).join("main.js"))
            .arg(image)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .map_err(Error::io("start node"))?;
        match (child.stdin.take(), child.stdout.take()) {
            (Some(requests), Some(answers)) => Ok(Self { child, requests, answers: BufReader::new(answers) }),
            _ => Err(Error::Ended),
        }
    }

    /// Sends a request. Questions that come before its answer are answered by `reply`.
    pub fn ask(&mut self, request: &Value, mut reply: impl FnMut(&Value) -> Value) -> Result<Value, Error> {
        self.send(request)?;
        loop {
            let mut line = String::new();
            let length =
                self.answers.read_line(&mut line).map_err(Error::io("read the emulator's answer"))?;
            let message = serde_json::from_str::<Value>(&line);
            let (Ok(mut message), true) = (message, length > 0) else { return Err(Error::Ended) };
            if message.get("i2c").is_some() {
                self.send(&reply(&message))?;
            } else if let Some(reason) = message["error"].as_str() {
                return Err(Error::Refused { request: request["do"].to_string(), reason: reason.to_owned() });
            } else {
                return Ok(message["ok"].take());
            }
        }
    }

    fn send(&mut self, message: &Value) -> Result<(), Error> {
        writeln!(self.requests, "{message}").map_err(|_| Error::Ended)
    }
}

impl Drop for Node {
    fn drop(&mut self) {
        // It may have ended already; then there is nothing left to do.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
