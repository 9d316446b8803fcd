//! What is asked for: `ID[=STRENGTH]`.

use super::list::LIST;
use super::simulated::{EffectKind, Simulated};
use std::fmt;

/// One hidden effect to simulate.
#[derive(Clone, Debug, PartialEq)]
pub struct EffectSpec {
    /// Shape.
    pub kind: EffectKind,
    /// The disturbance's rms as a multiple of the noise in the residual that sees it, beyond what the base model absorbs.
    pub strength: f64,
    /// A delay given in seconds instead (`lag=18ms`).
    pub delay_s: Option<f64>,
}

/// Why a specification was not understood.
#[derive(Clone, Debug, PartialEq)]
pub struct SpecError(pub String);

impl fmt::Display for SpecError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let known: Vec<&str> = LIST.iter().flat_map(|simulated| simulated.listed()).copied().collect();
        write!(
            f,
            "{}; known effects: {}, each with =STRENGTH (multiples of the noise; degrees for misalignment; lag=18ms is a \
             time)",
            self.0,
            known.join(", ")
        )
    }
}

impl std::error::Error for SpecError {}

impl EffectSpec {
    /// Reads `ID[=STRENGTH]`; the strength is 3 times the noise where absent (6° for `misalignment`).
    ///
    /// # Errors
    /// [`SpecError`].
    pub fn parse(text: &str) -> Result<EffectSpec, SpecError> {
        Self::parse_with(text, &[])
    }

    /// The same with effects of one's own behind those of this crate.
    ///
    /// # Errors
    /// [`SpecError`].
    pub fn parse_with(text: &str, own: &[&'static dyn Simulated]) -> Result<EffectSpec, SpecError> {
        let (id, value) = text.split_once('=').map_or((text, None), |(id, value)| (id, Some(value)));
        let (word, column) = id.split_once(':').map_or((id, None), |(word, column)| (word, Some(column)));
        let mut known = LIST.iter().chain(own).copied();
        let simulated = known
            .find(|one| one.kind() == word && one.takes_column() == column.is_some())
            .ok_or_else(|| SpecError(format!("unknown effect `{id}`")))?;
        let kind = kind(simulated, id, column)?;
        let (number, in_ms) = match value {
            Some(value) => {
                value.strip_suffix("ms").map_or((Some(value), false), |number| (Some(number), true))
            }
            None => (None, false),
        };
        if in_ms && !simulated.takes_time() {
            return Err(SpecError(format!("only `lag` takes a time, not `{id}`")));
        }
        let strength = match number {
            None => simulated.usual_strength(),
            Some(number) => number
                .parse::<f64>()
                .ok()
                .filter(|value| value.is_finite() && *value >= 0.0)
                .ok_or_else(|| SpecError(format!("`{number}` is not a strength for `{id}`")))?,
        };
        Ok(EffectSpec { kind, strength, delay_s: in_ms.then_some(strength / 1e3) })
    }

    /// The id under which `diagnose` names this effect.
    pub fn id(&self) -> String {
        self.kind.id()
    }

    /// The columns that this effect follows.
    pub fn columns(&self) -> impl Iterator<Item = &str> {
        self.kind.columns()
    }
}

fn kind(simulated: &'static dyn Simulated, id: &str, column: Option<&str>) -> Result<EffectKind, SpecError> {
    let cut = |name: &'_ str, suffix: &str| match name.strip_suffix(suffix) {
        Some(rest) if simulated.takes_variants() => (rest.to_string(), true),
        _ => (name.to_string(), false),
    };
    let (name, squared) = cut(column.unwrap_or_default(), "^2");
    let (name, delayed) = cut(&name, "@delay");
    let (name, slow) = cut(&name, "~tau");
    if slow && (delayed || squared) {
        return Err(SpecError(format!("`{id}`: a low-pass cannot be combined with `@delay` or `^2`")));
    }
    if column.is_some() && name.is_empty() {
        return Err(SpecError(format!("effect `{id}` names no column")));
    }
    let columns = if simulated.kind() == "product" { 2 } else { 1 };
    let kind = EffectKind { simulated, column: name, squared, delayed, slow };
    if column.is_some() && (kind.columns().count() != columns || kind.columns().any(str::is_empty)) {
        return Err(SpecError(format!("`{id}` names another number of columns than {columns}")));
    }
    Ok(kind)
}
