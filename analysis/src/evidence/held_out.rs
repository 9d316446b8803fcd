//! Whether a term is shown by many parts of a log, or by one.
//!
//! The likelihood supposes normal innovations. A cause that nobody logged jumps: then a term that happens to change at a jump explains
//! one enormous innovation, and the likelihood rises by hundreds. So each coefficient is estimated with one part of the log left out at a
//! time, from the same sums. The spread of those estimates (jackknife) is its error whatever the distribution of the noise.

use crate::evidence::design::BASE;
use crate::evidence::fit::Fit;
use crate::evidence::solve::{Factor, Sums};
use nalgebra::{DMatrix, DVector};

/// Parts of a log: enough for an error of nine coefficients, each long enough for all orientations.
const PARTS: usize = 40;

/// p-value of each term's coefficients all being zero, by the spread over parts of the log.
pub fn p_values(fit: &Fit) -> Vec<f64> {
    let width = fit.model.columns() + 1;
    let columns = width - 1;
    let mut whitened = fit.rows.clone();
    fit.noise.whiten(&fit.track, width, &mut whitened);
    let rows = whitened.len() / width;
    let ones = vec![1.0; fit.model.terms.len()];
    if rows < 4 * PARTS {
        return ones;
    }
    let part = rows.div_ceil(PARTS);
    let Some(factor) = Factor::of(&fit.sums.matrix) else { return ones };
    // Around the fitted values the estimate without a part moves by (N − N_part)⁻¹ times the part's gradient.
    let mut changes: Vec<DVector<f64>> = Vec::new();
    let whole = -factor.solve(&Sums::of(&whitened, columns).right);
    for chunk in whitened.chunks(part * width) {
        let sums = Sums::of(chunk, columns);
        let left = &fit.sums.matrix - &sums.matrix;
        let Some(left) = Factor::of(&left) else { return ones };
        let gradient = &sums.right + &sums.matrix * &whole;
        changes.push(left.solve(&gradient));
    }
    let parts = changes.len() as f64;
    let mut at = BASE;
    let mut out = Vec::new();
    for term in &fit.model.terms {
        let k = term.k();
        let mean: DVector<f64> =
            changes.iter().map(|c| c.rows(at, k).into_owned()).fold(DVector::zeros(k), |a, b| a + b) / parts;
        let mut spread = DMatrix::zeros(k, k);
        for change in &changes {
            let off = change.rows(at, k) - &mean;
            spread += &off * off.transpose();
        }
        spread *= (parts - 1.0) / parts;
        let theta = DVector::from_fn(k, |i, _| term.theta[i]);
        // A direction that nothing shows (a pure delay) has no spread to speak of in its own units: it is scaled, not inverted.
        let square = Factor::of(&spread).map_or(0.0, |factor| theta.dot(&factor.solve(&theta)));
        let degrees = parts - k as f64;
        let f = square * degrees / (k as f64 * (parts - 1.0));
        out.push(f_tail(f, k as f64, degrees));
        at += k;
    }
    out
}

/// Probability of more than `f` under the F distribution.
fn f_tail(f: f64, a: f64, b: f64) -> f64 {
    if !(f > 0.0) {
        return 1.0;
    }
    incomplete_beta(b / (b + a * f), 0.5 * b, 0.5 * a)
}

/// Regularised incomplete beta function, by its continued fraction.
fn incomplete_beta(x: f64, a: f64, b: f64) -> f64 {
    if x <= 0.0 || x >= 1.0 {
        return x.clamp(0.0, 1.0);
    }
    if x > (a + 1.0) / (a + b + 2.0) {
        return 1.0 - incomplete_beta(1.0 - x, b, a);
    }
    let front = (ln_gamma(a + b) - ln_gamma(a) - ln_gamma(b) + a * x.ln() + b * (1.0 - x).ln()).exp() / a;
    let (mut c, mut d) = (1.0, 1.0 / (1.0 - (a + b) * x / (a + 1.0)));
    let mut fraction = d;
    for m in 1..200 {
        let m = f64::from(m);
        let even = m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m));
        d = 1.0 / (1.0 + even * d);
        c = 1.0 + even / c;
        fraction *= c * d;
        let odd = -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0));
        d = 1.0 / (1.0 + odd * d);
        c = 1.0 + odd / c;
        fraction *= c * d;
        if (c * d - 1.0).abs() < 1e-12 {
            break;
        }
    }
    front * fraction
}

/// Logarithm of the gamma function, by recurrence to where Stirling's series is exact to twelve digits.
fn ln_gamma(x: f64) -> f64 {
    let (mut x, mut shift) = (x, 0.0);
    while x < 12.0 {
        shift -= x.ln();
        x += 1.0;
    }
    let y = 1.0 / (x * x);
    let series = (1.0 / 12.0 - y * (1.0 / 360.0 - y * (1.0 / 1260.0 - y / 1680.0))) / x;
    shift + (x - 0.5) * x.ln() - x + 0.918_938_533_204_672_7 + series
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tails_are_those_of_tables() {
        // One per cent points of F(3, 20) and F(6, 34).
        assert!((f_tail(4.938, 3.0, 20.0) - 0.01).abs() < 1e-4);
        assert!((f_tail(3.386, 6.0, 34.0) - 0.01).abs() < 1e-4);
        assert!((f_tail(1.0, 2.0, 2.0) - 0.5).abs() < 1e-9);
    }
}
