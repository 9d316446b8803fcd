//! The JSON object of `diagnose`.

use crate::base::mounting::{AXIS_ORDER, DecidedBy};
use crate::blocks::blocks;
use crate::calibration::StdErrors;
use crate::noise::own::Colour;
use crate::outcome::outcome::{Diagnosis, NoiseRow};
use crate::reason::codes;
use ironout::calibration::Calibration;
use serde_json::{Map, Value, json};

/// A number, or null where it is unknown.
fn number(value: Option<f64>) -> Value {
    value.filter(|value| value.is_finite()).map_or(Value::Null, Value::from)
}

/// Ids of the effects with their coefficients, as `fit --json` has them.
pub fn effects(diagnosis: &Diagnosis) -> Value {
    diagnosis
        .effects
        .iter()
        .map(|effect| {
            let reference: Map<String, Value> = effect
                .reference
                .iter()
                .map(|(column, value)| (column.clone(), number(Some(*value))))
                .collect();
            let parameters: Map<String, Value> = effect
                .parameters
                .iter()
                .map(|(name, value)| ((*name).to_string(), number(Some(*value))))
                .collect();
            let range: Map<String, Value> =
                effect.range.iter().map(|(column, ends)| (column.clone(), json!(ends))).collect();
            json!({
                "id": effect.id, "name": effect.name, "columns": effect.columns,
                "coefficients": effect.coefficients,
                "std_errors": effect.std_errors.iter().map(|error| number(Some(*error))).collect::<Vec<_>>(),
                "unit": effect.unit, "reference": reference, "parameters": parameters, "range": range,
            })
        })
        .collect()
}

/// The colour of the noise that is left.
fn noise(row: NoiseRow) -> Value {
    let mut object = json!({
        "colour": row.colour.name(), "only_noise": row.is_noise, "misfit": number(Some(row.misfit)),
        "memory_samples": number(Some(row.memory_samples)),
    });
    let own = match row.colour {
        Colour::White => json!({}),
        Colour::Ar1(correlation) => json!({"correlation": correlation}),
        Colour::RollingMean { of, white } => json!({"samples": of, "white": white}),
        Colour::Flicker { exponent, white, .. } => json!({"exponent": exponent, "white": white}),
    };
    if let (Some(map), Some(own)) = (object.as_object_mut(), own.as_object()) {
        map.extend(own.clone());
    }
    object
}

/// The object of the contract.
pub fn object(diagnosis: &Diagnosis) -> Value {
    let steps: Vec<Value> = diagnosis
        .steps
        .iter()
        .map(|step| {
            json!({
                "added": step.added, "rms_ut": number(Some(step.rms_ut)),
                "holdout_rms_ut": number(step.holdout_rms_ut), "dip_rms_deg": number(step.dip_rms_deg),
            })
        })
        .collect();
    let candidates: Vec<Value> = diagnosis
        .candidates
        .iter()
        .map(|row| {
            let mut object = json!({
                "id": row.id, "name": row.name, "status": row.status.name(), "residual": row.residual,
                "holdout_rms_ut": number(row.holdout_rms_ut), "p_value": number(row.p_value),
                "confounded_with": row.confounded_with, "why": row.why,
            });
            if let (Some(takes), Some(map)) = (row.takes, object.as_object_mut()) {
                map.insert("takes".into(), number(Some(takes)));
            }
            if let (Some(angle), Some(map)) = (row.angle_deg, object.as_object_mut()) {
                map.insert("angle_deg".into(), number(Some(angle)));
            }
            if let (Some(order_status), true, Some(map)) =
                (diagnosis.order_status, row.id == AXIS_ORDER.id, object.as_object_mut())
            {
                let by = order_status.decided.ok().map(DecidedBy::name);
                map.insert("decided_by".into(), json!(by));
                if let Some(order) = order_status.swapped() {
                    map.insert("order".into(), order.to_string().into());
                    map.insert("rotate".into(), order.rotate().into());
                    map.insert("mirrored".into(), order.is_mirror().into());
                }
                if order_status.is_open() {
                    let other = order_status.order.opposite();
                    map.insert("or_order".into(), other.to_string().into());
                    map.insert("or_rotate".into(), other.rotate().into());
                }
            }
            object
        })
        .collect();
    let data_faults: Vec<Value> = diagnosis
        .data_faults
        .iter()
        .map(|fault| {
            json!({
                "kind": fault.kind.name(), "from_s": number(fault.from_s), "to_s": number(fault.to_s),
                "samples": fault.samples, "columns": fault.columns,
            })
        })
        .collect();
    let shows: Vec<Value> = diagnosis
        .shows
        .iter()
        .map(|one| json!({"against": one.against, "explained": number(Some(one.explained)), "p_value": number(Some(one.p_value))}))
        .collect();
    let mut object = json!({
        "verdict": diagnosis.verdict.name(),
        "reasons": diagnosis.reasons, "reason_codes": codes(&diagnosis.reasons),
        "residual": diagnosis.residual,
        "steps": steps,
        "noise_floor_ut": number(diagnosis.noise_floor_ut),
        "residual_floor_ut": number(diagnosis.residual_floor_ut),
        "residual_floor_least_ut": number(diagnosis.residual_floor_least_ut),
        "noise": diagnosis.noise.map(noise),
        "candidates": candidates,
        "data_faults": data_faults,
        "dip": diagnosis.dip.map(|dip| json!({
            "rms_deg_before": number(Some(dip.rms_deg_before)), "rms_deg_after": number(Some(dip.rms_deg_after)),
            "misalignment_deg": number(Some(dip.misalignment_deg)),
        })),
        "heading": diagnosis.heading.map(|heading| json!({
            "rms_deg_before": number(Some(heading.rms_deg_before)),
            "rms_deg_after": number(Some(heading.rms_deg_after)),
        })),
        "where": shows,
        "samples_used": diagnosis.samples_used,
        "samples_set_aside": diagnosis.samples_set_aside,
        "prior": diagnosis.prior,
        "lower_order": diagnosis.lower_order,
        "predicted_error_ut": number(diagnosis.vector_error_ut()),
    });
    if let Some(map) = object.as_object_mut() {
        map.insert("effects".into(), effects(diagnosis));
        if let Some(contradiction) = &diagnosis.contradiction {
            map.insert("contradiction".into(), json!(contradiction));
        }
        if let Some(recordings) = &diagnosis.recordings {
            map.insert("recordings".into(), json!(recordings));
        }
        if let Some(switching) = &diagnosis.switching {
            map.insert("switching".into(), json!(switching));
        }
        if let Some(levels) = &diagnosis.levels {
            map.insert("levels".into(), json!(levels));
        }
        if let Some(wander) = &diagnosis.wander {
            map.insert("wander".into(), json!(wander));
        }
        if let Some(pair) = &diagnosis.pair {
            map.insert("pair".into(), json!(pair));
        }
        let ids: Vec<&str> = diagnosis.effects.iter().map(|effect| effect.id.as_str()).collect();
        let blocks = blocks(&ids, diagnosis.registry);
        if !blocks.is_empty() {
            map.insert("blocks".into(), json!(blocks));
        }
        // With swapped axes the log is to be repaired first.
        let calibration = diagnosis.calibration.filter(|_| diagnosis.axis_order().is_none());
        let entry = |calibration: Calibration<f64>, std_errors: Option<&StdErrors>| {
            json!({
                "offset_ut": calibration.offset_ut, "matrix": calibration.matrix, "field_ut": calibration.field_ut,
                "std_errors": std_errors,
            })
        };
        let last = calibration.map(|calibration| entry(calibration, diagnosis.std_errors.as_ref()));
        map.insert("calibration".into(), last.unwrap_or(Value::Null));
        let base = diagnosis.base.as_ref().map(|base| {
            let mut object = entry(base.solution.calibration, Some(&base.solution.std_errors));
            if let Some(map) = object.as_object_mut() {
                map.insert("method".into(), base.method.name().into());
                let figures = [
                    ("rms_ut", Some(base.solution.rms_ut)),
                    ("holdout_rms_ut", base.holdout_rms_ut),
                    ("noise_floor_ut", Some(base.noise_floor_ut)),
                    ("residual_floor_ut", Some(base.residual_floor_ut)),
                    ("predicted_error_ut", Some(base.solution.vector_error_ut())),
                ];
                map.extend(figures.map(|(key, value)| (key.to_string(), number(value))));
            }
            object
        });
        map.insert("base".into(), base.unwrap_or(Value::Null));
    }
    object
}
