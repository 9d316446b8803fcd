//! A magnet that passes beside an effect: what it disturbs is set aside, and the effect is found. In these logs the effect hides the
//! magnet from the base model (two humps, one on either side of where the magnitude does not see it), and the magnet the effect.

use crate::common::{folder, ironout, simulate, text};

#[test]
fn a_magnet_that_passes_hides_no_effect() {
    let here = folder("passes");
    for seed in ["7", "12", "16"] {
        let options = ["--seed", seed, "--seconds", "80", "--effect", "offset:temp_c=3", "--effect", "burst"];
        let log = simulate(&here, &format!("log{seed}.csv"), &options);
        let found = ironout(["diagnose", text(&log), "--json"]).json();
        let added: Vec<&str> = (found["steps"].as_array().expect("steps").iter())
            .filter_map(|step| step["added"].as_str())
            .collect();
        assert_eq!(added, ["offset:temp_c"], "{seed}: {found}");
        assert_eq!(found["verdict"], "missing", "{seed}: {found}");
        let faults = found["data_faults"].as_array().expect("faults");
        let [fault] = faults.as_slice() else { panic!("{seed}: {faults:?}") };
        let seconds = fault["to_s"].as_f64().expect("s") - fault["from_s"].as_f64().expect("s");
        assert!(fault["kind"] == "burst" && (0.5..2.0).contains(&seconds), "{seed}: {fault}");

        // The fit counts the same samples.
        let fit = ironout(["fit", text(&log), "--add", "offset:temp_c", "--json"]).json();
        assert_eq!(fit["accepted"], true, "{seed}: {}", fit["reasons"]);
        assert!(
            fit["samples_set_aside"].as_u64().is_some_and(|aside| (25..100).contains(&aside)),
            "{seed}: {fit}"
        );
        let counted = |one: &serde_json::Value| {
            ["samples_used", "samples_set_aside"]
                .map(|name| one[name].as_u64().expect("a number"))
                .iter()
                .sum::<u64>()
        };
        assert_eq!(counted(&fit), counted(&found), "{seed}");
        let (rms, floor) =
            (fit["rms_ut"].as_f64().expect("rms"), fit["residual_floor_ut"].as_f64().expect("floor"));
        assert!(rms < 1.03 * floor, "{seed}: {rms} of {floor}");
    }
}
