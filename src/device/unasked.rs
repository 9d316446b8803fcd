//! The console's commands about effects, in firmware without the study.

use core::fmt;

use super::machine::Device;
use super::name::Id;
use crate::effect::Effect;
use crate::protocol::{Answered, Code, EffectId, Reply};

const NO_STUDY: &str = "this firmware has no study of effects: record a log and run ironout diagnose";

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
