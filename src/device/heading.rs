//! The heading, by the console and for the lights.

use core::fmt;

use super::active::Active;
use super::light::Light;
use super::machine::Device;
use super::shown::Shown;
use crate::coverage::Seen;
use crate::heading::{NoHeading, heading_deg};
use crate::number::Num;
use crate::protocol::{Answered, Code, Reply};
use crate::session::State;

/// A heading is made of what was measured no longer ago than this.
const FRESH_MS: u64 = 1000;
/// How often the lights are told anew: a heading, a coverage.
const HEADING_MS: u64 = 100;
const COVERAGE_MS: u64 = 1000;

/// Why the console has no heading.
enum Missing {
    Calibration,
    Sample,
    Accelerometer,
    /// An effect waits for its column.
    Column,
    Geometry(NoHeading),
}

impl fmt::Display for Missing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Missing::Calibration => "there is no calibration in use: cal start",
            Missing::Sample => "no sample in range within one second",
            Missing::Accelerometer => {
                "the direction of gravity is unknown: cov ax_mps2=X ay_mps2=Y az_mps2=Z, at rest 9.81 upwards"
            }
            Missing::Column => "the calibration needs a column: status names it",
            Missing::Geometry(NoHeading::NotMeasured) => "field or acceleration is zero",
            Missing::Geometry(NoHeading::Steep) => "the x axis points up or down: hold it more level",
            Missing::Geometry(NoHeading::VerticalField) => "the field is vertical here",
        })
    }
}

impl Device {
    /// Has the coverage looked at while a calibration is collected, for [`Self::shown`]: once a second, as `status` does it. To be
    /// asked for where the board has the lights for it.
    pub const fn show_coverage(&mut self) {
        self.view.has_lights = true;
    }

    /// What the board's lights show at this time.
    pub fn shown(&mut self, now_ms: u64) -> Shown {
        let now_ms = self.steady(now_ms);
        let light = self.light();
        let seen = match &self.status {
            Some((_, status)) if light == Light::Collecting => status.seen,
            _ => Seen::default(),
        };
        let heading_deg = (self.view.has_lights && light == Light::Calibrated).then(|| {
            let (at_ms, heading_deg) = self.view.heading;
            if now_ms.saturating_sub(at_ms) < HEADING_MS && heading_deg.is_some() {
                return heading_deg;
            }
            let heading_deg = self.heading_now(now_ms).ok().map(|heading_deg| heading_deg as f32);
            self.view.heading = (now_ms, heading_deg);
            heading_deg
        });
        Shown { light, is_on: light.is_on(now_ms), seen, heading_deg: heading_deg.flatten() }
    }

    /// Looks at the coverage, where it is due. Whether it took a computation.
    #[inline(never)]
    pub(super) fn look_at_coverage(&mut self) -> bool {
        let is_old = self.status.is_none_or(|(t_ms, status)| {
            status.state != State::Collecting || self.now_ms.saturating_sub(t_ms) >= COVERAGE_MS
        });
        if !self.view.has_lights
            || self.session.state() != State::Collecting
            || !is_old
            || !self.may_compute(true)
        {
            return false;
        }
        self.compute_asked_ms = None;
        self.status = Some((self.now_ms, self.session.status()));
        true
    }

    fn heading_now(&mut self, now_ms: u64) -> Result<f64, Missing> {
        let (motion, turn_radps) = (self.learner_inputs.motion, self.turn_radps());
        let Some(Active { live: Ok(live), .. }) = &self.active else { return Err(Missing::Calibration) };
        let latest = self.view.latest.filter(|(t_ms, _)| now_ms.saturating_sub(*t_ms) <= FRESH_MS);
        let (_, measured_ut) = latest.ok_or(Missing::Sample)?;
        let force_mps2 = motion.accel_mps2.ok_or(Missing::Accelerometer)?;
        let corrected_ut = live.apply(measured_ut, turn_radps).map_err(|_| Missing::Column)?;
        heading_deg(corrected_ut.map(f64::from), force_mps2.map(f64::from), self.view.declination_deg)
            .map_err(Missing::Geometry)
    }

    /// `heading`, and with a number the declination from now on.
    #[inline(never)]
    pub(super) fn heading<W: fmt::Write>(
        &mut self,
        mut reply: Reply<'_, W>,
        declination_deg: Option<f64>,
    ) -> Answered {
        if let Some(declination_deg) = declination_deg {
            self.view.declination_deg = declination_deg;
        }
        match self.heading_now(self.now_ms) {
            Ok(heading_deg) => {
                // What would be rounded up to a whole turn is north.
                let heading_deg = if heading_deg < 359.95 { heading_deg } else { 0.0 };
                self.say_tilted(&mut reply);
                let (heading_deg, declination_deg) = (Num(heading_deg), Num(self.view.declination_deg));
                reply.ok(format_args!("heading_deg={heading_deg:.1} declination_deg={declination_deg:?}"))
            }
            Err(Missing::Sample) if self.sensor.fault().is_some() => {
                reply.err(Code::Sensor, format_args!("{}", Missing::Sample))
            }
            Err(missing) => reply.err(Code::State, format_args!("{missing}")),
        }
    }
}
