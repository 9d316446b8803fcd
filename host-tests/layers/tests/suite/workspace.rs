//! The workspace is in order.

use std::path::Path;

#[test]
fn no_circles_and_arrows_only_run_down() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().unwrap();
    let report = ironout_layers::check_workspace(&root).unwrap();
    print!("{report}");
    // Guards against having looked at nothing.
    assert!(report.crates > 8 && report.files > 300 && report.imports > 600 && report.rooms > 60, "{report}");
    assert!(report.findings.is_empty(), "\n{report}");
}
