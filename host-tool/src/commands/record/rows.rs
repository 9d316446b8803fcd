//! From the lines of a stream to the rows of a log: µT, one clock, and what was lost.

use crate::board::{Columns, Row};
use std::io::{self, Write};

/// What came and what did not.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Tally {
    /// Rows.
    pub samples: u64,
    /// Samples that the board took or should have taken, and that did not arrive.
    pub lost: u64,
    /// Samples out of the sensor's range, which are not rows.
    pub out_of_range: u64,
    /// Restarts of the board.
    pub restarts: u32,
    /// Time from the first to the last sample, ms.
    pub length_ms: u64,
}

/// The columns that a log has itself.
const OWN: [&str; 6] = ["t_s", "t_us", "mx_ut", "my_ut", "mz_ut", "heading_deg"];

/// The sample before.
#[derive(Debug, Clone, Copy)]
struct Last {
    t_ms: u64,
    seq: u32,
}

/// Makes rows.
#[derive(Debug)]
pub struct Rows {
    ut_per_count: [f64; 3],
    /// Every column that there was, in the order in which they came.
    names: Vec<String>,
    /// Where the values of a line belong.
    places: Vec<usize>,
    last: Option<Last>,
    first_ms: Option<u64>,
    /// What is added to the board's clock, which begins again at every restart.
    offset_ms: u64,
    tally: Tally,
}

impl Rows {
    /// Of a board with this scale.
    pub fn new(ut_per_count: [f64; 3]) -> Self {
        Rows {
            ut_per_count,
            names: Vec::new(),
            places: Vec::new(),
            last: None,
            first_ms: None,
            offset_ms: 0,
            tally: Tally::default(),
        }
    }

    /// What came so far.
    pub fn tally(&self) -> Tally {
        self.tally
    }

    /// The columns behind the field so far. A board's column that has the name of one of the log's own keeps it behind `board_`.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The columns of the lines to come.
    pub fn columns(&mut self, columns: Columns) {
        self.places.clear();
        for name in columns.0 {
            let name = if OWN.contains(&name.as_str()) { format!("board_{name}") } else { name };
            let place = self.names.iter().position(|known| *known == name).unwrap_or_else(|| {
                self.names.push(name);
                self.names.len() - 1
            });
            self.places.push(place);
        }
    }

    /// Writes a sample; one that does not follow on the last has a comment before it. `away_ms` is how long ago the last one
    /// came by this computer's clock: all that is known of the time that a board was off.
    pub fn row(&mut self, row: &Row, away_ms: u64, out: &mut impl Write) -> io::Result<()> {
        if row.values.len() != self.places.len() {
            // A line that was cut, or whose columns were never named: it is missed by its number.
            return Ok(());
        }
        if let Some(last) = self.last {
            let step = row.seq.wrapping_sub(last.seq);
            if row.t_ms < last.t_ms || step == 0 || step > u32::MAX / 2 {
                self.tally.restarts += 1;
                let away_ms = away_ms.max(1);
                self.offset_ms = (self.offset_ms + last.t_ms + away_ms).saturating_sub(row.t_ms);
                writeln!(
                    out,
                    "# the board restarted: its clock restarted, {:.3} s after the last sample by the recorder's clock",
                    away_ms as f64 / 1000.0
                )?;
            } else if step > 1 {
                self.tally.lost += u64::from(step - 1);
                writeln!(out, "# lost {} samples", step - 1)?;
            }
        }
        self.last = Some(Last { t_ms: row.t_ms, seq: row.seq });
        let t_ms = row.t_ms + self.offset_ms;
        let first_ms = *self.first_ms.get_or_insert(t_ms);
        self.tally.length_ms = t_ms - first_ms.min(t_ms);
        let Some(counts) = row.counts else {
            self.tally.out_of_range += 1;
            return Ok(());
        };
        self.tally.samples += 1;
        write!(out, "{}.{:03}", t_ms / 1000, t_ms % 1000)?;
        for (count, scale) in counts.into_iter().zip(self.ut_per_count) {
            write!(out, ",{}", f64::from(count) * scale)?;
        }
        for place in 0..self.names.len() {
            let value = self.places.iter().position(|at| *at == place).and_then(|at| row.values.get(at));
            write!(out, ",{}", value.and_then(|value| value.as_deref()).unwrap_or_default())?;
        }
        writeln!(out)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(t_ms: u64, seq: u32, values: &[&str]) -> Row {
        let values = values.iter().map(|value| (*value != "-").then(|| value.to_string())).collect();
        Row { t_ms, seq, counts: Some([10, -20, 0]), values }
    }

    fn columns(names: &[&str]) -> Columns {
        Columns(names.iter().map(|name| name.to_string()).collect())
    }

    #[test]
    fn rows_are_in_microtesla_with_gaps_marked_and_columns_in_their_places() {
        let mut rows = Rows::new([0.5, 0.25, 1.0]);
        let mut out = Vec::new();
        rows.columns(columns(&[]));
        rows.row(&row(1260, 63, &[]), 0, &mut out).unwrap();
        rows.columns(columns(&["temp_c", "t_s"]));
        rows.row(&row(1280, 64, &["31.5", "2"]), 20, &mut out).unwrap();
        rows.row(&row(1380, 69, &["-", "2"]), 100, &mut out).unwrap();
        rows.row(&Row { counts: None, ..row(1400, 70, &["31", "2"]) }, 20, &mut out).unwrap();
        // Cut on its way: as good as lost.
        rows.row(&row(1420, 71, &["31"]), 20, &mut out).unwrap();
        // The other way round after a reconnection.
        rows.columns(columns(&["t_s", "temp_c"]));
        rows.row(&row(1440, 72, &["3", "30"]), 20, &mut out).unwrap();
        assert_eq!(
            String::from_utf8(out).unwrap(),
            "1.260,5,-5,0\n1.280,5,-5,0,31.5,2\n# lost 4 samples\n1.380,5,-5,0,,2\n# lost 1 samples\n1.440,5,-5,0,30,3\n"
        );
        assert_eq!(rows.names(), ["temp_c", "board_t_s"]);
        let tally = rows.tally();
        assert_eq!((tally.samples, tally.lost, tally.out_of_range, tally.length_ms), (4, 5, 1, 180));
    }

    #[test]
    fn the_time_goes_on_over_a_restart_of_the_board() {
        let mut rows = Rows::new([1.0; 3]);
        let mut out = Vec::new();
        for (t_ms, seq, away_ms) in
            [(5000, 250, 0), (5020, 251, 20), (100, 5, 3000), (120, 6, 20), (60, 3, 0)]
        {
            rows.row(&row(t_ms, seq, &[]), away_ms, &mut out).unwrap();
        }
        let text = String::from_utf8(out).unwrap();
        let times: Vec<f64> = text
            .lines()
            .filter(|line| !line.starts_with('#'))
            .map(|line| line.split(',').next().unwrap().parse().unwrap())
            .collect();
        assert_eq!(times, [5.0, 5.02, 8.02, 8.04, 8.041]);
        assert_eq!((rows.tally().restarts, rows.tally().lost), (2, 0));
    }
}
