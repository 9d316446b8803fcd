//! All that runs for a sample on a board, and nothing else: that no panic can be reached from it is read from this image's symbols.
#![no_std]
#![no_main]

use core::hint::black_box;
use cortex_m_rt::entry;
use ironout::device::{Device, DeviceConfig, Pace};
use ironout::sensor::{Reading, Sensor};
use ironout_m4_bench::board::exit;

#[entry]
fn main() -> ! {
    let sensor = Sensor::uniform("bench", 0.1, 50.0);
    let mut device = Device::new(DeviceConfig { board: "bench", sensor, pace: Pace::Pushed });
    for t_ms in 0..1000 {
        // The compiler knows neither the device's state nor the reading.
        let device = black_box(&mut device);
        device.on_sample(&black_box(Reading { counts: [1, 2, 3], overflow: [false; 3] }), black_box(t_ms));
    }
    exit(black_box(&device).samples_lost() == 0)
}
