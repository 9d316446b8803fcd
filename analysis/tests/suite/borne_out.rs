//! What a diagnosis claims, `fit` accepts and a correction with it bears out.

use ironout_analysis::calibration::EffectEntry;
use ironout_analysis::effects::calibrated;
use ironout_analysis::outcome::outcome::Verdict;
use ironout_analysis::{Options, Table, diagnose, fit, look_with};
use ironout_simulation::truths::{Kind, draw};

/// Logs apart from those that are tuned on and those that are measured.
const FAMILY: u64 = 0xb04e;

/// What is not the same within this share is not the same model.
const SAME: f64 = 0.02;

#[test]
fn what_is_named_is_accepted_by_fit_and_borne_out_by_a_correction() {
    let kinds = [(Kind::Strong, 4), (Kind::Several, 4), (Kind::One, 3), (Kind::OfAttitude, 2)];
    let (mut claims, mut named) = (0, 0);
    for (kind, number) in kinds.iter().flat_map(|(kind, logs)| (0..*logs).map(|number| (*kind, number))) {
        let drawn = draw(kind, FAMILY, number);
        let log = drawn.world.run();
        let table = Table::from_columns(log.named()).unwrap();
        let found = diagnose(&table, &Options { search: true, ..Options::default() }).unwrap();
        let add: Vec<String> = found.steps.iter().filter_map(|step| step.added.clone()).collect();
        let what =
            format!("{} {number} hidden {:?} named {add:?} {:?}", kind.name(), drawn.hidden, found.verdict);
        named += usize::from(!add.is_empty());
        if !matches!(found.verdict, Verdict::Complete | Verdict::Missing) {
            continue;
        }
        claims += 1;
        let fitted = fit(&table, &Options { add, ..Options::default() }).unwrap();
        assert!(fitted.accepted, "{what}: {:?}", fitted.reasons);
        let solution = fitted.solution.unwrap();
        let said = found.steps.last().unwrap().rms_ut;
        assert!((solution.rms_ut / said - 1.0).abs() < SAME, "{what}: {} and {said} µT", solution.rms_ut);
        let effects: Vec<EffectEntry> = solution.effects.iter().map(EffectEntry::from).collect();
        let whole = calibrated(solution.calibration, &effects, Options::default().registry).unwrap();
        let corrected = look_with(&table, whole).unwrap().1;
        assert!((corrected / said - 1.0).abs() < SAME, "{what}: corrected {corrected} µT, said {said} µT");
    }
    // Of thirteen logs, each with something hidden.
    assert!(named >= 11 && claims >= 9, "{named} named, {claims} claimed");
}
