//! The correction of a calibration with effects.

use crate::error::IronoutError;
use crate::pointer;
use crate::record::error_of;
use crate::state::{self, Kind};
use core::ffi::c_char;
use ironout::effect::TIME;
use ironout::extended::{ExtendedCalibration, Live, NotCorrected};
use ironout::record::Record;

/// A correction with effects, in the caller's memory. Its content is the library's own.
#[repr(C)]
pub struct IronoutLive {
    opaque: [u64; IRONOUT_LIVE_WORDS],
}

/// Size of ironout_live in words of 8 bytes.
pub const IRONOUT_LIVE_WORDS: usize = 304;

/// Size of a column's name with the zero byte at its end.
pub const IRONOUT_COLUMN_BYTES: usize = 33;

/// A column that is outside the range that its effect was fitted over.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IronoutOutside {
    /// What the effect uses now, in the column's unit.
    pub value: f64,
    /// The least value that the effect was fitted over.
    pub least: f64,
    /// The greatest.
    pub greatest: f64,
    /// The column's name, with a zero byte at its end.
    pub column: [c_char; IRONOUT_COLUMN_BYTES],
}

/// What is in it.
struct Correction {
    live: Live<f32>,
    /// What the clock of the recording shows when that of the correction is zero, s.
    origin_s: f64,
}

impl Kind for Correction {
    const MARK: u32 = 0x4972_6f02;
    type Opaque = IronoutLive;
}

const _: () = Correction::FITS;

// Each step apart: what one needs on the stack is gone before the next.
impl Correction {
    #[inline(never)]
    fn decoded(bytes: &[u8]) -> Result<ExtendedCalibration<f64>, IronoutError> {
        Record::decode(bytes).map_err(error_of).map(|record| record.extended())
    }

    #[inline(never)]
    fn own_clock(calibration: &ExtendedCalibration<f64>) -> (ExtendedCalibration<f32>, f64) {
        let (calibration, origin_s) = calibration.on_own_clock();
        (calibration.cast(), origin_s)
    }

    #[inline(never)]
    fn calibration(bytes: &[u8]) -> Result<(ExtendedCalibration<f32>, f64), IronoutError> {
        Ok(Self::own_clock(&Self::decoded(bytes)?))
    }

    #[inline(never)]
    fn put(
        place: *mut IronoutLive,
        calibration: &ExtendedCalibration<f32>,
        origin_s: f64,
    ) -> Result<(), IronoutError> {
        let live = Live::new(calibration).map_err(|_| IronoutError::IRONOUT_RECORD_UNSOUND)?;
        state::init(place, Self { live, origin_s })
    }

    fn apply(
        &mut self,
        t_s: f64,
        measured_ut: [f32; 3],
        turn_radps: Option<[f32; 3]>,
    ) -> Result<[f32; 3], IronoutError> {
        if self.live.needs_time() {
            self.live.advance(t_s - self.origin_s);
        }
        self.live.apply(measured_ut, turn_radps).map_err(|error| match error {
            NotCorrected::Column(_) => IronoutError::IRONOUT_COLUMN_UNKNOWN,
            NotCorrected::RateOfTurn(_) => IronoutError::IRONOUT_NEEDS_GYRO,
            NotCorrected::TooFar => IronoutError::IRONOUT_TOO_FAR,
            NotCorrected::Shape(_) | NotCorrected::NotFinite => IronoutError::IRONOUT_NOT_FINITE,
        })
    }

    fn outside(&self, index: u32) -> Result<IronoutOutside, IronoutError> {
        let outside = self.live.outside().nth(index as usize).ok_or(IronoutError::IRONOUT_NO_MORE)?;
        let origin_s = if outside.column == TIME { self.origin_s } else { 0.0 };
        let [least, greatest] = outside.range.map(|end| f64::from(end) + origin_s);
        let mut column = [0; IRONOUT_COLUMN_BYTES];
        for (place, byte) in column.iter_mut().zip(outside.column.bytes()).take(IRONOUT_COLUMN_BYTES - 1) {
            *place = byte as c_char;
        }
        Ok(IronoutOutside { value: f64::from(outside.value) + origin_s, least, greatest, column })
    }
}

/// Prepares the correction of a record, with or without effects. No column is known yet. On an error `live` is left as it
/// was.
#[unsafe(no_mangle)]
pub extern "C" fn ironout_live_init(live: *mut IronoutLive, bytes: *const u8, length: usize) -> IronoutError {
    let made = pointer::bytes(bytes, length).and_then(|bytes| {
        let (calibration, origin_s) = Correction::calibration(bytes)?;
        Correction::put(live, &calibration, origin_s)
    });
    IronoutError::of(made)
}

/// Sets a column, for example "temp_c" to the temperature in degrees Celsius, in the unit of the log that the effects were
/// fitted on. It keeps this value until it is set again; NaN makes it unknown.
///
/// IRONOUT_COLUMN_NOT_READ: no effect reads a column of this name.
#[unsafe(no_mangle)]
pub extern "C" fn ironout_live_set(
    live: *mut IronoutLive,
    column: *const c_char,
    value: f32,
) -> IronoutError {
    let set = pointer::text(column).and_then(|column| {
        let is_read = state::get_mut::<Correction>(live)?.live.set(column, value);
        if is_read { Ok(()) } else { Err(IronoutError::IRONOUT_COLUMN_NOT_READ) }
    });
    IronoutError::of(set)
}

/// Writes the name of the first column that is needed and not known. IRONOUT_NO_MORE: all are known. The column "t_s" is
/// the time of ironout_live_apply.
/// cbindgen:ptrs-as-arrays=[[column; IRONOUT_COLUMN_BYTES]]
#[unsafe(no_mangle)]
pub extern "C" fn ironout_live_missing(live: *const IronoutLive, column: *mut c_char) -> IronoutError {
    let written = state::get::<Correction>(live).and_then(|correction| {
        let name = correction.live.waits_for().ok_or(IronoutError::IRONOUT_NO_MORE)?;
        pointer::write_text(column, IRONOUT_COLUMN_BYTES, &[name])
    });
    IronoutError::of(written)
}

/// Writes the corrected field to `corrected_ut`, µT in the board's axes; on an error it is left as it was, and the old
/// correction stays in use. `t_s` is the time in seconds: any clock, but for effects of time, which need the clock of the
/// log that they were fitted on. `turn_radps` is the gyro's rate of turn in the board's axes; null if there is none.
///
/// IRONOUT_COLUMN_UNKNOWN: see ironout_live_missing. IRONOUT_NEEDS_GYRO, IRONOUT_TOO_FAR, IRONOUT_NOT_FINITE: not
/// corrected. There is no silent fallback.
/// cbindgen:ptrs-as-arrays=[[measured_ut; 3], [turn_radps; 3], [corrected_ut; 3]]
#[unsafe(no_mangle)]
pub extern "C" fn ironout_live_apply(
    live: *mut IronoutLive,
    t_s: f64,
    measured_ut: *const f32,
    turn_radps: *const f32,
    corrected_ut: *mut f32,
) -> IronoutError {
    let applied = pointer::vector(measured_ut).and_then(|measured_ut| {
        let turn_radps = pointer::optional_vector(turn_radps)?;
        let corrected = state::get_mut::<Correction>(live)?.apply(t_s, measured_ut, turn_radps)?;
        pointer::write_vector(corrected_ut, corrected)
    });
    IronoutError::of(applied)
}

/// Writes the column number `index`, from 0, of those that are outside the range that their effect was fitted over, as of
/// the last ironout_live_apply. The correction goes on there, with an error that grows with the distance; further outside
/// than the range is wide the effect keeps its value. IRONOUT_NO_MORE: there is no such column.
#[unsafe(no_mangle)]
pub extern "C" fn ironout_live_outside(
    live: *const IronoutLive,
    index: u32,
    outside: *mut IronoutOutside,
) -> IronoutError {
    let written = state::get::<Correction>(live)
        .and_then(|correction| pointer::write(outside, correction.outside(index)?));
    IronoutError::of(written)
}
