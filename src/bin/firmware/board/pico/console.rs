//! The console on two ports. The one that sent the last line has it: replies and streams go there.

use super::time::now_us;
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
    /// When it began the line that it is in: until its end the other port waits, so that no line is mixed of two.
    line_since_us: Option<u64>,
}

/// How long a line may take that another port waits for; then it is ended, and its rest is refused.
const LINE_LIMIT_US: u64 = 3_000_000;

impl Console {
    pub(super) fn new(uart: Uart, usb: Usb) -> Self {
        Self { uart, usb, port: Port::Uart, line_since_us: None }
    }

    fn read_from(&mut self, port: Port) -> Option<u8> {
        match port {
            Port::Uart => self.uart.read(),
            Port::Usb => self.usb.read(),
        }
    }

    fn has_input_at(&self, port: Port) -> bool {
        match port {
            Port::Uart => self.uart.has_input(),
            Port::Usb => self.usb.has_input(),
        }
    }

    /// The next byte received.
    pub fn read(&mut self) -> Option<u8> {
        let other = self.port.other();
        let since_us = match self.line_since_us {
            None => {
                // By turns, so that a port that sends without end does not keep the other one waiting.
                if self.has_input_at(other) {
                    self.port = other;
                }
                now_us()
            }
            Some(since_us) if self.has_input_at(other) && now_us() - since_us > LINE_LIMIT_US => {
                self.line_since_us = None;
                return Some(b'\n');
            }
            Some(since_us) => since_us,
        };
        let byte = self.read_from(self.port)?;
        self.line_since_us = (byte != b'\n').then_some(since_us);
        Some(byte)
    }

    /// Whether [`Self::read`] has something to give.
    pub fn has_input(&self) -> bool {
        self.has_input_at(self.port) || (self.line_since_us.is_none() && self.has_input_at(self.port.other()))
    }
}

impl fmt::Write for Console {
    /// Queues the text. It never fails and never waits: text that the other end does not take is lost, whole lines of it.
    fn write_str(&mut self, text: &str) -> fmt::Result {
        match self.port {
            Port::Uart => self.uart.write_str(text),
            Port::Usb => {
                self.usb.put(text);
                Ok(())
            }
        }
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
