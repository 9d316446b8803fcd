//! What a fit or a diagnosis says: one value, of which text, JSON and pages are views.

use crate::reason::Reason;
use serde::Serialize;

/// A figure and what it is of.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Figure {
    /// What it is of; empty where it continues the figure before it.
    pub label: String,
    /// The figure with its unit.
    pub text: String,
}

/// A part of the advice.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Next {
    /// A sentence.
    Say(String),
    /// A command, as it can be typed.
    Command(String),
}

/// What a fit or a diagnosis says.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Report {
    /// The verdict: its word first, then the sentences that say what was found.
    pub verdict: Vec<String>,
    /// Why, where the verdict does not say so itself.
    pub reasons: Vec<Reason>,
    /// The figures that matter, in the unit of the output.
    pub figures: Vec<Figure>,
    /// What is noticed besides.
    pub remarks: Vec<String>,
    /// What to do next.
    pub next: Vec<Next>,
}

impl Report {
    /// Adds a figure.
    pub fn figure(&mut self, label: &str, text: impl Into<String>) {
        self.figures.push(Figure { label: label.into(), text: text.into() });
    }

    /// Adds a sentence of advice.
    pub fn say(&mut self, text: impl Into<String>) {
        self.next.push(Next::Say(text.into()));
    }

    /// Adds a command to run.
    pub fn command(&mut self, text: impl Into<String>) {
        self.next.push(Next::Command(text.into()));
    }
}
