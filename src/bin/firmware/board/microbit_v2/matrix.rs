//! The matrix of 5×5 lights and the button.
//!
//! One row is lit at a time, for two milliseconds: an interrupt of the lowest priority goes on to the next.

use core::cell::RefCell;
use core::sync::atomic::{AtomicU32, Ordering};
use critical_section::Mutex;
use embassy_nrf::Peri;
use embassy_nrf::gpio::{AnyPin, Input, Level, Output, OutputDrive};
use embassy_nrf::interrupt;
use embassy_nrf::interrupt::InterruptExt;
use embassy_nrf::pac;
use embassy_nrf::peripherals::TIMER2;
use ironout::device::Shown;

/// How long a row is lit, µs.
const ROW_US: u32 = 2_000;

const TIMER: pac::timer::Timer = pac::TIMER2;

/// The lights that are on: five bits a row, the first row in the lowest.
static PICTURE: AtomicU32 = AtomicU32::new(0);

struct Lines {
    rows: [Output<'static>; 5],
    columns: [Output<'static>; 5],
    /// The row that is lit.
    lit: usize,
}

static LINES: Mutex<RefCell<Option<Lines>>> = Mutex::new(RefCell::new(None));

#[interrupt]
fn TIMER2() {
    TIMER.events_compare(0).write_value(0);
    let _ = TIMER.events_compare(0).read();
    critical_section::with(|section| {
        let mut lines = LINES.borrow_ref_mut(section);
        let Some(Lines { rows, columns, lit }) = lines.as_mut() else { return };
        let next = (*lit + 1) % rows.len();
        let picture = PICTURE.load(Ordering::Relaxed) >> (5 * next);
        if let Some(row) = rows.get_mut(*lit) {
            row.set_low();
        }
        for (column, line) in columns.iter_mut().enumerate() {
            // A column takes the current in where it is low.
            line.set_level(if picture >> column & 1 != 0 { Level::Low } else { Level::High });
        }
        if let Some(row) = rows.get_mut(next) {
            row.set_high();
        }
        *lit = next;
    });
}

/// The matrix and the button.
pub struct Panel {
    button: Input<'static>,
}

impl Panel {
    pub(super) fn new(
        _timer: Peri<'static, TIMER2>,
        rows: [Peri<'static, AnyPin>; 5],
        columns: [Peri<'static, AnyPin>; 5],
        button: Input<'static>,
    ) -> Self {
        let lines = Lines {
            rows: rows.map(|pin| Output::new(pin, Level::Low, OutputDrive::Standard)),
            columns: columns.map(|pin| Output::new(pin, Level::High, OutputDrive::Standard)),
            lit: 0,
        };
        critical_section::with(|section| LINES.borrow(section).replace(Some(lines)));
        TIMER.tasks_stop().write_value(1);
        TIMER.bitmode().write(|w| w.set_bitmode(pac::timer::vals::Bitmode::_32bit));
        TIMER.prescaler().write(|w| w.set_prescaler(4));
        TIMER.cc(0).write_value(ROW_US);
        TIMER.shorts().write(|w| w.set_compare_clear(0, true));
        TIMER.intenset().write(|w| w.set_compare(0, true));
        TIMER.tasks_clear().write_value(1);
        TIMER.tasks_start().write_value(1);
        // SAFETY: its handler is above, and no critical section relies on masks.
        unsafe { interrupt::TIMER2.enable() };
        Self { button }
    }

    /// Shows the state on all lights.
    pub fn show(&mut self, shown: &Shown) {
        let rows = shown.matrix().into_iter().enumerate();
        PICTURE.store(rows.fold(0, |all, (row, bits)| all | u32::from(bits) << (5 * row)), Ordering::Relaxed);
    }

    /// Whether button A is down, bounces and all.
    pub fn button_down(&self) -> bool {
        self.button.is_low()
    }
}
