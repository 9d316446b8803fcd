//! `check` where the log has a reference heading: a wrong heading is not good.

use crate::common::{calibrate, changed, folder, ironout, simulate, text, write};
use std::path::Path;

#[test]
fn a_wrong_heading_is_not_good() {
    let here = folder("check_heading");
    let log = simulate(&here, "log.csv", &["--seconds", "40", "--seed", "6"]);
    let cal = calibrate(&here, &log, &[]);
    let check = |log: &Path, more: &[&str]| {
        let run = ironout(["check", text(log), "--cal", text(&cal), "--json"].iter().chain(more));
        let object = run.json();
        assert_eq!(run.status, i32::from(object["good"] == false), "{object}");
        object
    };
    let good = check(&log, &[]);
    assert_eq!(good["verdict"], "good", "{good}");
    assert!(good["heading"]["rms_deg"].as_f64().is_some_and(|rms| rms < 2.0), "{good}");

    // The magnetometer mounted turned by 180° about the board's vertical: the magnitude is right, headings are wrong.
    let turned = changed(&here, &log, "turned.csv", |place, cells| {
        for name in ["mx_ut", "my_ut"] {
            let at = place(name);
            cells[at] = -cells[at];
        }
    });
    let other = here.join("turned.json");
    // Fitted without a heading and without an accelerometer it is accepted.
    let blind = changed(&here, &turned, "blind.csv", |_, _| {});
    let content =
        std::fs::read_to_string(&blind).expect("text").replacen("ax_mps2,ay_mps2,az_mps2", "p,q,r", 1);
    let blind = write(&here, "blind.csv", content);
    assert_eq!(ironout(["fit", text(&blind), "-o", text(&other)]).status, 0);
    let run = ironout(["check", text(&turned), "--cal", text(&other), "--json"]);
    let wrong = run.json();
    assert_eq!((run.status, &wrong["verdict"]), (1, &"heading".into()), "{wrong}");
    assert!(wrong["heading"]["mean_deg"].as_f64().is_some_and(|mean| mean.abs() > 170.0), "{wrong}");
    assert!(wrong["reasons"].to_string().contains("ironout diagnose"), "{wrong}");
    // All three axes reversed: every heading is reversed, at any attitude.
    let reversed = changed(&here, &log, "reversed.csv", |place, cells| {
        for name in ["mx_ut", "my_ut", "mz_ut"] {
            let at = place(name);
            cells[at] = -cells[at];
        }
    });
    let content =
        std::fs::read_to_string(&reversed).expect("text").replacen("ax_mps2,ay_mps2,az_mps2", "p,q,r", 1);
    let blind = write(&here, "blind.csv", content);
    assert_eq!(ironout(["fit", text(&blind), "-o", text(&here.join("reversed.json"))]).status, 0);
    let run = ironout(["check", text(&reversed), "--cal", text(&here.join("reversed.json")), "--json"]);
    let wrong = run.json();
    assert_eq!((run.status, &wrong["verdict"]), (1, &"heading".into()), "{wrong}");
    assert!(wrong["reasons"].to_string().contains("every heading is reversed"), "{wrong}");
    let words = ironout(["check", text(&turned), "--cal", text(&other)]).stdout;
    assert!(words.contains("HEADING:") && words.contains("heading off by"), "{words}");

    // A reference from true north is off by the declination, and says nothing against the calibration when that is given.
    let declined = changed(&here, &log, "declined.csv", |place, cells| {
        let at = place("heading_deg");
        cells[at] = (cells[at] + 12.0).rem_euclid(360.0);
    });
    let off = check(&declined, &[]);
    assert_eq!(off["verdict"], "heading", "{off}");
    assert!(off["heading"]["mean_deg"].as_f64().is_some_and(|mean| (mean + 12.0).abs() < 0.5), "{off}");
    assert!(off["reasons"].to_string().contains("--declination"), "{off}");
    assert_eq!(check(&declined, &["--declination", "12"])["verdict"], "good");
    assert_eq!(
        ironout(["check", text(&log), "--cal", text(&cal), "--declination", "500", "--json"]).status,
        2
    );

    // Without an accelerometer there is no heading, and that is said.
    let content =
        std::fs::read_to_string(&log).expect("text").replacen("ax_mps2,ay_mps2,az_mps2", "p,q,r", 1);
    let flat = write(&here, "flat.csv", content);
    let unlevelled = check(&flat, &[]);
    assert_eq!((&unlevelled["verdict"], &unlevelled["heading"]), (&"good".into(), &serde_json::Value::Null));
    assert!(unlevelled["reasons"].to_string().contains("the log has no accelerometer"), "{unlevelled}");
}
