//! `stream log`: every sample with every column that is known, as a log is written.

use core::fmt;

use heapless::Vec;

use super::streamed::Sample;
use crate::effect::ColumnName;
use crate::number::Num;

/// The most columns beside the sensor's own.
pub(super) const LOG_COLUMNS: usize = 12;
/// The most characters of a line without further columns: `L`, a time and a number in full, three counts.
const BASE_BYTES: usize = 56;
/// The most characters of a value in single precision with its comma.
const VALUE_BYTES: usize = 16;
/// The most characters of a column's name with its comma.
const NAME_BYTES: usize = crate::effect::MAX_COLUMN_NAME + 1;

/// What a line of a log is made of beside the sample.
#[derive(Debug, Clone)]
pub(super) struct Log {
    columns: Vec<(ColumnName, f32), LOG_COLUMNS>,
    /// Whether the columns were named since they changed.
    named: bool,
}

impl Log {
    pub(super) const fn new() -> Self {
        Self { columns: Vec::new(), named: false }
    }

    /// A column is this from now on, NaN where it is not known; `false` where there is no room for another one, or its name would
    /// break the line.
    pub(super) fn feed(&mut self, name: &ColumnName, value: f32) -> bool {
        if name.as_str().contains([',', '"']) {
            return false;
        }
        if let Some((_, known)) = self.columns.iter_mut().find(|(known, _)| known == name) {
            *known = value;
            return true;
        }
        self.named = false;
        self.columns.push((*name, value)).is_ok()
    }

    /// The stream begins: its columns are named before the next line.
    pub(super) fn begin(&mut self) {
        self.named = false;
    }

    /// Room for the next line, and for the one that names the columns where that comes first.
    pub(super) fn line_bytes(&self) -> usize {
        let columns = self.columns.len();
        let line = BASE_BYTES + columns * VALUE_BYTES;
        if self.named { line } else { line + BASE_BYTES + columns * NAME_BYTES }
    }

    /// Writes a sample: `L,t_ms,seq,x,y,z` in counts, then the columns. `H,…` before it names them, once and whenever there
    /// are others.
    pub(super) fn write_line(&mut self, out: &mut impl fmt::Write, sample: &Sample) -> fmt::Result {
        if !self.named {
            out.write_str("H,t_ms,seq,x,y,z")?;
            self.columns.iter().try_for_each(|(name, _)| write!(out, ",{name}"))?;
            out.write_str("\n")?;
            self.named = true;
        }
        write!(out, "L,{},{}", sample.t_ms, sample.seq)?;
        match sample.measured_ut {
            Some(_) => sample.counts.iter().try_for_each(|count| write!(out, ",{count}"))?,
            // Out of the sensor's range: the counts are no measurement.
            None => out.write_str(",-,-,-")?,
        }
        self.columns.iter().try_for_each(|(_, value)| {
            if value.is_finite() { write!(out, ",{:?}", Num(*value)) } else { out.write_str(",-") }
        })?;
        out.write_str("\n")
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::{LOG_COLUMNS, Log, Sample};
    use crate::effect::ColumnName;
    use std::string::String;

    const SAMPLE: Sample = Sample {
        t_ms: 1260,
        seq: 63,
        counts: [-4096, 7, -300],
        measured_ut: Some([0.0; 3]),
        turn_radps: None,
        is_tilted: false,
    };

    fn lines(log: &mut Log, sample: &Sample) -> String {
        let mut out = String::new();
        let room = log.line_bytes();
        log.write_line(&mut out, sample).unwrap();
        assert!(out.len() <= room, "{out:?} takes {} of {room}", out.len());
        out
    }

    #[test]
    fn columns_are_named_once_and_again_when_there_are_more() {
        let mut log = Log::new();
        assert_eq!(lines(&mut log, &SAMPLE), "H,t_ms,seq,x,y,z\nL,1260,63,-4096,7,-300\n");
        assert_eq!(lines(&mut log, &SAMPLE), "L,1260,63,-4096,7,-300\n");
        let name = ColumnName::new("temp_c").unwrap();
        assert!(log.feed(&name, 31.5));
        assert_eq!(lines(&mut log, &SAMPLE), "H,t_ms,seq,x,y,z,temp_c\nL,1260,63,-4096,7,-300,31.5\n");
        assert!(log.feed(&name, f32::NAN));
        assert_eq!(lines(&mut log, &SAMPLE), "L,1260,63,-4096,7,-300,-\n");
        let out_of_range = Sample { measured_ut: None, ..SAMPLE };
        assert_eq!(lines(&mut log, &out_of_range), "L,1260,63,-,-,-,-\n");
    }

    #[test]
    fn the_longest_lines_fit_into_the_room_that_is_asked_for() {
        let mut log = Log::new();
        for i in 0..=LOG_COLUMNS {
            let name = std::format!("{i:x}23456789_123456789_123456789_12");
            let fed = log.feed(&ColumnName::new(&name).unwrap(), -f32::MIN_POSITIVE);
            assert_eq!(fed, i < LOG_COLUMNS);
        }
        let sample = Sample { t_ms: u64::MAX, seq: u32::MAX, counts: [i16::MIN; 3], ..SAMPLE };
        for value in [-1.234_567_8e-38, -f32::MAX, 0.1] {
            let _ = log.feed(&ColumnName::new("023456789_123456789_123456789_12").unwrap(), value);
            log.begin();
            lines(&mut log, &sample);
        }
    }
}
