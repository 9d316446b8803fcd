//! A log that a page holds: its columns, and how they were read.

use crate::failure::Outcome;
use crate::input::Log;
use crate::output::json_number;
use crate::page::asked::ReadAsked;
use crate::page::pack;
use crate::plausible::Known;
use crate::{read_block, source};
use serde_json::{Value, json};

/// A log and the options it was read with.
#[derive(Debug, Clone)]
pub struct Held {
    /// The log.
    pub log: Log,
    /// The options.
    pub asked: ReadAsked,
}

impl Held {
    /// Reads a log of any format.
    ///
    /// # Errors
    /// Those of the reading, as on the command line.
    pub fn read(asked: ReadAsked, bytes: &[u8], field_ut: Option<f64>) -> Outcome<Self> {
        let log = source::read_bytes(&asked.arguments(), bytes, &Known::given(field_ut))?;
        Ok(Held { log, asked })
    }

    /// The log as bytes that [`Held::unpack`] takes: its columns to the last bit, unless that would take too much room; what
    /// was rounded is said.
    pub fn pack(&self) -> (Vec<u8>, Vec<String>) {
        pack::pack(&self.log, &self.asked)
    }

    /// The log of such bytes.
    ///
    /// # Errors
    /// They are none.
    pub fn unpack(bytes: &[u8]) -> Outcome<Self> {
        let (log, asked) = pack::unpack(bytes)?;
        Ok(Held { log, asked })
    }

    /// What a page says of it.
    pub fn json(&self) -> Value {
        let log = &self.log;
        let seconds = log.time_s.as_ref().and_then(|t| Some(t.last()? - t.first()?));
        let names: Vec<&str> = log.covariates.iter().map(|column| column.name.as_str()).collect();
        json!({
            "name": log.path.display().to_string(), "rows": log.rows, "seconds": json_number(seconds),
            "covariates": names, "accelerometer": log.accel_mps2.is_some(), "gyro": log.gyro_radps.is_some(),
            "heading": log.heading_deg.is_some(), "notices": log.notices, "read_as": read_block::json(log),
            "read_words": read_block::text(log),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn held(csv: &str, ut_per_count: Option<&str>) -> Held {
        let asked = ReadAsked {
            name: "a.csv".into(),
            ut_per_count: ut_per_count.map(String::from),
            ..ReadAsked::default()
        };
        Held::read(asked, csv.as_bytes(), Some(50.0)).expect("a log")
    }

    #[test]
    fn a_log_comes_back_to_the_last_bit() {
        let mut csv = "t_s,mx_ut,my_ut,mz_ut,temp_c,odd\n".to_string();
        for i in 0..500 {
            let a = f64::from(i) * 0.1;
            let temp = if i % 7 == 0 { String::new() } else { format!("{:.2}", 20.0 - 3.0 * a) };
            csv += &format!(
                "{:.3},{:.3},{:.2},{},{temp},{}\n",
                a,
                50.0 * a.sin(),
                -40.0 * a.cos(),
                0.1 + a.sin(),
                a.exp()
            );
        }
        let log = held(&csv, None);
        let (bytes, rounded) = log.pack();
        assert!(rounded.is_empty());
        let again = Held::unpack(&bytes).expect("its own");
        assert_eq!(again.asked, log.asked);
        let same = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| a == b || (a.is_nan() && b.is_nan()));
        assert!(log.log.field_ut.iter().zip(&again.log.field_ut).all(|(a, b)| same(a, b)));
        for (a, b) in log.log.covariates.iter().zip(&again.log.covariates) {
            assert_eq!((&a.name, a.not_finite), (&b.name, b.not_finite));
            assert!(same(&a.values, &b.values), "{}", a.name);
        }
        assert_eq!(log.log.time_s, again.log.time_s);
        let counts: String =
            (0..200).map(|i| format!("{},{},{}\n", i * 3 - 300, 200 - i, (i * i) % 97)).collect();
        let log = held(&format!("mx_counts,my_counts,mz_counts\n{counts}"), Some("0.15,0.15,0.17"));
        let again = Held::unpack(&log.pack().0).expect("its own");
        assert_eq!((again.log.counts, again.log.field_ut), (log.log.counts, log.log.field_ut));
    }

    #[test]
    fn what_is_damaged_is_refused() {
        let log = held("mx_ut,my_ut,mz_ut\n1.5,2,3\n4,5,6\n30,40,-50\n", None);
        let (bytes, _) = log.pack();
        for end in 0..bytes.len() {
            assert!(Held::unpack(&bytes[..end]).is_err(), "{end}");
        }
        for at in 0..bytes.len() {
            let mut other = bytes.clone();
            other[at] ^= 0x55;
            // No panic; a number in it may be another one.
            let _ = Held::unpack(&other);
        }
    }
}
