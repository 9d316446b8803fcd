//! The candidates that the columns of a log allow, and those that it does not.

use crate::base::piece::Piece;
use crate::samples::families::Families;
use crate::samples::samples::Samples;
use crate::table::Table;
use ironout::effect::{
    AmbientField, CrossAxis, Drift, Eddy, Effect, Gain, Lag, MAX_COEFFICIENTS, Nonlinearity, Offset,
    Periodic, Power, Step,
};
use std::sync::Arc;

/// What a log allows to be tested.
pub struct Catalogue<'a> {
    samples: &'a Samples,
    table: &'a Table<'a>,
    time: Option<Arc<Vec<[f64; 2]>>>,
    columns: Vec<Arc<Vec<[f64; 2]>>>,
    none: Arc<Vec<[f64; 2]>>,
    /// Every covariate's name.
    names: Vec<&'a str>,
    /// Which covariates move together.
    pub families: Families,
}

/// An effect that cannot be tested.
#[derive(Debug, Clone, PartialEq)]
pub struct Untestable {
    /// Its id.
    pub id: String,
    /// Its name.
    pub name: String,
    /// Why not, and what would allow it.
    pub why: String,
}

fn inputs(values: &[f64]) -> Arc<Vec<[f64; 2]>> {
    Arc::new(values.iter().map(|value| [*value, 0.0]).collect())
}

fn piece<'a>(
    effect: impl Effect<f64> + Send + Sync + 'a,
    fixed: &[(&'static str, f64)],
    inputs: Arc<Vec<[f64; 2]>>,
) -> Piece<'a> {
    let mut id = String::new();
    // Writing to a string cannot fail.
    let _ = effect.id(&mut id);
    Piece {
        id,
        effect: Arc::new(effect),
        coefficients: [0.0; MAX_COEFFICIENTS],
        fixed: fixed.to_vec(),
        inputs,
    }
}

impl<'a> Catalogue<'a> {
    /// Of a log.
    pub fn new(samples: &'a Samples, table: &'a Table<'a>) -> Self {
        Catalogue {
            samples,
            table,
            time: samples.time.as_deref().map(inputs),
            columns: samples.columns.iter().map(|column| inputs(&column.values)).collect(),
            none: Arc::new(Vec::new()),
            names: samples.columns.iter().map(|column| column.name.as_str()).collect(),
            families: Families::of(samples),
        }
    }

    /// Index of a covariate that can be tested.
    pub fn usable(&self, name: &str) -> Option<usize> {
        let index = self.names.iter().position(|known| *known == name)?;
        self.samples.columns[index].problem.is_none().then_some(index)
    }

    /// Names of the covariates that can be tested.
    pub fn usable_columns(&self) -> impl Iterator<Item = (usize, &'a str)> + '_ {
        self.names
            .iter()
            .enumerate()
            .filter(|(index, _)| self.samples.columns[*index].problem.is_none())
            .map(|(i, n)| (i, *n))
    }

    /// `offset:COLUMN`.
    pub fn offset(&self, index: usize) -> Piece<'a> {
        let column = &self.samples.columns[index];
        piece(
            Offset::linear(self.names[index], column.reference),
            &[("reference", column.reference)],
            self.columns[index].clone(),
        )
    }

    /// `offset:COLUMN^2`.
    pub fn offset_squared(&self, index: usize) -> Piece<'a> {
        let column = &self.samples.columns[index];
        let effect = Offset {
            column: self.names[index],
            reference: column.reference_square,
            power: Power::Squared,
            delay_s: None,
        };
        piece(effect, &[("reference", column.reference_square)], self.columns[index].clone())
    }

    /// `offset:COLUMN@delay`.
    pub fn offset_delayed(&self, index: usize, delay_s: f64) -> Option<Piece<'a>> {
        let column = &self.samples.columns[index];
        let values = self.samples.delayed(self.table, self.names[index], delay_s)?;
        let effect = Offset {
            column: self.names[index],
            reference: column.reference,
            power: Power::Linear,
            delay_s: Some(delay_s),
        };
        Some(piece(effect, &[("reference", column.reference), ("delay_s", delay_s)], inputs(&values)))
    }

    /// `gain:COLUMN`.
    pub fn gain(&self, index: usize) -> Piece<'a> {
        let reference = self.samples.columns[index].reference;
        piece(
            Gain { column: self.names[index], reference },
            &[("reference", reference)],
            self.columns[index].clone(),
        )
    }

    /// `field:COLUMN`.
    pub fn field(&self, index: usize) -> Piece<'a> {
        let reference = self.samples.columns[index].reference;
        piece(
            AmbientField { column: self.names[index], reference },
            &[("reference", reference)],
            self.columns[index].clone(),
        )
    }

    /// `drift`.
    pub fn drift(&self) -> Option<Piece<'a>> {
        let reference_s = self.samples.middle_s;
        Some(piece(Drift { reference_s }, &[("reference", reference_s)], self.time.clone()?))
    }

    /// `step` at a time.
    pub fn step(&self, at_s: f64) -> Option<Piece<'a>> {
        Some(piece(Step { at_s }, &[("at_s", at_s)], self.time.clone()?))
    }

    /// `periodic` at a frequency; phases count from the log's own zero if that is near its beginning.
    pub fn periodic(&self, frequency_hz: f64) -> Option<Piece<'a>> {
        let first = self.samples.time.as_ref()?.first().copied()?;
        let reference_s = if first.abs() < 1000.0 { 0.0 } else { first };
        let fixed = [("reference", reference_s), ("frequency_hz", frequency_hz)];
        Some(piece(Periodic { frequency_hz, reference_s }, &fixed, self.time.clone()?))
    }

    /// `lag` as a pure delay.
    pub fn lag(&self) -> Option<Piece<'a>> {
        self.has_gyro().then(|| piece(Lag, &[], self.none.clone()))
    }

    /// `lag` with eddy currents.
    pub fn eddy(&self) -> Option<Piece<'a>> {
        self.has_gyro().then(|| piece(Eddy, &[], self.none.clone()))
    }

    /// `nonlinearity`.
    pub fn nonlinearity(&self) -> Piece<'a> {
        piece(Nonlinearity, &[], self.none.clone())
    }

    /// `cross-axis`.
    pub fn cross_axis(&self) -> Piece<'a> {
        piece(CrossAxis, &[], self.none.clone())
    }

    fn has_gyro(&self) -> bool {
        self.samples.readings.iter().filter(|reading| reading.turn_radps.is_some()).count() * 2
            > self.samples.len()
    }

    /// Whether the log has directions down for most samples.
    pub fn has_down(&self) -> bool {
        self.samples.readings.iter().filter(|reading| reading.down.is_some()).count() * 10
            > 3 * self.samples.len()
    }

    /// The fixed-shape candidates of the magnitude (or of the vector of a board at rest).
    pub fn plain(&self, at_rest: bool) -> Vec<Piece<'a>> {
        let mut list = Vec::new();
        for (index, _) in self.usable_columns() {
            list.push(self.offset(index));
            if !at_rest {
                list.push(self.gain(index));
                list.push(self.field(index));
            }
            list.push(self.offset_squared(index));
        }
        list.extend(self.drift());
        if !at_rest {
            list.extend(self.eddy());
            list.push(self.nonlinearity());
            list.push(self.cross_axis());
        }
        list
    }

    /// What the log does not allow, with the reason.
    pub fn untestable(&self) -> Vec<Untestable> {
        let mut list = Vec::new();
        let mut add =
            |id: String, name: &str, why: String| list.push(Untestable { id, name: name.to_string(), why });
        for column in &self.samples.columns {
            if let Some(problem) = &column.problem {
                for kind in ["offset", "gain", "field"] {
                    let id = format!("{kind}:{}", column.name);
                    add(
                        id,
                        &format!("{kind} with {}", column.name),
                        format!("{problem}: log it while it changes"),
                    );
                }
            }
        }
        let none_with = |suffix: &str| !self.names.iter().any(|name| name.ends_with(suffix));
        if none_with("_c") {
            add("offset:temp_c".into(), "temperature offset", "no temperature column: log temp_c".into());
            add("gain:temp_c".into(), "temperature gain", "no temperature column: log temp_c".into());
        }
        if none_with("_a") {
            add("offset:current_a".into(), "current offset", "no current column: log current_a".into());
        }
        if self.time.is_none() {
            for (id, name) in
                [("drift", "offset drift"), ("step", "offset step"), ("periodic", "periodic interference")]
            {
                add(id.into(), name, "no time column: log t_s".into());
            }
        }
        if !self.has_gyro() {
            add(
                "lag".into(),
                "lag and eddy currents",
                "no rate of turn: log gx_radps,gy_radps,gz_radps".into(),
            );
        } else if !self.has_down() {
            let why = "a pure delay leaves the magnitude alone: log ax_mps2,ay_mps2,az_mps2 (eddy currents were tested)";
            add("lag".into(), "sensor lag", why.into());
        }
        if !self.has_down() {
            let why = "no direction down: log ax_mps2,ay_mps2,az_mps2";
            add("misalignment".into(), "misalignment", why.into());
            add("axis-order".into(), "axis order", why.into());
        }
        list
    }
}
