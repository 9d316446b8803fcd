//! Fields that are predicted by the mean of the last two frames, put right.
//!
//! Behind an I frame the firmware takes that frame for both of the last two (blackbox.c, `writeIntraframe`), and so does its own
//! decoder. The crate `blackbox-log` 0.4 takes the frame before it for the second: gyroscope and accelerometer would be off from
//! every I frame to the next. What a frame had written is what the crate gives less the mean that it took, and goes on top of the
//! right one.

use std::collections::HashMap;

/// The number of the predictor in the header.
const AVERAGE_2: &str = "3";

/// The fields of one session, with their last two values as decoded and as meant.
pub struct Averages {
    interval: i64,
    fields: Vec<Field>,
    begun: bool,
}

struct Field {
    index: usize,
    decoded: [i64; 2],
    meant: [i64; 2],
}

impl Averages {
    /// For a session with these header lines, whose main frames have these fields. `Err`: the header does not say how often I
    /// frames come, and these fields cannot be read.
    pub fn new(names: &[(String, bool)], headers: &HashMap<&str, &str>) -> Result<Self, Vec<String>> {
        let list = |name: &str| headers.get(name).map_or("", |line| line).split(',');
        let predicted: Vec<&str> = list("Field I name")
            .zip(list("Field P predictor"))
            .filter(|(_, predictor)| *predictor == AVERAGE_2)
            .map(|(name, _)| name)
            .collect();
        let fields: Vec<Field> = names
            .iter()
            .enumerate()
            .filter(|(_, (name, _))| predicted.contains(&name.as_str()))
            .map(|(index, _)| Field { index, decoded: [0; 2], meant: [0; 2] })
            .collect();
        let interval =
            headers.get("I interval").and_then(|text| text.parse().ok()).filter(|every| *every > 0);
        match interval {
            Some(interval) => Ok(Averages { interval, fields, begun: false }),
            None if fields.is_empty() => Ok(Averages { interval: 1, fields, begun: false }),
            None => Err(predicted.into_iter().map(String::from).collect()),
        }
    }

    /// Puts right the values of one frame, all its fields in order; the first of them counts the iterations.
    pub fn repair(&mut self, values: &mut [i64]) {
        // I frames stand where the count is a multiple of their interval; P frames count on from them and never get there.
        let intra = !self.begun || values.first().is_some_and(|iteration| iteration % self.interval == 0);
        for field in &mut self.fields {
            let Some(value) = values.get_mut(field.index) else { continue };
            let decoded = *value;
            if intra {
                field.meant = [decoded; 2];
            } else {
                *value = decoded - average(field.decoded) + average(field.meant);
                field.meant = [*value, field.meant[0]];
            }
            field.decoded = if self.begun { [decoded, field.decoded[0]] } else { [decoded; 2] };
        }
        self.begun = true;
    }
}

/// As the firmware computes it: towards zero.
fn average([last, before]: [i64; 2]) -> i64 {
    (last + before) / 2
}
