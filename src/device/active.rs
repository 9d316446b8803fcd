//! The calibration in use.

use core::fmt;

use super::extrapolated::Extrapolated;
use super::study::Motion;
use crate::effect::{Effect, Searched, TIME};
use crate::extended::{ExtendedCalibration, Live, LiveError, TurningField};
use crate::fit::MAX_PREDICTED_ERROR;
use crate::monitor::Monitor;
use crate::record::Record;
use crate::rezero::Rezero;
use crate::sensor::AxisMap;
use crate::store::Slot;

/// Why a stored calibration is not applied.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum NotApplied {
    /// It cannot run live.
    Live(LiveError),
    /// It was made with the sensor mounted otherwise: its axes are others.
    Mounting,
}

impl fmt::Display for NotApplied {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            NotApplied::Live(error) => error.fmt(f),
            NotApplied::Mounting => f.write_str("it was made with another mounting of the sensor"),
        }
    }
}

/// The recording's clock at power-up where all that goes by it are steps: what was attached stays attached, so that it is after the
/// last of them.
fn after_the_steps(record: &Record) -> Option<f64> {
    let mut latest: Option<f64> = None;
    for fitted in record.effects.iter() {
        if !fitted.effect.columns().into_iter().flatten().any(|column| column.name == TIME) {
            continue;
        }
        match fitted.effect.parts().parameter() {
            Some((Searched::At, at_s)) => latest = Some(latest.map_or(at_s, |known| known.max(at_s))),
            _ => return None,
        }
    }
    latest
}

/// A stored calibration at work.
#[derive(Debug, Clone)]
pub(super) struct Active {
    pub(super) record: Record,
    pub(super) slot: Slot,
    pub(super) live: Result<Live<f32>, NotApplied>,
    /// What the recording's clock shows when that of `live` is zero.
    origin_s: f64,
    /// What has to be added to the time since power-up to give the recording's clock; unknown until it is fed.
    clock_s: Option<f64>,
    /// Whether it is still right.
    pub(super) monitor: Monitor,
    /// What shows another offset.
    pub(super) rezero: Rezero,
    /// How the board turns, where it has no gyro, and how it did at the last sample.
    turning: TurningField,
    pub(super) turn_radps: Option<[f32; 3]>,
    /// The corrected field at the last sample, µT; `None` while an effect waits for its column.
    pub(super) corrected_ut: Option<[f32; 3]>,
}

impl Active {
    /// Not at work yet: that comes once it stands where it stays, so that the stack never carries both.
    fn new(slot: Slot, record: Record) -> Self {
        let field_ut = record.calibration.field_ut;
        // An error that is not known is taken for what a calibration is refused from.
        let error = record.predicted_error.share().unwrap_or(MAX_PREDICTED_ERROR);
        let monitor = Monitor::new(field_ut as f32, record.noise_ut as f32, (error * field_ut) as f32);
        Self {
            clock_s: after_the_steps(&record),
            record,
            slot,
            live: Err(NotApplied::Mounting),
            origin_s: 0.0,
            monitor,
            rezero: Rezero::new(),
            turning: TurningField::new(),
            turn_radps: None,
            corrected_ut: None,
        }
    }

    /// Puts a record in the place of the calibration in use, and to work there.
    pub(super) fn install(place: &mut Option<Self>, slot: Slot, record: &Record, axes: AxisMap) {
        Self::put_down(place, slot, record);
        if let Some(active) = place {
            active.put_to_work(axes);
        }
    }

    #[inline(never)]
    fn put_down(place: &mut Option<Self>, slot: Slot, record: &Record) {
        *place = Some(Self::new(slot, *record));
    }

    /// Makes the correction of the record. Apart, because it works on whole calibrations, of a kilobyte each.
    #[inline(never)]
    fn put_to_work(&mut self, axes: AxisMap) {
        if !self.record.axes.is_none_or(|recorded| recorded == axes) {
            return;
        }
        let calibration = self.own_clock();
        match Live::new(&calibration) {
            Ok(live) => self.live = Ok(live),
            Err(why) => self.live = Err(NotApplied::Live(why)),
        }
    }

    /// The calibration on the board's own clock, in single precision; the doubles leave the stack with this.
    #[inline(never)]
    fn own_clock(&mut self) -> ExtendedCalibration<f32> {
        let (calibration, origin_s) = self.record.extended().on_own_clock();
        self.origin_s = origin_s;
        calibration.cast()
    }

    /// The recording's clock, where it is known.
    pub(super) fn recording_s(&self, t_ms: u64) -> Option<f64> {
        self.clock_s.map(|clock_s| clock_s + t_ms as f64 / 1000.0)
    }

    /// The correction at this time, if it runs.
    pub(super) fn at(&mut self, t_ms: u64) -> Option<&Live<f32>> {
        let live = self.live.as_mut().ok()?;
        if live.needs_time() {
            let now_s = t_ms as f64 / 1000.0;
            live.advance(now_s + self.clock_s.map_or(0.0, |clock_s| clock_s - self.origin_s));
            if self.clock_s.is_none() {
                live.set(TIME, f32::NAN);
            }
        }
        Some(live)
    }

    /// Takes a sample, `None` for one out of range: how the board turns at it (by the gyro, or by the field if an effect needs it and there is
    /// no gyro), the corrected field, and whether the calibration is still right. `fresh_radps` is the gyro's rate unless it has been silent.
    pub(super) fn take(
        &mut self,
        t_ms: u64,
        measured_ut: Option<[f32; 3]>,
        motion: &Motion,
        fresh_radps: Option<[f32; 3]>,
    ) {
        self.corrected_ut = None;
        let Some(measured_ut) = measured_ut else { return };
        self.turn_radps = match (&self.live, motion.turn_radps) {
            (Ok(live), None) if live.needs_gyro() => self.turning.push(live.base().apply(measured_ut), t_ms),
            (_, by_gyro) => by_gyro,
        };
        let turn_radps = self.turn_radps;
        self.corrected_ut = self.at(t_ms).and_then(|live| live.apply(measured_ut, turn_radps).ok());
        if let Some(corrected_ut) = self.corrected_ut {
            self.monitor.push(t_ms, corrected_ut, motion.accel_mps2);
            self.rezero.push(t_ms, corrected_ut, fresh_radps);
        }
    }

    /// The columns that are outside the range that their effect was fitted over, as of the last
    /// [`Active::at`].
    pub(super) fn extrapolated(&self) -> impl Iterator<Item = Extrapolated<'_>> {
        let Self { record, live, origin_s, .. } = self;
        live.iter().flat_map(|live| live.outside()).filter_map(|outside| {
            Extrapolated::of(outside, *origin_s, record.effects.iter(), &record.calibration)
        })
    }

    /// Feeds a column; the time too. Says whether an effect reads it.
    pub(super) fn feed(&mut self, column: &str, value: f64, t_ms: u64) -> bool {
        if column == TIME {
            self.clock_s = Some(value - t_ms as f64 / 1000.0);
            return self.at(t_ms).is_some_and(|live| !live.slots(TIME).is_empty());
        }
        self.live.as_mut().is_ok_and(|live| live.set(column, value as f32))
    }
}
