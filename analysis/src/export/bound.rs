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
            format!("TIED TO ITS LOG: {}", names.join(", ")),
            "depends on the clock of the recording it was fitted to, and is wrong on any".to_string(),
            "other. Offset and matrix stay correct. For a device, remove the cause and".to_string(),
            "export a calibration without it".to_string(),
        ]
    })
}
