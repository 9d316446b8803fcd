//! What `fit` and `diagnose` both stand on: which samples of a log count, and the base model of them.
//!
//! 1. a triple that repeats is one sample;
//! 2. faults of the data that show without a model are set aside (`samples::faults`);
//! 3. a resting board adds nothing (the core's gate);
//! 4. bursts that show in the residual of a first fit are set aside;
//! 5. the core's fit of what is left: exact sums for 16-bit counts, the board's bits;
//! 6. noise floor and number of independent samples from its residual (`base::quality`), and the held-out error;
//! 7. with an accelerometer, the rotation that magnitudes leave open, and how the sensor is mounted.
//!
//! The study of effects goes on from the same samples, and states this base as its first row.

use crate::base::counted::Counted;
use crate::base::model::Base;
use crate::bounds::{IN_SCALE_UT, TYPICAL_UT};
use crate::plausible::field::EARTH_UT;
use crate::reason::Reason;
use crate::table::Table;
use ironout::fit::{FitError, Method};

/// The samples of a log and their base model.
pub struct Ground<'a> {
    /// Which samples count.
    pub counted: Counted<'a>,
    /// The base model, or why there is none.
    pub base: Result<Base, FitError>,
    /// The magnitude of the measurements, µT, where the Earth's field nowhere has it.
    pub odd_field_ut: Option<f64>,
}

impl<'a> Ground<'a> {
    /// Of a log, fitted by `method` and scaled to `field_ut` (the mean of the log where unknown); `dip_deg` is that of the
    /// place, where it is known.
    pub fn of(table: &'a Table<'a>, method: Method, field_ut: Option<f64>, dip_deg: Option<f64>) -> Self {
        let lay = |unit: f64| {
            let counted = Counted::of(table, unit);
            let base = Base::of(&counted, method, field_ut, dip_deg);
            Ground { counted, base, odd_field_ut: None }
        };
        let ground = lay(1.0);
        let own_ut = ground.base.as_ref().ok().map(|base| base.solution.measured_field_ut);
        let beyond_scale = own_ut.filter(|field| !IN_SCALE_UT.contains(field));
        // No field of the Earth: the scale of the counts is not the true one, or --map took another unit.
        let odd_field_ut =
            own_ut.filter(|field| field_ut.is_none() && !EARTH_UT.contains(field)).or(beyond_scale);
        Ground { odd_field_ut, ..beyond_scale.map_or(ground, |odd| lay(TYPICAL_UT / odd)) }
    }

    /// What to know about the unit of the columns.
    pub fn note(&self) -> Option<Reason> {
        self.odd_field_ut.map(|field| {
            Reason::new("odd-field-strength", format!(
                "note: the measured magnitude is {field:.4} µT, but the Earth's field is 22 to 67 µT everywhere. Check the \
                 unit of the columns (1 gauss is 100 µT, 1000 nT are 1 µT) or --ut-per-count"
            ))
        })
    }
}
