//! The wire to a board, and what can be wrong with it.

use crate::failure::{Failure, Outcome};
use crate::link_args::LinkArgs;
use std::fmt;
use std::io::{self, ErrorKind, Read, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::time::Duration;

/// The console's speed (8N1).
const BAUD: u32 = 115_200;

/// Where a board is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Address {
    /// A serial port, as the operating system names it.
    Serial(String),
    /// `HOST:PORT`, behind which something passes bytes on to a console.
    Tcp(String),
}

impl fmt::Display for Address {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Address::Serial(name) | Address::Tcp(name) => f.write_str(name),
        }
    }
}

/// Bytes to a board and back.
pub trait Wire: Send {
    /// Reads what has come, waiting for at most `limit`; 0 where nothing came.
    ///
    /// # Errors
    /// The wire is gone.
    fn read(&mut self, into: &mut [u8], limit: Duration) -> io::Result<usize>;

    /// Writes all of it, waiting for at most `limit`.
    ///
    /// # Errors
    /// The wire is gone, or takes nothing.
    fn write(&mut self, bytes: &[u8], limit: Duration) -> io::Result<()>;
}

/// The least time limit that the operating systems take.
const SHORTEST: Duration = Duration::from_millis(1);

/// 0 bytes where nothing came in time; an end of the stream is an error, since a board does not hang up.
fn came(read: io::Result<usize>) -> io::Result<usize> {
    match read {
        Ok(0) => Err(io::Error::new(ErrorKind::UnexpectedEof, "the other side closed the connection")),
        Err(error)
            if matches!(
                error.kind(),
                ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted
            ) =>
        {
            Ok(0)
        }
        other => other,
    }
}

impl Wire for TcpStream {
    fn read(&mut self, into: &mut [u8], limit: Duration) -> io::Result<usize> {
        self.set_read_timeout(Some(limit.max(SHORTEST)))?;
        came(Read::read(self, into))
    }

    fn write(&mut self, bytes: &[u8], limit: Duration) -> io::Result<()> {
        self.set_write_timeout(Some(limit.max(SHORTEST)))?;
        self.write_all(bytes)
    }
}

/// An open serial port.
struct Serial(Box<dyn serialport::SerialPort>);

impl Wire for Serial {
    fn read(&mut self, into: &mut [u8], limit: Duration) -> io::Result<usize> {
        self.0.set_timeout(limit.max(SHORTEST))?;
        came(self.0.read(into))
    }

    fn write(&mut self, bytes: &[u8], limit: Duration) -> io::Result<()> {
        self.0.set_timeout(limit.max(SHORTEST))?;
        self.0.write_all(bytes)
    }
}

impl Address {
    /// As the command line names it, which sees to it that there is one.
    pub fn of(arguments: &LinkArgs) -> Self {
        match (&arguments.tcp, &arguments.port) {
            (Some(address), _) => Address::Tcp(address.clone()),
            (None, port) => Address::Serial(port.clone().unwrap_or_default()),
        }
    }

    /// Opens it.
    ///
    /// # Errors
    /// It is not there, not allowed, or taken; with what to do.
    pub fn open(&self, limit: Duration) -> Outcome<Box<dyn Wire>> {
        match self {
            Address::Serial(name) => open_serial(name),
            Address::Tcp(name) => open_tcp(name, limit),
        }
    }
}

fn open_serial(name: &str) -> Outcome<Box<dyn Wire>> {
    match serialport::new(name, BAUD).timeout(SHORTEST).open() {
        Ok(port) => Ok(Box::new(Serial(port))),
        Err(error) => {
            let remedy = match error.kind() {
                serialport::ErrorKind::NoDevice | serialport::ErrorKind::Io(ErrorKind::NotFound) => {
                    there_are()
                }
                serialport::ErrorKind::Io(ErrorKind::PermissionDenied) => {
                    "permission denied. On Linux, add yourself to the group of the port (often dialout)"
                        .into()
                }
                _ => format!("{error}. Is it open in another program?"),
            };
            Err(Failure::usage(format!("cannot open the serial port {name}: {remedy}")))
        }
    }
}

/// The ports that could have been meant.
fn there_are() -> String {
    let names: Vec<String> =
        serialport::available_ports().unwrap_or_default().into_iter().map(|port| port.port_name).collect();
    if names.is_empty() {
        "there is no port. Is the board connected?".into()
    } else {
        format!("no such port. Available ports: {}", names.join(", "))
    }
}

fn open_tcp(name: &str, limit: Duration) -> Outcome<Box<dyn Wire>> {
    let fail = |why: String| Failure::usage(format!("cannot connect to {name}: {why}"));
    let addresses = name
        .to_socket_addrs()
        .map_err(|error| fail(format!("{error}. Expected HOST:PORT, as in localhost:4000")))?;
    let mut last = "it has no address".to_string();
    for address in addresses {
        match TcpStream::connect_timeout(&address, limit.max(SHORTEST)) {
            Ok(stream) => {
                // Lines are short and each waits for its answer.
                stream.set_nodelay(true).map_err(|error| fail(error.to_string()))?;
                return Ok(Box::new(stream));
            }
            Err(error) if error.kind() == ErrorKind::ConnectionRefused => {
                last = "no program listens there. Is the program that forwards the console running?".into();
            }
            Err(error) => last = error.to_string(),
        }
    }
    Err(fail(last))
}

/// What is wrong between here and the board.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Trouble {
    /// The wire is gone: the cable was pulled, the other side has ended.
    Gone(String),
    /// Nothing came.
    Silent(Duration),
    /// What came is not text.
    NotText,
    /// What came is text, and not that of a board's console.
    Foreign(String),
    /// The board said no.
    Refused {
        /// The command.
        command: String,
        /// Its answer: the code and the words.
        answer: String,
    },
}

impl Trouble {
    /// As a failure of the command, with what to do.
    pub fn at(&self, address: &Address) -> Failure {
        match self {
            Trouble::Gone(why) => Failure::usage(format!("{address}: the connection was closed ({why})")),
            Trouble::Silent(waited) => Failure::usage(format!(
                "{address}: no answer for {:.0} s. Is the board powered, is this its port, and does it run the ironout \
                 firmware?",
                waited.as_secs_f64()
            )),
            Trouble::NotText => Failure::usage(format!(
                "{address}: the data are not text. Is this the console, at {BAUD} baud (8N1)?"
            )),
            Trouble::Foreign(line) => Failure::usage(format!(
                "{address}: the device is not a board with the ironout console. It answers {line:?}"
            )),
            Trouble::Refused { command, answer } => {
                Failure::refused(format!("the board answered `{command}` with: err {answer}"))
            }
        }
    }
}
