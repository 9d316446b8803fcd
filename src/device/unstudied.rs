//! A device without the study: it keeps the values of columns for the calibrations to come, and says where the question is answered.

use core::fmt;

use heapless::Vec;

use super::machine::Device;
use super::name::Id;
use crate::calibration::Calibration;
use crate::effect::{ColumnName, Effect};
use crate::protocol::{Answered, Code, EffectId, Reply};

/// Columns whose values are kept.
pub(in crate::device) const MAX_TESTED: usize = 3;

const NO_STUDY: &str = "this firmware has no study of effects: record a log and run ironout diagnose";

/// What becomes of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Fed {
    /// It is tested; without the study none is.
    #[allow(dead_code)]
    Tested,
    /// It is not.
    Not,
}

/// What accelerometer and gyro say, in the board's axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Motion {
    pub(super) accel_mps2: Option<[f32; 3]>,
    pub(super) turn_radps: Option<[f32; 3]>,
}

impl Motion {
    pub(super) const UNKNOWN: Self = Self { accel_mps2: None, turn_radps: None };
}

/// No question is ever under way.
#[derive(Debug, Clone)]
pub(super) enum Question {}

/// The columns' values.
#[derive(Debug, Clone)]
pub(super) struct Learner(Vec<(ColumnName, f32), MAX_TESTED>);

impl Learner {
    pub(super) const fn new() -> Self {
        Self(Vec::new())
    }

    pub(super) fn begin(&mut self, _: &Calibration<f64>) {}

    pub(super) fn begin_again(&mut self) {}

    pub(super) fn begin_anew(&mut self) {
        self.0.clear();
    }

    pub(super) fn field_ut(&self) -> Option<f64> {
        None
    }

    pub(super) fn feed(&mut self, name: &ColumnName, value: f32) -> Fed {
        match self.0.iter_mut().find(|(known, _)| known == name) {
            Some((_, kept)) => *kept = value,
            // Where there is no room, the calibration in use gets the value all the same.
            None => {
                let _ = self.0.push((*name, value));
            }
        }
        Fed::Not
    }

    pub(super) fn drop_column(&mut self, name: &str) {
        self.0.retain(|(known, _)| known.as_str() != name);
    }

    pub(super) fn tested(&self) -> impl Iterator<Item = &str> {
        self.0.iter().map(|(name, _)| name.as_str())
    }

    pub(super) fn value(&self, name: &str) -> Option<f32> {
        self.0.iter().find(|(known, _)| known.as_str() == name).map(|(_, value)| *value)
    }
}

impl Device {
    pub(super) fn why<W: fmt::Write>(&mut self, reply: Reply<'_, W>) -> Option<Answered> {
        Some(reply.err(Code::State, format_args!("{NO_STUDY}")))
    }

    pub(super) fn effect_add<W: fmt::Write>(&mut self, reply: Reply<'_, W>, _: EffectId) -> Option<Answered> {
        self.why(reply)
    }

    pub(super) fn effect_remove<W: fmt::Write>(
        &mut self,
        reply: Reply<'_, W>,
        _: &EffectId,
    ) -> Option<Answered> {
        self.why(reply)
    }

    /// What the calibration in use carries.
    #[inline(never)]
    pub(super) fn effect_list<W: fmt::Write>(&self, mut reply: Reply<'_, W>) -> Answered {
        let in_use = || self.active.iter().flat_map(|active| active.record.effects.iter());
        for fitted in in_use() {
            reply.line(format_args!(
                "effect id={} state=in-use name={}",
                Id(&fitted.effect),
                Effect::<f64>::name(&fitted.effect)
            ));
        }
        reply.ok(format_args!("in_use={}", in_use().count()))
    }
}
