//! The frequency of a periodic disturbance as a parameter of its own: its refinement, and its share in the errors.

use super::engine::{BadShape, COLUMNS, Fitted, Known, Matrix, Pass, Piece};
use ironout::effect::{Column, Effect, MAX_COEFFICIENTS, MAX_INPUTS, Periodic, Quantities, Shape, TIME};
use std::f64::consts::TAU;
use std::sync::Arc;

/// The id of the periodic effect.
pub const PERIODIC: &str = "periodic";

/// How a periodic disturbance changes with its frequency: one column, the coefficient is a change of frequency in Hz.
struct Slope {
    frequency_hz: f64,
    reference_s: f64,
    coefficients: [f64; 6],
}

impl Effect<f64> for Slope {
    fn id(&self, out: &mut dyn std::fmt::Write) -> std::fmt::Result {
        out.write_str("periodic frequency")
    }
    fn name(&self) -> &str {
        "frequency of the periodic interference"
    }
    fn explanation(&self) -> &str {
        "A small error of the frequency grows with time. It is estimated together with the amplitudes."
    }
    fn columns(&self) -> [Option<Column<'_, f64>>; MAX_INPUTS] {
        [Some(Column::now(TIME)), None]
    }
    fn coefficients(&self) -> usize {
        1
    }
    fn unit(&self) -> &str {
        "Hz"
    }
    fn shape(&self, at: &Quantities<f64>, shape: &mut Shape<f64>) {
        let [time, _] = at.inputs;
        let since = time - self.reference_s;
        let (sin, cos) = (TAU * self.frequency_hz * since).sin_cos();
        let c = &self.coefficients;
        shape[0] = core::array::from_fn(|axis| TAU * since * (c[axis] * cos - c[3 + axis] * sin));
    }
}

fn fixed(piece: &Piece, name: &str) -> f64 {
    piece.fixed.iter().find(|(known, _)| *known == name).map_or(0.0, |(_, value)| *value)
}

fn slope<'a>(piece: &Piece<'a>) -> Piece<'a> {
    let mut coefficients = [0.0; 6];
    coefficients.copy_from_slice(&piece.coefficients[..6]);
    let effect = Slope {
        frequency_hz: fixed(piece, "frequency_hz"),
        reference_s: fixed(piece, "reference"),
        coefficients,
    };
    Piece {
        id: "periodic frequency".into(),
        effect: Arc::new(effect),
        coefficients: [0.0; MAX_COEFFICIENTS],
        fixed: Vec::new(),
        inputs: piece.inputs.clone(),
    }
}

/// Normal matrix with one more column for the frequency, if the model has a periodic effect; the column is the last.
pub fn with_slope(pass: &Pass, fitted: &Fitted) -> Result<Option<Matrix>, BadShape> {
    let Some(piece) = fitted.pieces.iter().find(|piece| piece.id == PERIODIC) else { return Ok(None) };
    if fitted.columns() + 1 > COLUMNS {
        return Ok(None);
    }
    let slope = slope(piece);
    let all: Vec<&Piece> = fitted.pieces.iter().chain([&slope]).collect();
    let blocks = pass.blocks(&pass.samples.bounds(2), &fitted.model, &all)?;
    Ok(Some(Matrix::total(&blocks, Some(&fitted.prior))))
}

/// Moves the frequency to where the error is least, and refits.
pub fn refine<'a>(pass: &Pass, mut fitted: Fitted<'a>, known: &Known) -> Result<Fitted<'a>, BadShape> {
    for _ in 0..3 {
        let Some(total) = with_slope(pass, &fitted)? else { return Ok(fitted) };
        let Some(factor) = total.factor() else { return Ok(fitted) };
        let change = total.step(&factor)[fitted.columns()];
        let mut pieces = fitted.pieces.clone();
        let Some(piece) = pieces.iter_mut().find(|piece| piece.id == PERIODIC) else { return Ok(fitted) };
        let (frequency_hz, reference_s) = (fixed(piece, "frequency_hz") + change, fixed(piece, "reference"));
        piece.effect = Arc::new(Periodic { frequency_hz, reference_s });
        piece.fixed = vec![("reference", reference_s), ("frequency_hz", frequency_hz)];
        match pass.fit(fitted.model, pieces, known)? {
            Some(next) if next.squares < fitted.squares => fitted = next,
            _ => return Ok(fitted),
        }
    }
    Ok(fitted)
}
