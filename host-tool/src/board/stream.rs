//! The lines of `stream log`: what the columns are, and one sample a line.

use ironout::effect::MAX_COLUMN_NAME;

/// The columns that every line has: time, number, and three counts.
const FIXED: [&str; 5] = ["t_ms", "seq", "x", "y", "z"];

/// What the columns behind the counts are called, from an `H` line.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Columns(pub Vec<String>);

/// One sample.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Time since the board's power-up, ms.
    pub t_ms: u64,
    /// Its number since then, lost ones counted.
    pub seq: u32,
    /// Counts in the board's axes; `None` where the field was out of the sensor's range.
    pub counts: Option<[i16; 3]>,
    /// The columns' values as the board wrote them; `None` where it does not know.
    pub values: Vec<Option<String>>,
}

/// A line of the stream.
#[derive(Debug, Clone, PartialEq)]
pub enum Streamed {
    /// `H,…`
    Columns(Columns),
    /// `L,…`
    Row(Row),
}

impl Streamed {
    /// Reads one line; `None` where it is of another stream, or was cut on its way.
    pub fn parse(line: &str) -> Option<Self> {
        let mut words = line.split(',');
        match words.next()? {
            "H" => {
                let names: Vec<&str> = words.collect();
                let own = names.get(..FIXED.len()).filter(|fixed| **fixed == FIXED);
                own?;
                let names = names.get(FIXED.len()..)?;
                let sound = |name: &&str| (1..=MAX_COLUMN_NAME).contains(&name.len());
                names
                    .iter()
                    .all(sound)
                    .then(|| Streamed::Columns(Columns(names.iter().map(|name| name.to_string()).collect())))
            }
            "L" => {
                let t_ms = words.next()?.parse().ok()?;
                let seq = words.next()?.parse().ok()?;
                let counts = match [words.next()?, words.next()?, words.next()?] {
                    ["-", "-", "-"] => None,
                    [x, y, z] => Some([x.parse().ok()?, y.parse().ok()?, z.parse().ok()?]),
                };
                let values = words.map(value).collect::<Option<_>>()?;
                Some(Streamed::Row(Row { t_ms, seq, counts, values }))
            }
            _ => None,
        }
    }
}

/// A number as it stands, or a dash; `None` for anything else.
fn value(word: &str) -> Option<Option<String>> {
    if word == "-" {
        return Some(None);
    }
    let finite = word.parse::<f64>().is_ok_and(f64::is_finite);
    finite.then(|| Some(word.to_string()))
}

#[cfg(test)]
mod tests {
    use super::{Columns, Row, Streamed};

    #[test]
    fn lines_of_a_log_are_read() {
        let columns = Streamed::parse("H,t_ms,seq,x,y,z,temp_c,current_a");
        let names = ["temp_c", "current_a"].map(String::from).to_vec();
        assert_eq!(columns, Some(Streamed::Columns(Columns(names))));
        let row = Streamed::parse("L,1260,63,-4096,7,-300,31.5,-");
        let values = vec![Some("31.5".to_string()), None];
        assert_eq!(
            row,
            Some(Streamed::Row(Row { t_ms: 1260, seq: 63, counts: Some([-4096, 7, -300]), values }))
        );
        let Some(Streamed::Row(row)) = Streamed::parse("L,1260,63,-,-,-") else { panic!("no row") };
        assert_eq!(row.counts, None);
    }

    #[test]
    fn lines_that_were_cut_are_none() {
        for line in [
            "",
            "R,20,1,2,3",
            "L",
            "L,20",
            "L,20,1,2,3",
            "L,20,1,2,3,4,nan",
            "L,20,1,2,3,40000",
            "L,20,1,2,-,4",
            "L,20,1,2,3,4,",
            "H,t_ms,seq,x,y",
            "H,t_ms,seq,x,y,w",
            "H,t_ms,seq,x,y,z,",
        ] {
            assert_eq!(Streamed::parse(line), None, "{line}");
        }
    }
}
