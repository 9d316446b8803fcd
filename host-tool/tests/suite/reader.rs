//! The readers take any bytes: they give what is sound or an error with words, and never panic.

use ironout_cli::cal_file::CalFile;
use ironout_cli::input::{ReadOptions, read_stream};
use proptest::prelude::*;

fn read(bytes: &[u8], options: &ReadOptions) {
    match read_stream(bytes, bytes.len() as u64, options) {
        Ok(log) => {
            assert!(log.rows > 0);
            assert!(log.field_ut.iter().all(|column| column.len() == log.rows));
            assert!(log.field_ut.iter().flatten().all(|value| value.is_finite()));
            assert!(log.covariates.iter().all(|covariate| covariate.values.len() == log.rows));
            if let Some(time) = &log.time_s {
                assert!(time.len() == log.rows && time.windows(2).all(|pair| pair[0] <= pair[1]));
            }
        }
        Err(failure) => assert!(failure.message.len() > 10 && failure.exit == 2, "{failure:?}"),
    }
}

fn cell() -> impl Strategy<Value = String> {
    prop_oneof![
        6 => (-5000_i32..5000).prop_map(|v| format!("{}", f64::from(v) / 16.0)),
        1 => Just(String::new()),
        1 => "[ -~]{0,6}",
        1 => prop_oneof![Just("NaN".to_string()), Just("inf".into()), Just("1e400".into()), Just("\"1\"".into()), Just("-".into())],
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_bytes(bytes in proptest::collection::vec(any::<u8>(), 0..600)) {
        read(&bytes, &ReadOptions::default());
    }

    #[test]
    fn bytes_below_a_good_header(bytes in proptest::collection::vec(any::<u8>(), 0..400), scale in any::<bool>()) {
        let mut log = if scale { b"t_us,mx_counts,my_counts,mz_counts,temp_c\n".to_vec() } else { b"t_s,mx_ut,my_ut,mz_ut,temp_c\n".to_vec() };
        log.extend(bytes);
        read(&log, &ReadOptions { ut_per_count: scale.then_some([0.1; 3]), ..ReadOptions::default() });
    }

    #[test]
    fn rows_of_nearly_good_cells(rows in proptest::collection::vec(proptest::collection::vec(cell(), 4..=6), 0..30), end in prop_oneof![Just("\n"), Just("\r\n")]) {
        let mut text = String::from("mx_ut,my_ut,mz_ut,note,ax_mps2");
        text.push_str(end);
        for row in rows {
            text.push_str(&row.join(","));
            text.push_str(end);
        }
        read(text.as_bytes(), &ReadOptions::default());
    }

    #[test]
    fn any_header(header in "[ -~]{0,80}", row in "[ -~]{0,80}") {
        read(format!("{header}\n{row}\n").as_bytes(), &ReadOptions::default());
    }

    #[test]
    fn any_calibration_text(text in "[ -~\n]{0,200}") {
        prop_assert!(CalFile::parse(&text).is_err());
    }

    /// A good file with a few bytes changed: still good, or an error; what is read is always sound.
    #[test]
    fn a_damaged_calibration(damage in proptest::collection::vec((any::<proptest::sample::Index>(), "[ -~]"), 1..4)) {
        let mut bytes = include_bytes!("../fixtures/cal.json").to_vec();
        for (place, byte) in damage {
            let place = place.index(bytes.len());
            bytes[place] = byte.as_bytes()[0];
        }
        if let Ok(cal) = CalFile::parse(&String::from_utf8_lossy(&bytes)) {
            let calibration = cal.calibration().expect("checked when it was read");
            prop_assert!(calibration.is_sound());
            prop_assert!(calibration.apply([10.0, -20.0, 30.0]).iter().all(|value| value.is_finite()));
        }
    }
}
