//! What the Pico measures beside field and motion: its processor's temperature, and the voltage at three pins.

use embassy_rp::Peri;
use embassy_rp::adc::{Adc, Blocking, Channel, Config};
use embassy_rp::gpio::Pull;
use embassy_rp::peripherals::{ADC, ADC_TEMP_SENSOR, PIN_26, PIN_27, PIN_28};
use ironout::device::{Origin, TEMPERATURE_MS};

/// Volts of a count: 3.3 V are 4096 (RP2040 datasheet, 4.9).
const VOLTS: f32 = 3.3 / 4096.0;
/// Of how many conversions the temperature is: one count is half a degree.
const CONVERSIONS: u16 = 16;
const PINS: [&str; 3] = ["adc0_v", "adc1_v", "adc2_v"];

/// The converter and its channels.
pub struct Columns {
    adc: Adc<'static, Blocking>,
    temperature: Channel<'static>,
    pins: [Channel<'static>; 3],
    next_us: u64,
}

impl Columns {
    pub(super) fn new(
        adc: Peri<'static, ADC>,
        temperature: Peri<'static, ADC_TEMP_SENSOR>,
        first: Peri<'static, PIN_26>,
        second: Peri<'static, PIN_27>,
        third: Peri<'static, PIN_28>,
    ) -> Self {
        let adc = Adc::new_blocking(adc, Config::default());
        let pins = [
            Channel::new_pin(first, Pull::None),
            Channel::new_pin(second, Pull::None),
            Channel::new_pin(third, Pull::None),
        ];
        Self { adc, temperature: Channel::new_temp_sensor(temperature), pins, next_us: 0 }
    }

    /// Gives `take` what there is: the pins each time (2 µs a conversion), the temperature four times a second. A conversion that
    /// fails is left out.
    pub fn measure(&mut self, now_us: u64, mut take: impl FnMut(&str, f32, Origin)) {
        for (name, pin) in PINS.into_iter().zip(&mut self.pins) {
            if let Ok(counts) = self.adc.blocking_read(pin) {
                take(name, f32::from(counts) * VOLTS, Origin::Pin);
            }
        }
        if now_us < self.next_us {
            return;
        }
        self.next_us = now_us + 1000 * TEMPERATURE_MS;
        let mut sum = 0;
        for _ in 0..CONVERSIONS {
            let Ok(counts) = self.adc.blocking_read(&mut self.temperature) else { return };
            sum += counts;
        }
        // 0.706 V at 27 °C, and 1.721 mV less for each degree more (RP2040 datasheet, 4.9.5).
        let volts = f32::from(sum) / f32::from(CONVERSIONS) * VOLTS;
        take("cpu_temp_c", 27.0 - (volts - 0.706) / 0.001721, Origin::Inside);
    }
}
