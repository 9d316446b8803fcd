//! The unit in which printed text gives magnetic fields (`--unit`). JSON and files are always in the unit that their keys name.

use std::sync::atomic::{AtomicU8, Ordering};

/// A unit of the magnetic field.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum FieldUnit {
    /// Nanotesla
    #[value(alias = "nanotesla")]
    Nt,
    /// Microtesla
    #[value(alias = "microtesla")]
    Ut,
    /// Milligauss
    #[value(alias = "milligauss")]
    Mg,
    /// Gauss
    #[value(alias = "gauss")]
    G,
}

static CHOSEN: AtomicU8 = AtomicU8::new(FieldUnit::Ut as u8);

/// Prints fields in this unit from now on.
pub fn choose(unit: FieldUnit) {
    CHOSEN.store(unit as u8, Ordering::Relaxed);
}

/// The unit in use.
pub fn chosen() -> FieldUnit {
    let all = [FieldUnit::Nt, FieldUnit::Mg, FieldUnit::G];
    let number = CHOSEN.load(Ordering::Relaxed);
    all.into_iter().find(|unit| *unit as u8 == number).unwrap_or(FieldUnit::Ut)
}

impl FieldUnit {
    /// Its symbol.
    pub const fn symbol(self) -> &'static str {
        match self {
            FieldUnit::Nt => "nT",
            FieldUnit::Ut => "µT",
            FieldUnit::Mg => "mG",
            FieldUnit::G => "G",
        }
    }

    /// How many of it are a microtesla.
    pub const fn per_ut(self) -> f64 {
        match self {
            FieldUnit::Nt => 1e3,
            FieldUnit::Ut => 1.0,
            FieldUnit::Mg => 10.0,
            FieldUnit::G => 0.01,
        }
    }

    /// The number of a field, to the place that `decimals` of a microtesla have.
    pub fn fixed(self, value_ut: f64, decimals: usize) -> String {
        let further = -self.per_ut().log10() as i32;
        let decimals = (decimals as i32 + further).max(0) as usize;
        format!("{:.decimals$}", value_ut * self.per_ut())
    }
}

/// The symbol of the unit in use.
pub fn symbol() -> &'static str {
    chosen().symbol()
}

/// A number in the unit in use, to the place that `decimals` of a microtesla have; a dash if it is unknown.
pub fn fixed(value_ut: Option<f64>, decimals: usize) -> String {
    match value_ut.filter(|value| value.is_finite()) {
        Some(value) => chosen().fixed(value, decimals),
        None => "-".to_string(),
    }
}

/// A number with its sign, in the unit in use.
pub fn signed(value_ut: f64, decimals: usize) -> String {
    let number = fixed(Some(value_ut), decimals);
    if number.starts_with('-') { number } else { format!("+{number}") }
}

/// Vector ± standard errors, in the unit in use.
pub fn vector_with_errors(values_ut: [f64; 3], errors_ut: [f64; 3]) -> String {
    let [x, y, z] =
        [0, 1, 2].map(|axis| format!("{} ±{}", signed(values_ut[axis], 2), fixed(Some(errors_ut[axis]), 2)));
    format!("x {x}, y {y}, z {z} {}", symbol())
}

/// A unit that contains µT, in the unit in use, and the factor to it: `µT/A` as `nT/A`.
pub fn derived(unit: &str) -> (f64, String) {
    match unit.strip_prefix("µT") {
        Some(rest) => (chosen().per_ut(), format!("{}{rest}", symbol())),
        None => (1.0, unit.to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_the_place_of_their_last_digit() {
        assert_eq!(FieldUnit::Ut.fixed(0.2519, 3), "0.252");
        assert_eq!(FieldUnit::Nt.fixed(0.2519, 3), "252");
        assert_eq!(FieldUnit::Mg.fixed(0.2519, 3), "2.52");
        assert_eq!(FieldUnit::G.fixed(0.2519, 3), "0.00252");
        assert_eq!(FieldUnit::Nt.fixed(52.3, 0), "52300");
    }
}
