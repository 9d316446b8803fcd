//! What a build without Parquet says of it.

use crate::common::{folder, ironout, text, write};

#[test]
fn a_build_without_parquet_says_how_to_get_it() {
    let here = folder("columnar_not_built");
    for (mark, name) in [(&b"PAR1\x15\x04"[..], "a Parquet file"), (b"ARROW1\0\0", "an Arrow (Feather) file")]
    {
        let file = write(&here, "log.parquet", mark);
        let message =
            ironout(["fit", text(&file), "--json"]).error()["message"].as_str().expect("words").to_string();
        assert!(message.contains(name) && message.contains("--features parquet"), "{message}");
    }
    let log = write(&here, "a.csv", "t_s,mx_ut,my_ut,mz_ut\n0,1,2,3\n");
    let error = ironout(["batch", text(&log), "-o", text(&here.join("fleet.parquet")), "--json"]).error();
    assert!(error["message"].as_str().expect("words").contains("--features parquet"), "{error}");
}
