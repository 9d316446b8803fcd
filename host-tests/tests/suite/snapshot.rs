//! Tables against their snapshots.

use ironout_host_tests::accuracy::snapshot::differences;

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
