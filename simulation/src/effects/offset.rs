//! An additive vector in proportion to a column: `offset:COLUMN`, `offset:COLUMN^2`, `offset:COLUMN@delay`, `offset:COLUMN~tau`.

use super::simulated::{Drawn, EffectKind, Scene, Simulated, times};

/// It.
pub struct Offset;

impl Simulated for Offset {
    fn kind(&self) -> &'static str {
        "offset"
    }
    fn listed(&self) -> &'static [&'static str] {
        &["offset:COLUMN", "offset:COLUMN^2", "offset:COLUMN@delay", "offset:COLUMN~tau"]
    }
    fn takes_column(&self) -> bool {
        true
    }
    fn takes_variants(&self) -> bool {
        true
    }
    fn coefficients(&self) -> usize {
        3
    }
    fn input(&self, kind: &EffectKind, drawn: &Drawn, scene: &dyn Scene, t_s: f64) -> f64 {
        if kind.slow {
            return low_pass(drawn.time_constant_s, |t_s| scene.covariate(&kind.column, t_s), t_s);
        }
        let t_s = if kind.delayed { t_s - drawn.delay_s } else { t_s };
        scene.covariate(&kind.column, t_s).powi(if kind.squared { 2 } else { 1 })
    }
    fn disturbance(
        &self,
        kind: &EffectKind,
        drawn: &Drawn,
        scene: &dyn Scene,
        t_s: f64,
        _: [f64; 3],
    ) -> [f64; 3] {
        times(drawn.three(0), self.input(kind, drawn, scene, t_s) - drawn.reference)
    }
    fn describe(&self, kind: &EffectKind, drawn: &Drawn) -> String {
        let late = if kind.slow {
            format!(", time_constant_s = {}", drawn.time_constant_s)
        } else if kind.delayed {
            format!(", delay_s = {}", drawn.delay_s)
        } else {
            String::new()
        };
        format!(", zero at {}{late}", drawn.reference)
    }
}

/// Instants at which a low-pass looks back.
const LOOKS: u32 = 1024;

/// A column through a low-pass that began with the column's value at time 0: the mean of its past, weighted by `exp(−age/τ)`, so the plain
/// mean over equal shares of that weight.
fn low_pass(time_constant_s: f64, column: impl Fn(f64) -> f64, t_s: f64) -> f64 {
    let share = |k: u32| (f64::from(k) + 0.5) / f64::from(LOOKS);
    let looks = (0..LOOKS).map(|k| column((t_s + time_constant_s * share(k).ln()).max(0.0)));
    looks.sum::<f64>() / f64::from(LOOKS)
}

#[cfg(test)]
mod tests {
    use super::low_pass;

    #[test]
    fn a_step_decays_and_a_ramp_trails() {
        for t_s in [0.5_f64, 3.0, 40.0] {
            let step = low_pass(4.0, |t| if t >= 0.2 { 1.0 } else { 0.0 }, t_s);
            assert!((step - (1.0 - (-(t_s - 0.2) / 4.0).exp())).abs() < 2e-3, "{step} at {t_s}");
            let ramp = low_pass(4.0, |t| t, t_s);
            assert!((ramp - (t_s - 4.0 + 4.0 * (-t_s / 4.0).exp())).abs() < 0.02, "{ramp} at {t_s}");
        }
    }
}
