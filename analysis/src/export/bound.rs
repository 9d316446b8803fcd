//! What cannot leave its log: effects that go by the time of the recording that they were fitted on.

use crate::effects::Calibrated;
use ironout::effect::Id;

/// What to know before such a calibration is used elsewhere, in lines; `None` where no effect is bound to its log.
pub fn warning(calibration: &Calibrated) -> Option<Vec<String>> {
    let bound = calibration.effects.iter().map(|fitted| &fitted.effect);
    let names: Vec<String> = bound
        .filter(|effect| effect.family().is_bound_to_its_log())
        .map(|effect| Id(effect).to_string())
        .collect();
    (!names.is_empty()).then(|| {
        vec![
            format!("BOUND TO ITS LOG: {}", names.join(", ")),
            "goes by the clock of the recording that it was fitted on, and is wrong on any".to_string(),
            "other. Offset and matrix hold; for a device find and remove the cause, and".to_string(),
            "export a calibration without it".to_string(),
        ]
    })
}
