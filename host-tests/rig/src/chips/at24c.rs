//! A 24-series EEPROM: pages, write time, and power that fails in the middle.

use crate::bus::{Chip, Clock, Direction};

const WRITE_TIME_NS: u64 = 5_000_000;

/// What the rest of a page holds when power fails while the page is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TornPage {
    /// What it held before: the bytes are written one after the other.
    Old,
    /// 0xff: the page is erased before it is written.
    Erased,
    /// Anything: cells that were being changed.
    Garbage,
}

/// The chip.
pub struct At24cChip {
    address: u8,
    page_bytes: usize,
    /// The memory.
    pub memory: Vec<u8>,
    /// How a page is torn.
    pub torn_page: TornPage,
    bytes_until_power_loss: Option<usize>,
    dead: bool,
    pointer: usize,
    received: usize,
    page: Vec<(usize, u8)>,
    busy_until_ns: u64,
}

impl At24cChip {
    /// An erased chip.
    pub fn new(address: u8, size_bytes: usize, page_bytes: usize) -> Self {
        Self {
            address,
            page_bytes,
            memory: vec![0xff; size_bytes],
            torn_page: TornPage::Old,
            bytes_until_power_loss: None,
            dead: false,
            pointer: 0,
            received: 0,
            page: Vec::new(),
            busy_until_ns: 0,
        }
    }

    /// Power fails when this many more bytes were written into the cells; then the chip is silent.
    pub fn lose_power_after(&mut self, bytes: usize) {
        self.bytes_until_power_loss = Some(bytes);
    }

    /// Power is back: what was in the cells is what is there.
    pub fn power_cycle(&mut self) {
        self.dead = false;
        self.bytes_until_power_loss = None;
        self.page.clear();
        self.busy_until_ns = 0;
    }

    fn commit(&mut self) {
        let page = core::mem::take(&mut self.page);
        for (at, byte) in page {
            match &mut self.bytes_until_power_loss {
                Some(0) => {
                    self.dead = true;
                    match self.torn_page {
                        TornPage::Old => {}
                        TornPage::Erased => self.memory[at] = 0xff,
                        TornPage::Garbage => self.memory[at] = self.memory[at].wrapping_mul(31) ^ byte ^ 0x5a,
                    }
                    continue;
                }
                Some(left) => *left -= 1,
                None => {}
            }
            self.memory[at] = byte;
        }
    }
}

impl Chip for At24cChip {
    fn address(&self) -> u8 {
        self.address
    }

    fn start(&mut self, direction: Direction, clock: &Clock) -> bool {
        if self.dead || clock.ns() < self.busy_until_ns {
            return false;
        }
        if direction == Direction::Write {
            self.received = 0;
        }
        true
    }

    fn write(&mut self, byte: u8) -> bool {
        match self.received {
            0 => self.pointer = usize::from(byte) << 8,
            1 => self.pointer = (self.pointer | usize::from(byte)) % self.memory.len(),
            _ => {
                self.page.push((self.pointer, byte));
                // The address counts within the page only.
                let start = self.pointer - self.pointer % self.page_bytes;
                self.pointer = start + (self.pointer + 1) % self.page_bytes;
            }
        }
        self.received += 1;
        true
    }

    fn read(&mut self) -> u8 {
        let byte = self.memory[self.pointer];
        self.pointer = (self.pointer + 1) % self.memory.len();
        byte
    }

    fn stop(&mut self, clock: &Clock) {
        if !self.page.is_empty() {
            self.commit();
            self.busy_until_ns = clock.ns() + WRITE_TIME_NS;
        }
    }
}
