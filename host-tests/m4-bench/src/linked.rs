//! What programs link of the library, from a single function to everything: `cargo footprint` measures the size of each.
//!
//! Inputs come through `black_box`, so that the compiler knows neither data nor settings, as in a firmware.

use core::hint::black_box;
use ironout::calibration::Calibration;
use ironout::fit::{FitOptions, Method, fit};
use ironout::moments::Moments;
use ironout::scatter::Scatter;

/// A program of the file's name that ends with what the function returns.
#[macro_export]
macro_rules! linked_program {
    ($function:ident) => {
        #[cortex_m_rt::entry]
        fn main() -> ! {
            $crate::board::exit($crate::linked::$function())
        }
    };
}

/// Nothing of the library.
pub fn nothing() -> bool {
    black_box([1i16, 2, 3]).map(i32::from).iter().sum::<i32>() > 0
}

fn applied(calibration: &Calibration<f32>) -> bool {
    black_box(calibration.apply(black_box([1.0, 2.0, 3.0])))[0] > 0.0
}

/// Offset and matrix applied to a sample.
pub fn apply() -> bool {
    applied(black_box(&Calibration::identity(50.0)))
}

fn summed() -> Moments {
    let mut moments = Moments::new();
    for _ in 0..1000 {
        black_box(&mut moments).push(black_box([1, 2, 3]));
    }
    moments
}

/// The exact sums.
pub fn sums() -> bool {
    black_box(summed().count()) > 0
}

fn fitted(method: Method) -> bool {
    let options = FitOptions { method, ..FitOptions::default() };
    Scatter::from_moments(&summed(), [0.1; 3])
        .and_then(|scatter| fit(&scatter, &options))
        .is_ok_and(|report| applied(&report.calibration.cast()))
}

/// Sums, the fit by the trace, correction.
pub fn trace() -> bool {
    fitted(Method::Trace)
}

/// Sums, the adjusted fit, correction.
pub fn adjusted() -> bool {
    fitted(Method::Adjusted)
}

#[cfg(feature = "session")]
pub use with_session::*;

#[cfg(feature = "session")]
mod with_session {
    use super::*;
    use ironout::record::Record;
    use ironout::sensor::{Sample, Sensor};
    use ironout::session::{Session, SessionConfig};

    /// A session from its start to its record, with its status.
    #[inline(never)]
    pub(super) fn calibrated() -> Option<Record> {
        let sensor = Sensor::uniform("a chip", black_box(0.1), black_box(50.0));
        let mut session =
            Session::new(SessionConfig { field_ut: black_box(None), ..SessionConfig::of(&sensor) });
        session.start();
        for _ in 0..1000 {
            session.push(black_box(Sample::valid([1, 2, 3])));
            black_box(session.status());
        }
        session.stop().ok()?;
        session.accept().ok()
    }

    /// A whole calibration: session, status with its hint, verdict, correction.
    pub fn session() -> bool {
        calibrated().is_some_and(|record| applied(&record.calibration.cast()))
    }
}

#[cfg(feature = "record")]
pub use with_record::*;

#[cfg(feature = "record")]
mod with_record {
    use super::*;
    use core::convert::Infallible;
    use embedded_storage::{ReadStorage, Storage};
    use ironout::record::{MAX_RECORD_BYTES, Record};
    use ironout::store::{Done, StorageSlots, StoreJob, run};

    /// Session, and its record as bytes and back.
    pub fn session_record() -> bool {
        let Some(record) = calibrated() else { return false };
        let Ok(bytes) = record.encode() else { return false };
        Record::decode(black_box(bytes).as_bytes()).is_ok_and(|record| applied(&record.calibration.cast()))
    }

    /// Memory that a firmware would have as an EEPROM.
    struct Memory([u8; 2 * MAX_RECORD_BYTES]);

    impl ReadStorage for Memory {
        type Error = Infallible;
        fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Infallible> {
            for (place, byte) in bytes.iter_mut().enumerate() {
                *byte = black_box(self.0.get(offset as usize + place).copied().unwrap_or_default());
            }
            Ok(())
        }
        fn capacity(&self) -> usize {
            self.0.len()
        }
    }

    impl Storage for Memory {
        fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Infallible> {
            for (slot, byte) in self.0.iter_mut().skip(offset as usize).zip(bytes) {
                *slot = black_box(*byte);
            }
            Ok(())
        }
    }

    /// Session, and its record kept in two slots.
    pub fn session_store() -> bool {
        let Ok(mut slots) = StorageSlots::new(Memory([0; 2 * MAX_RECORD_BYTES]), 0, 1) else { return false };
        let in_use = match run(StoreJob::inspect(), &mut slots, |_| ()) {
            Ok(Done::Inspected(both, Some(record))) if applied(&record.calibration.cast()) => both.current(),
            _ => None,
        };
        let Some(record) = calibrated() else { return false };
        run(StoreJob::save(in_use.map(|(slot, _)| slot), record), &mut slots, |_| ()).is_ok()
    }
}

#[cfg(feature = "effects")]
pub use with_effects::*;

#[cfg(feature = "effects")]
mod with_effects {
    use super::*;
    use ironout::extended::{ExtendedCalibration, Live};

    #[inline(never)]
    pub(super) fn corrected(calibration: &ExtendedCalibration<f64>) -> bool {
        let (calibration, _) = calibration.on_own_clock();
        let Ok(mut live) = Live::new(&calibration.cast::<f32>()) else { return false };
        live.set(black_box("temp_c"), black_box(20.0));
        live.advance(black_box(1.0));
        let outside = live.outside().next().is_some();
        live.apply(black_box([1.0, 2.0, 3.0]), black_box(None)).is_ok_and(|ut| ut[0] > 0.0 && !outside)
    }

    /// Correction with effects, of a calibration that is in the program.
    pub fn live() -> bool {
        corrected(&black_box(ExtendedCalibration::plain(Calibration::identity(50.0))))
    }
}

#[cfg(all(feature = "record", feature = "effects"))]
pub use with_both::*;

#[cfg(all(feature = "record", feature = "effects"))]
mod with_both {
    use super::*;
    use ironout::record::{MAX_RECORD_BYTES, Record};

    /// Correction with effects of a record in memory.
    pub fn live_record() -> bool {
        Record::decode(&black_box([0; MAX_RECORD_BYTES])).is_ok_and(|record| corrected(&record.extended()))
    }
}

#[cfg(all(feature = "session", feature = "effects"))]
pub use with_session_and_effects::*;

#[cfg(all(feature = "session", feature = "effects"))]
mod with_session_and_effects {
    use super::*;

    /// Session, and correction with effects; no record.
    pub fn session_live() -> bool {
        calibrated().is_some_and(|record| corrected(&black_box(record.extended())))
    }
}

#[cfg(feature = "study")]
pub use with_study::*;

#[cfg(feature = "study")]
mod with_study {
    use super::*;
    use ironout::effect::ColumnName;
    use ironout::learn::{Inquiry, Learner, Motion};

    /// The study of missing effects on the board, from a calibration that is in the program.
    pub fn study() -> bool {
        let mut learner = Learner::new();
        learner.begin(&black_box(Calibration::identity(50.0)));
        let Ok(column) = ColumnName::new("temp_c") else { return false };
        for t_ms in 0..1000 {
            learner.feed(&column, black_box(20.0));
            let motion = Motion { accel_mps2: black_box(None), turn_radps: black_box(None) };
            learner.push(black_box([1.0, 2.0, 3.0]), black_box(t_ms), &motion);
        }
        let mut inquiry = Inquiry::new(&learner, Default::default());
        loop {
            if let Some(outcome) = inquiry.step(&learner) {
                return black_box(outcome).rows > 0;
            }
        }
    }
}
