//! Tables against their snapshots, and in the documents.

use ironout_host_tests::accuracy::snapshot::{between_markers, differences};

#[test]
fn a_changed_figure_shows_and_a_last_digit_does_not() {
    let stored = "cap 167 | 1.07 100%\nrings 5 | 11.82*\n";
    assert!(differences(stored, stored).is_empty());
    assert!(differences(stored, "cap 167 | 1.08 100%\nrings 5 | 11.90*\n").is_empty());
    for worse in [
        "cap 168 | 1.07 100%\nrings 5 | 11.82*\n",
        "cap 167 | 1.11 100%\nrings 5 | 11.82*\n",
        "cap 167 | 1.07 95%\nrings 5 | 11.82*\n",
        "cap 167 | 1.07 100%\nrings 5 | 11.82\n",
        "cap 167 | 1.07 100%\nrings 5 | refused*\n",
        "cap 167 | 1.07 100%\n",
        "cap 167 | NaN 100%\nrings 5 | 11.82*\n",
    ] {
        assert_eq!(differences(stored, worse).len(), 1, "{worse}");
    }
}

#[test]
fn a_table_goes_between_its_markers() {
    let readme = "a\n<!-- t:begin -->\nold\n<!-- t:end -->\nb\n";
    let changed = between_markers(readme, "t", "new\n").expect("it has the markers");
    assert_eq!(changed, "a\n<!-- t:begin -->\nnew\n<!-- t:end -->\nb\n");
    assert_eq!(between_markers(readme, "u", ""), None);
}
