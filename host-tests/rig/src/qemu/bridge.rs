//! The emulated board's console behind a TCP port, its sensor turned by what the board itself has sampled.

use super::emulator::Emulator;
use super::error::Error;
use std::io::{ErrorKind, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::time::Duration;

/// How long one side is listened to before the other one is.
const GLANCE: Duration = Duration::from_millis(2);

impl Emulator {
    /// Passes the console on to the next client of `listener`, until it hangs up. After each line of a stream `turn` is given
    /// the board, the line and how many there were, to change what the board's sensors are in: its own samples are the clock,
    /// so that a busy host only takes longer.
    ///
    /// # Errors
    /// The emulator is gone, or `turn` has failed.
    pub fn serve(
        &mut self,
        listener: &TcpListener,
        mut turn: impl FnMut(&mut Self, &str, u64) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let (mut client, _) = listener.accept().map_err(Error::io("wait for a client"))?;
        client.set_read_timeout(Some(GLANCE)).map_err(Error::io("set the client's time limit"))?;
        let (mut samples, mut line) = (0, Vec::new());
        loop {
            match hear(&mut client) {
                Ok(bytes) => self.console.send(&bytes)?,
                // It has hung up.
                Err(_) => return Ok(()),
            }
            let said = self.console.read_some(GLANCE)?;
            if client.write_all(&said).is_err() {
                return Ok(());
            }
            for byte in said {
                line.push(byte);
                if byte != b'\n' {
                    continue;
                }
                if [&b"R,"[..], b"C,", b"L,"].iter().any(|mark| line.starts_with(mark)) {
                    samples += 1;
                    turn(self, &String::from_utf8_lossy(&line), samples)?;
                }
                line.clear();
            }
        }
    }
}

/// What the client has sent; an error once it has hung up.
fn hear(client: &mut TcpStream) -> std::io::Result<Vec<u8>> {
    let mut chunk = [0; 512];
    match client.read(&mut chunk) {
        Ok(0) => Err(ErrorKind::UnexpectedEof.into()),
        Ok(count) => Ok(chunk[..count].to_vec()),
        Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => Ok(Vec::new()),
        Err(error) => Err(error),
    }
}
