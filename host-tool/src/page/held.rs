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
        pack::pack(self)
    }

    /// The log of such bytes.
    ///
    /// # Errors
    /// They are none.
    pub fn unpack(bytes: &[u8]) -> Outcome<Self> {
        pack::unpack(bytes)
    }

    /// What a page says of it.
    pub fn json(&self) -> Value {
        let log = &self.log;
        let seconds = log.time_s.as_ref().and_then(|t| Some(t.last()? - t.first()?));
        let names: Vec<&str> = log.covariates.iter().map(|column| column.name.as_str()).collect();
        json!({
            "name": log.path.display().to_string(), "rows": log.rows, "seconds": json_number(seconds),
            "covariates": names, "accelerometer": log.accel_mps2.is_some(), "gyro": log.gyro_radps.is_some(),
            "heading": log.heading_deg.is_some(), "notices": log.notices, "read_as": read_block::json(&log.read_as),
            "read_words": read_block::text(log),
        })
    }
}
