//! What a page asks for.

use crate::cli::{Expected, FieldArgs, LogArgs, MethodArg};
use crate::failure::Outcome;
use serde::{Deserialize, Serialize};

/// How a log is to be read: the options of the command line.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ReadAsked {
    /// The log's name.
    pub name: String,
    /// `--ut-per-count`.
    pub ut_per_count: Option<String>,
    /// Each `--map`.
    pub map: Vec<String>,
    /// Each `--rotate`.
    pub rotate: Vec<String>,
    /// Each `--repair`.
    #[serde(default)]
    pub repair: Vec<String>,
    /// `--instance`.
    pub instance: Option<usize>,
    /// Each `--derive`.
    pub derive: Vec<String>,
    /// Each `--ignore`.
    #[serde(default)]
    pub ignore: Vec<String>,
    /// `--date`.
    pub date: Option<String>,
}

impl ReadAsked {
    /// Of the command line.
    pub fn of(arguments: &LogArgs) -> Self {
        ReadAsked {
            name: arguments.log.display().to_string(),
            ut_per_count: arguments.ut_per_count.clone(),
            map: arguments.map.clone(),
            rotate: arguments.rotate.clone(),
            repair: arguments.repair.clone(),
            instance: arguments.instance,
            derive: arguments.derive.clone(),
            ignore: arguments.ignore.clone(),
            date: arguments.date.clone(),
        }
    }

    /// As the command line has it.
    pub fn arguments(&self) -> LogArgs {
        LogArgs {
            reference: None,
            log: self.name.clone().into(),
            more: Vec::new(),
            ut_per_count: self.ut_per_count.clone(),
            map: self.map.clone(),
            rotate: self.rotate.clone(),
            repair: self.repair.clone(),
            instance: self.instance,
            derive: self.derive.clone(),
            ignore: self.ignore.clone(),
            date: self.date.clone(),
        }
    }
}

/// What a log is to be looked at with.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LookAsked {
    /// Effects in the model.
    pub add: Vec<String>,
    /// Whether others are searched for.
    pub search: bool,
    /// `--field`, µT.
    pub field_ut: Option<f64>,
    /// `--at`.
    pub at: Option<String>,
    /// What noise alone leaves, µT, where a search of this log has told it from what is missing.
    pub floor_ut: Option<f64>,
}

impl LookAsked {
    /// The field as the command line has it.
    pub fn field(&self) -> FieldArgs {
        FieldArgs { field: self.field_ut, at: self.at.clone(), method: MethodArg::Adjusted }
    }

    /// What is known of the field.
    ///
    /// # Errors
    /// No magnitude or place.
    pub fn expected(&self) -> Outcome<Expected> {
        self.field().expected()
    }
}
