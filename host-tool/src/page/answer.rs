//! Questions of a page, one JSON object each, and their answers.

use crate::cal_file::CalFile;
use crate::cli::{ExportArgs, ExportForm};
use crate::exported;
use crate::failure::{Failure, Outcome};
use crate::page::asked::{LookAsked, ReadAsked};
use crate::page::held::Held;
use crate::page::look::{look, under};
use clap::ValueEnum;
use serde::Deserialize;
use serde_json::{Value, json};

/// A question.
#[derive(Debug, Deserialize)]
#[serde(tag = "do", rename_all = "kebab-case")]
enum Question {
    /// Reads the bytes as a log, which takes the place of the one with this number.
    Read { place: usize, options: ReadAsked, field_ut: Option<f64> },
    /// The same of a log that was packed.
    Unpack { place: usize },
    /// Looks at a log.
    Look { place: usize, asked: LookAsked },
    /// A log under a calibration file.
    Under { place: usize, cal: String, name: String },
    /// A calibration file for a target; with a log, what the target holds is fitted again.
    Export {
        cal: String,
        form: String,
        place: Option<usize>,
        number: Option<usize>,
        ut_per_count: Option<String>,
    },
}

/// The logs that a page holds.
#[derive(Debug, Default)]
pub struct Answering {
    logs: Vec<Option<Held>>,
}

/// A page compares two logs; more are a mistake.
const MOST_LOGS: usize = 8;

impl Answering {
    /// Answers a question; `bytes` is the log that goes with it. What went wrong is `{"error": …}`, as with `--json`.
    pub fn answer(&mut self, question: &str, bytes: &[u8]) -> String {
        match self.try_answer(question, bytes) {
            Ok(value) => value.to_string(),
            Err(failure) => failure.to_json().to_string(),
        }
    }

    /// Holds a log at a place.
    pub fn hold(&mut self, place: usize, held: Held) -> Outcome<()> {
        if place >= MOST_LOGS {
            return Err(Failure::usage(format!("there is no slot {place} for a log")));
        }
        if self.logs.len() <= place {
            self.logs.resize_with(place + 1, || None);
        }
        if let Some(slot) = self.logs.get_mut(place) {
            *slot = Some(held);
        }
        Ok(())
    }

    fn held(&self, place: usize) -> Outcome<&Held> {
        let held = self.logs.get(place).and_then(Option::as_ref);
        held.ok_or_else(|| Failure::usage("no log has been read yet. Drop one on the page"))
    }

    fn try_answer(&mut self, question: &str, bytes: &[u8]) -> Outcome<Value> {
        let question: Question = serde_json::from_str(question)
            .map_err(|error| Failure::usage(format!("this is not a request of the page: {error}")))?;
        match question {
            Question::Read { place, options, field_ut } => {
                self.take(place, Held::read(options, bytes, field_ut)?)
            }
            Question::Unpack { place } => self.take(place, Held::unpack(bytes)?),
            Question::Look { place, asked } => look(self.held(place)?, &asked),
            Question::Under { place, cal, name } => under(self.held(place)?, &cal, &name),
            Question::Export { cal, form, place, number, ut_per_count } => {
                let form = ExportForm::from_str(&form, false).map_err(Failure::usage)?;
                let log = place.map(|place| self.held(place)).transpose()?;
                let arguments = ExportArgs {
                    cal: "cal.json".into(),
                    form,
                    output: None,
                    log: None,
                    map: Vec::new(),
                    number,
                    device_id: None,
                    euler: false,
                    ut_per_count,
                };
                let exported = exported::text(&CalFile::parse(&cal)?, &arguments, log.map(|held| &held.log))?;
                Ok(json!({ "as": form.name(), "text": exported.text }))
            }
        }
    }

    fn take(&mut self, place: usize, held: Held) -> Outcome<Value> {
        let said = held.json();
        self.hold(place, held)?;
        Ok(said)
    }
}
