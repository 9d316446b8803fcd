//! The console on two ports. The one that sent the last line has it: replies and streams go there.

use super::uart::Uart;
use super::usb::Usb;
use core::fmt;
use ironout::device::Output;

#[derive(Clone, Copy, PartialEq, Eq)]
enum Port {
    Uart,
    Usb,
}

impl Port {
    const fn other(self) -> Self {
        match self {
            Port::Uart => Port::Usb,
            Port::Usb => Port::Uart,
        }
    }
}

/// The console. There is one: [`super::Board::take`] makes it.
pub struct Console {
    uart: Uart,
    usb: Usb,
    /// The port that has the console.
    port: Port,
    /// It has begun a line: until its end the other port waits, so that no line is mixed of two.
    in_line: bool,
}

impl Console {
    pub(super) fn new(uart: Uart, usb: Usb) -> Self {
        Self { uart, usb, port: Port::Uart, in_line: false }
    }

    fn read_from(&mut self, port: Port) -> Option<u8> {
        match port {
            Port::Uart => self.uart.read(),
            Port::Usb => self.usb.read(),
        }
    }

    /// The next byte received.
    pub fn read(&mut self) -> Option<u8> {
        let byte = match self.read_from(self.port) {
            Some(byte) => byte,
            None if self.in_line => return None,
            None => {
                let byte = self.read_from(self.port.other())?;
                self.port = self.port.other();
                byte
            }
        };
        self.in_line = byte != b'\n';
        Some(byte)
    }

    /// Whether [`Self::read`] has something to give.
    pub fn has_input(&self) -> bool {
        let (uart, usb) = (self.uart.has_input(), self.usb.has_input());
        match (self.in_line, self.port) {
            (false, _) => uart || usb,
            (true, Port::Uart) => uart,
            (true, Port::Usb) => usb,
        }
    }
}

impl fmt::Write for Console {
    /// Queues the text. It never fails and never waits: text that the other end does not take is lost, whole lines of it.
    fn write_str(&mut self, text: &str) -> fmt::Result {
        match self.port {
            Port::Uart => self.uart.put(text),
            Port::Usb => self.usb.put(text),
        }
        Ok(())
    }
}

impl Output for Console {
    fn takes(&self, bytes: usize) -> bool {
        match self.port {
            Port::Uart => self.uart.takes(bytes),
            Port::Usb => self.usb.takes(bytes),
        }
    }
}
