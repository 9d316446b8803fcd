//! What a kind of hidden effect has to say of itself, and what it may look at.

use std::fmt;

/// The world as an effect sees it: everything but the effects themselves.
pub trait Scene {
    /// Value of a covariate at a time, s.
    fn covariate(&self, name: &str, t_s: f64) -> f64;
    /// `A h`: what an undisturbed sensor without an offset measures, µT.
    fn clean_ut(&self, t_s: f64) -> [f64; 3];
    /// `A (ω × h)`: how fast the noise-free measured vector falls behind, µT/s.
    fn turning_ut_per_s(&self, t_s: f64) -> [f64; 3];
}

/// The kind of a hidden effect: how it is simulated, and the column it follows.
#[derive(Clone)]
pub struct EffectKind {
    /// How it is simulated.
    pub simulated: &'static dyn Simulated,
    /// The column that its id names; empty where it names none.
    pub column: String,
    /// Whether the column's square acts: `^2`.
    pub squared: bool,
    /// Whether the column acts late: `@delay`.
    pub delayed: bool,
    /// Whether the column acts through a low-pass: `~tau`.
    pub slow: bool,
}

impl EffectKind {
    /// The id under which `diagnose` names this effect.
    pub fn id(&self) -> String {
        let id = self.simulated.id();
        let late = match (self.delayed, self.slow) {
            (true, _) => "@delay",
            (_, true) => "~tau",
            _ => "",
        };
        let square = if self.squared { "^2" } else { "" };
        if self.column.is_empty() { id.to_string() } else { format!("{id}:{}{late}{square}", self.column) }
    }

    /// Columns that it follows: of a product both.
    pub fn columns(&self) -> impl Iterator<Item = &str> {
        self.column().into_iter().flat_map(|names| names.split('*'))
    }

    /// The column it follows, if any.
    pub fn column(&self) -> Option<&str> {
        Some(self.column.as_str()).filter(|name| !name.is_empty()).or(self.simulated.own_column())
    }
}

impl fmt::Debug for EffectKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("EffectKind").field(&self.simulated.kind()).field(&self.id()).finish()
    }
}

/// Kinds are the same if they are simulated under the same name with the same id.
impl PartialEq for EffectKind {
    fn eq(&self, other: &Self) -> bool {
        self.simulated.kind() == other.simulated.kind() && self.id() == other.id()
    }
}

/// The numbers of a hidden effect.
#[derive(Clone, Debug, PartialEq)]
pub struct Drawn {
    /// True coefficients, in the order and units of the effect of the same id in the library's catalogue.
    pub coefficients: Vec<f64>,
    /// Value of the column (or the time) at which the effect vanishes.
    pub reference: f64,
    /// When a step happens, s.
    pub at_s: f64,
    /// Frequency of a periodic disturbance, Hz.
    pub frequency_hz: f64,
    /// Delay of a late column or of a lag, s.
    pub delay_s: f64,
    /// Time constant of the low-pass through which a column acts, s.
    pub time_constant_s: f64,
    /// The rotation of a misalignment or of swapped axes, rows.
    pub rotation: Option<[[f64; 3]; 3]>,
}

impl Drawn {
    /// A coefficient, 0 where there is none.
    pub fn theta(&self, index: usize) -> f64 {
        self.coefficients.get(index).copied().unwrap_or(0.0)
    }

    /// Three coefficients from an index on.
    pub fn three(&self, from: usize) -> [f64; 3] {
        [self.theta(from), self.theta(from + 1), self.theta(from + 2)]
    }
}

/// How one kind of effect is simulated. An effect of one's own is one type that says so, given to
/// [`EffectSpec::parse_with`](super::EffectSpec::parse_with).
pub trait Simulated: Sync {
    /// The word that asks for it, as in `offset:temp_c`.
    fn kind(&self) -> &'static str;
    /// The word under which `diagnose` names it, where that is another one.
    fn id(&self) -> &'static str {
        self.kind()
    }
    /// What may be asked for, for lists.
    fn listed(&self) -> &'static [&'static str];
    /// Whether its id names a column: `kind:COLUMN`.
    fn takes_column(&self) -> bool {
        false
    }
    /// Whether that column may act squared, late or through a low-pass.
    fn takes_variants(&self) -> bool {
        false
    }
    /// A column that it follows without naming it in its id.
    fn own_column(&self) -> Option<&'static str> {
        None
    }
    /// Whether its strength may be given as a time: `=18ms`.
    fn takes_time(&self) -> bool {
        false
    }
    /// The strength where none is given: multiples of the noise.
    fn usual_strength(&self) -> f64 {
        3.0
    }
    /// How many coefficients are drawn.
    fn coefficients(&self) -> usize;
    /// Brings drawn coefficients of unlike units to the like share in a field of that magnitude.
    fn balance(&self, coefficients: &mut [f64], field_ut: f64) {
        let _ = (coefficients, field_ut);
    }
    /// A rotation between the sensors instead of a disturbance; `normal` draws.
    fn rotation(&self, strength: f64, normal: &mut dyn FnMut() -> f64) -> Option<[[f64; 3]; 3]> {
        let _ = (strength, normal);
        None
    }
    /// What the disturbance is in proportion to; its mean becomes the reference.
    fn input(&self, kind: &EffectKind, drawn: &Drawn, scene: &dyn Scene, t_s: f64) -> f64 {
        let _ = (kind, drawn, scene, t_s);
        0.0
    }
    /// The disturbance of the measured vector at a time, where the noise-free measured vector is `measured_ut`; µT.
    fn disturbance(
        &self,
        kind: &EffectKind,
        drawn: &Drawn,
        scene: &dyn Scene,
        t_s: f64,
        measured_ut: [f64; 3],
    ) -> [f64; 3];
    /// The vector whose size its strength is about, where that is not the disturbance.
    fn hidden_from_the_magnitude(&self, drawn: &Drawn, scene: &dyn Scene, t_s: f64) -> Option<[f64; 3]> {
        let _ = (drawn, scene, t_s);
        None
    }
    /// The last word on the numbers, once they have their size.
    fn settle(&self, drawn: &mut Drawn) {
        let _ = drawn;
    }
    /// How late the sensor is, s.
    fn pure_delay_s(&self, drawn: &Drawn) -> f64 {
        let _ = drawn;
        0.0
    }
    /// What the truth has to tell besides the coefficients.
    fn describe(&self, kind: &EffectKind, drawn: &Drawn) -> String {
        let _ = (kind, drawn);
        String::new()
    }
}

/// `vector · factor`.
pub(super) fn times(vector: [f64; 3], factor: f64) -> [f64; 3] {
    vector.map(|value| value * factor)
}

/// Products axis by axis.
pub(super) fn each(one: [f64; 3], other: [f64; 3]) -> [f64; 3] {
    [one[0] * other[0], one[1] * other[1], one[2] * other[2]]
}

/// Sums axis by axis.
pub(super) fn plus(one: [f64; 3], other: [f64; 3]) -> [f64; 3] {
    [one[0] + other[0], one[1] + other[1], one[2] + other[2]]
}
