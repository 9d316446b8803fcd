//! A diagnosis that says nothing yet, with the candidates that the log does not allow.

use crate::base::axes::Alignment;
use crate::outcome::outcome::{CandidateRow, Diagnosis, Status, Verdict};
use crate::reason::Reason;
use crate::residual::traces::Traces;
use crate::samples::samples::Samples;
use crate::search::candidates::{Catalogue, Untestable};
use crate::table::Table;
use ironout::effect::Registry;
use ironout::study::Residual;

pub(crate) fn undetermined(table: &Table, samples: &Samples, registry: Registry, why: Reason) -> Diagnosis {
    let catalogue = Catalogue::new(samples, table, registry);
    Diagnosis {
        verdict: Verdict::Undetermined,
        reasons: vec![why],
        residual: Residual::Magnitude.name(),
        steps: Vec::new(),
        noise_floor_ut: None,
        residual_floor_ut: None,
        residual_floor_least_ut: None,
        noise: None,
        candidates: untestable(&catalogue),
        data_faults: Vec::new(),
        dip: None,
        heading: None,
        shows: Vec::new(),
        effects: Vec::new(),
        calibration: None,
        std_errors: None,
        alignment: Alignment::None,
        order_status: None,
        information: None,
        converged: true,
        base: None,
        predicted_error_ut: None,
        rotation_error_rad: 0.0,
        field_varies: None,
        fit_refuses: None,
        only_unsure: false,
        chances: Vec::new(),
        has_attitude: false,
        samples_used: 0,
        samples_set_aside: 0,
        prior: String::new(),
        contradiction: None,
        recordings: None,
        switching: None,
        levels: None,
        pair: None,
        wander: None,
        lower_order: false,
        shown: Vec::new(),
        traces: Traces::default(),
        registry,
    }
}

pub(crate) fn untestable(catalogue: &Catalogue) -> Vec<CandidateRow> {
    let row = |one: Untestable| {
        let residual = if one.in_dip { Residual::Dip } else { Residual::Magnitude };
        CandidateRow::new(&one.id, &one.name, Status::Untestable, residual, one.why)
    };
    catalogue.untestable().into_iter().map(row).collect()
}
