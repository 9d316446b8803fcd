//! Recordings with optical truth: what is accepted holds.

use ironout_host_tests::accuracy::optical::{folder, rows, text};
use std::io::Write;

#[test]
fn an_accepted_calibration_turns_no_axes_and_its_heading_holds() {
    let Some(folder) = folder() else {
        // Written directly: the test harness swallows eprintln!.
        let _ = writeln!(std::io::stderr(), "SKIPPED: the recordings with optical truth are not here");
        return;
    };
    let rows = rows(&folder);
    println!("{}", text(&rows));
    rows.iter().for_each(|row| println!("{}: {}", row.name, row.reasons.join("; ")));
    assert!(rows.len() >= 8, "{}", text(&rows));
    for row in rows.iter().filter(|row| row.accepted) {
        // The optical frame says 1 to 2 degrees; the accelerometer alone had turned two of them by 17 and 20, with headings off by 29 and 55.
        assert!(row.rotation_deg.is_none_or(|deg| deg < 4.5), "{row:?}");
        assert!(row.heading_deg < 4.0 * row.predicted_heading_deg, "{row:?}");
    }
}
