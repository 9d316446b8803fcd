//! The columns that effects may follow: fed with `cov`, or measured by the board itself.

use core::fmt;

use heapless::Vec;

use super::learn::{ACCEL, TURN};
use super::machine::Device;
use super::own::{MAX_OWN, Origin, OwnColumns};
use super::study::MAX_TESTED;
use crate::effect::{ColumnName, TIME};
use crate::number::Num;
use crate::protocol::{Answered, Assigned, Assignments, Code, Reply};

const _: () = assert!(MAX_TESTED <= MAX_OWN, "there is room for the names of all that are tested");

impl Device {
    /// Takes what the board itself measures beside field and motion: its processor's temperature, the voltage at a pin. Effects in use
    /// that follow it get it. It is tested where `cov NAME=on` asks for that; of a sensor without a temperature of its own, that of the
    /// processor (`cpu_temp_c`) is so from the start. What is fed by `cov NAME=VALUE` stands before it.
    ///
    /// A name that is none, or one too many, is not taken.
    pub fn on_own_column(&mut self, name: &str, value: f32, origin: Origin) {
        if !value.is_finite() {
            return;
        }
        let no_temperature = self.learner_inputs.no_temperature;
        let Some((name, is_tested)) = self.learner_inputs.own.measured(name, value, no_temperature) else {
            return;
        };
        if is_tested {
            self.feed(&name, Some(f64::from(value)));
            return;
        }
        let now_ms = self.now_ms;
        let used =
            self.active.as_mut().is_some_and(|active| active.feed(name.as_str(), f64::from(value), now_ms));
        if used || origin == Origin::Inside {
            let _ = self.log.feed(&name, value);
        }
    }

    /// `cov`: all columns of the line, or none.
    #[inline(never)]
    pub(super) fn cov<W: fmt::Write>(&mut self, reply: Reply<'_, W>, list: &Assignments) -> Answered {
        let learner = &self.learner_inputs.learner;
        let is_read = |name: &ColumnName| {
            let live = self.active.as_ref().and_then(|active| active.live.as_ref().ok());
            live.is_some_and(|live| !live.slots(name.as_str()).is_empty())
        };
        let own = &self.learner_inputs.own;
        let foreign = |(name, value): &&(ColumnName, Assigned)| {
            *value == Assigned::Own && own.value(name.as_str()).is_none()
        };
        if let Some((name, _)) = list.iter().find(foreign) {
            return reply.err(
                Code::State,
                format_args!(
                    "the board does not measure {name}; it measures: {}",
                    Names(own.names().collect())
                ),
            );
        }
        let fixed = |name: &str| name == TIME || ACCEL.contains(&name) || TURN.contains(&name);
        let is_new = |name: &ColumnName| !fixed(name.as_str()) && learner.value(name.as_str()).is_none();
        let is_forgotten = |value: &Assigned| *value == Assigned::Forgotten;
        let forgotten = list.iter().filter(|(name, value)| is_forgotten(value) && !is_new(name)).count();
        let known = learner.tested().count() - forgotten.min(learner.tested().count());
        let comes = |(name, value): &&(ColumnName, Assigned)| match value {
            Assigned::Forgotten => false,
            Assigned::Own => is_new(name),
            Assigned::Value(_) => is_new(name) && !is_read(name),
        };
        let new = list.iter().filter(comes).count();
        if known + new > MAX_TESTED {
            let tested = Names(learner.tested().collect());
            return reply.err(
                Code::State,
                format_args!(
                    "no room: {MAX_TESTED} columns are tested at the same time ({tested}); forget one first with cov NAME=-"
                ),
            );
        }
        // What is forgotten makes room.
        let order = list.iter().filter(|(_, value)| is_forgotten(value));
        let order = order.chain(list.iter().filter(|(_, value)| !is_forgotten(value)));
        let (mut used, mut tested) = (0, 0);
        for (name, value) in order {
            self.learner_inputs.own.assign(name.as_str(), *value);
            let value = match value {
                Assigned::Value(value) => Some(*value),
                Assigned::Forgotten => None,
                Assigned::Own => self.learner_inputs.own.value(name.as_str()).map(f64::from),
            };
            let (is_used, is_tested) = self.feed(name, value);
            used += u8::from(is_used);
            tested += u8::from(is_tested);
        }
        reply.ok(format_args!("{} used={used} tested={tested}", Shown(list, &self.learner_inputs.own)))
    }
}

/// Names, separated by commas.
struct Names<'a>(Vec<&'a str, MAX_OWN>);

impl fmt::Display for Names<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, name) in self.0.iter().enumerate() {
            f.write_str(if index == 0 { "" } else { ", " })?;
            f.write_str(name)?;
        }
        Ok(())
    }
}

/// The columns of a line, as they were understood.
struct Shown<'a>(&'a Assignments, &'a OwnColumns);

impl fmt::Display for Shown<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, (name, value)) in self.0.iter().enumerate() {
            f.write_str(if index == 0 { "" } else { " " })?;
            match (value, self.1.value(name.as_str())) {
                (Assigned::Value(value), _) => write!(f, "{name}={:?}", Num(*value))?,
                (Assigned::Own, Some(value)) => write!(f, "{name}={:?}", Num(f64::from(value)))?,
                (Assigned::Forgotten | Assigned::Own, _) => write!(f, "{name}=-")?,
            }
        }
        Ok(())
    }
}
