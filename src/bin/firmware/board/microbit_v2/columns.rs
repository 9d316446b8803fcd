//! What the micro:bit measures beside field and motion: its processor's temperature.

use embassy_nrf::pac;
use ironout::device::{Origin, TEMPERATURE_MS};

/// The temperature sensor. A measurement takes 36 µs, beside everything else (nRF52833 product specification, 6.25).
pub struct Columns {
    next_us: u64,
}

impl Columns {
    pub(super) fn new() -> Self {
        pac::TEMP.tasks_start().write_value(1);
        Self { next_us: 0 }
    }

    /// Gives `take` the temperature, four times a second: that measured since the last time.
    pub fn measure(&mut self, now_us: u64, mut take: impl FnMut(&str, f32, Origin)) {
        if now_us < self.next_us || pac::TEMP.events_datardy().read() == 0 {
            return;
        }
        self.next_us = now_us + 1000 * TEMPERATURE_MS;
        pac::TEMP.events_datardy().write_value(0);
        // Quarters of a degree.
        let quarters = pac::TEMP.temp().read() as i32;
        pac::TEMP.tasks_start().write_value(1);
        take("cpu_temp_c", quarters as f32 * 0.25, Origin::Inside);
    }
}
