//! A bus that answers anything: no driver panics, hangs, or gives a measurement out of its own range.

use embedded_hal::i2c::{ErrorKind, ErrorType, I2c, Operation};
use ironout_drivers::{AnyMagnetometer, Found, Kind, Magnetometer, probe};
use ironout_rig::board::SimDelay;
use ironout_rig::bus::Clock;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

use crate::bench::KINDS;

/// Random bytes, and now and then an error. Every so often the bytes are those that were written last: a configuration that
/// keeps.
struct NoiseBus {
    rng: ChaCha8Rng,
    written: [u8; 256],
}

impl ErrorType for NoiseBus {
    type Error = ErrorKind;
}

impl I2c for NoiseBus {
    fn transaction(&mut self, _address: u8, operations: &mut [Operation<'_>]) -> Result<(), ErrorKind> {
        if self.rng.random_bool(0.02) {
            return Err(ErrorKind::ArbitrationLoss);
        }
        let keeps = self.rng.random_bool(0.9);
        let mut register = 0_u8;
        for operation in operations {
            match operation {
                Operation::Write([first, rest @ ..]) => {
                    register = *first & 0x7f;
                    for &byte in rest.iter() {
                        self.written[usize::from(register)] = byte;
                    }
                }
                Operation::Write([]) => {}
                Operation::Read(bytes) => {
                    for byte in bytes.iter_mut() {
                        let kept = self.written[usize::from(register)];
                        *byte = if keeps && kept != 0 { kept } else { self.rng.random() };
                        register = register.wrapping_add(1);
                    }
                }
            }
        }
        Ok(())
    }
}

#[test]
fn random_answers_never_panic_and_what_is_in_range_is() {
    for (seed, kind) in (0..).zip(KINDS) {
        let mut bus = NoiseBus { rng: ChaCha8Rng::seed_from_u64(seed), written: [0; 256] };
        // The identities, where they are asked: configurations get further with them.
        let identities: [(u8, &[u8]); 7] = [
            (0x4f, &[0x40]),
            (0x0f, &[0x3d]),
            (0x0a, b"H43"),
            (0x0d, &[0xff]),
            (0x2f, &[0x30]),
            (0x40, &[0x32]),
            (0x36, &[0x22]),
        ];
        for (register, bytes) in identities {
            bus.written[usize::from(register)..][..bytes.len()].copy_from_slice(bytes);
        }
        let clock = Clock::default();
        let found = Found { address: 0x1e, kind, or: None };
        let mut driver = AnyMagnetometer::new(bus, SimDelay(clock.clone()), found);
        let sensor = driver.describe();
        let (mut read, mut valid) = (0, 0);
        for round in 0..20_000 {
            if round % 50 == 0 {
                let _ = driver.init();
            }
            let _ = driver.temperature_c().map(|celsius| assert!(celsius.is_none_or(f32::is_finite)));
            if driver.data_ready() != Ok(true) {
                continue;
            }
            let Ok(reading) = driver.read() else { continue };
            read += 1;
            let sample = sensor.sample(&reading);
            if let Some(field) = sensor.measured_ut(sample) {
                valid += 1;
                for (ut, scale) in field.into_iter().zip(sensor.ut_per_count) {
                    assert!(
                        ut.abs() <= scale * (f32::from(sensor.full_scale_counts) + 1.5),
                        "{kind:?}: {field:?}"
                    );
                }
            }
        }
        // Of 24 random bits on three axes next to none are within ±800 or ±2000 µT.
        let wide = matches!(kind, Kind::Rm3100 | Kind::Bmm350);
        assert!(read > 500 && (valid > 0 || wide), "{kind:?}: {read} {valid}");
    }
}

#[test]
fn a_probing_of_noise_ends_and_lists_no_more_than_it_has_room_for() {
    for seed in 0..500 {
        let mut bus = NoiseBus { rng: ChaCha8Rng::seed_from_u64(seed), written: [0; 256] };
        let findings = probe(&mut bus, &mut SimDelay(Clock::default()));
        assert!(findings.iter().count() <= ironout_drivers::MOST_FOUND);
    }
}
