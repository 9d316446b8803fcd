//! An effect in a model: its shape, its coefficients, and the values of its columns.

use ironout::effect::{
    Acts, Bends, BuiltIn, ColumnName, Effect, Follows, Form, MAX_COEFFICIENTS, MAX_INPUTS, Made, Named,
    Parts, Quantities, Registry, Searched, Shape, no_shape,
};
use ironout::study::{Normal, Term as SampleTerm};
use nalgebra::Vector3;
use std::sync::Arc;

/// Most columns of one pass.
pub const COLUMNS: usize = 64;
/// Most effects of one pass.
pub const TERMS: usize = 20;
/// Blocks of time for the held-out error.
pub const BLOCKS: usize = 10;

/// A normal matrix of this host.
pub type Matrix = Normal<f64, COLUMNS>;

/// Somebody's effect, shared.
pub type Shared<'a> = Arc<dyn Effect<f64> + Send + Sync + 'a>;

/// An effect with its coefficients and the values of its columns at every sample.
#[derive(Clone)]
pub struct Term<'a> {
    /// Its id.
    pub id: String,
    /// The family and the parts of the effect; `None` for a column of the analysis' own.
    pub made: Option<Made<&'a str>>,
    /// The shape.
    pub effect: Shared<'a>,
    /// Coefficients; the first k count.
    pub coefficients: [f64; MAX_COEFFICIENTS],
    /// Values of its columns.
    pub inputs: Arc<Vec<[f64; MAX_INPUTS]>>,
    /// Among how many trials what fixes its shape was found; 1 where nothing was searched.
    pub trials: f64,
    /// Twice the log of the prior odds against this form.
    pub odds: f64,
    /// What it bends, where its shape is made of the measured vector.
    pub bends: Bends,
}

impl<'a> Term<'a> {
    /// An effect without coefficients yet.
    pub fn new(made: Made<&'a str>, inputs: Arc<Vec<[f64; MAX_INPUTS]>>) -> Self {
        let id = ironout::effect::Id(&made).to_string();
        let effect = ready(made);
        let coefficients = [0.0; MAX_COEFFICIENTS];
        let bends = Bends::Reading;
        Term { id, made: Some(made), effect, coefficients, inputs, trials: 1.0, odds: 0.0, bends }
    }

    /// The parts of the effect.
    pub fn parts(&self) -> Option<&Parts<&'a str>> {
        self.made.as_ref().map(Made::parts)
    }

    /// Its id taken apart.
    pub fn named(&self) -> Option<Named<'a>> {
        let made = self.made.as_ref()?;
        Some(Named { family: made.family(), column: made.parts().column, form: made.parts().form })
    }

    /// Whether it goes by this.
    pub fn follows(&self, what: Follows) -> bool {
        self.made.as_ref().is_some_and(|made| made.family().follows() == what)
    }

    /// Whether its shape is made of this.
    pub fn acts(&self, what: Acts) -> bool {
        self.made.as_ref().is_some_and(|made| made.family().acts() == what)
    }

    /// What was searched for in its shape.
    pub fn searched(&self) -> Option<(Searched, f64)> {
        self.parts()?.parameter()
    }

    /// Whether it is a shape in time alone, searched for or not, with no column behind it.
    pub fn is_in_time(&self) -> bool {
        self.follows(Follows::Time) || self.follows(Follows::Tone)
    }

    /// Whether it follows the same column in the same way as another, though perhaps late or squared.
    pub fn is_variant_of(&self, other: &Term) -> bool {
        match (self.named(), other.named()) {
            (Some(own), Some(other)) => own.is_variant_of(&other),
            _ => self.id == other.id,
        }
    }

    /// Whether it is the form that its family offers first.
    pub fn is_plain(&self) -> bool {
        self.named().is_none_or(|named| named.is_plain())
    }

    /// The coefficients whose mean is a pure delay, which the magnitude hides while it shows the rest of the effect.
    pub fn hidden_delay(&self) -> &'static [usize] {
        match &self.made {
            Some(made) if !made.parts().form.dip_only => made.family().delay_coefficients(made.parts().form),
            _ => &[],
        }
    }

    /// Its form.
    pub fn form(&self) -> Option<&'static Form> {
        Some(self.parts()?.form)
    }

    /// Name of its column, or of its two; empty where it has none.
    pub fn column(&self) -> &'a str {
        self.parts().map_or("", |parts| parts.column)
    }

    /// Whether a log may hold several of it.
    pub fn is_repeated(&self) -> bool {
        self.form().is_some_and(Form::is_repeated)
    }

    /// Coefficients that the magnitude can show: a pure delay among them is hidden.
    pub fn visible(&self) -> usize {
        self.k() - usize::from(!self.hidden_delay().is_empty())
    }

    /// Whether its shape depends on the reading.
    pub fn reads(&self) -> bool {
        self.made.is_some() && !self.acts(Acts::Added)
    }

    /// Vectors per unit of each coefficient at a sample, µT.
    pub fn shape(&self, sample: usize, at: &Quantities<f64>) -> Shape<f64> {
        let mut shape = no_shape();
        self.write_shape(sample, &mut { *at }, &mut shape);
        shape
    }

    /// Writes them into a shape that is there, with the columns' values put among what it reads: for many terms at one sample.
    pub fn write_shape(&self, sample: usize, at: &mut Quantities<f64>, shape: &mut Shape<f64>) {
        at.inputs = self.inputs.get(sample).copied().unwrap_or_default();
        self.effect.shape(at, shape);
    }

    /// Disturbance at a sample, µT.
    pub fn disturbance(&self, sample: usize, at: &Quantities<f64>) -> Vector3<f64> {
        // The correction of a pure delay turns the vector instead of taking something off.
        if self.effect.delay_s(&self.coefficients).is_some() {
            let shape = self.shape(sample, at);
            return (0..self.k()).map(|c| Vector3::from(shape[c]) * self.coefficients[c]).sum();
        }
        let inputs = self.inputs.get(sample).copied().unwrap_or_default();
        self.effect.disturbance(&Quantities { inputs, ..*at }, &self.coefficients).into()
    }

    /// Whether it has a coefficient that is not zero.
    pub fn stands(&self) -> bool {
        self.coefficients.iter().any(|value| *value != 0.0)
    }

    /// k.
    pub fn k(&self) -> usize {
        self.effect.coefficients().min(MAX_COEFFICIENTS)
    }

    /// The term of one sample.
    pub fn at_sample(&self, sample: usize) -> SampleTerm<'_, f64> {
        SampleTerm {
            effect: self.effect.as_ref(),
            coefficients: self.coefficients,
            inputs: self.inputs.get(sample).copied().unwrap_or_default(),
            bends: self.bends,
        }
    }
}

/// The effect put together once, since every look at every sample asks it; as it was made where it is a program's own, or its
/// column's name is longer than a calibration keeps.
pub fn ready<'a>(made: Made<&'a str>) -> Shared<'a> {
    let known = Registry::BUILT_IN.families().any(|family| family.kind() == made.family().kind());
    let Parts { form, column, reference, parameter } = *made.parts();
    let name = if column.is_empty() { Some(ColumnName::default()) } else { ColumnName::new(column).ok() };
    let built_in =
        name.filter(|_| known).and_then(|column| BuiltIn::of(&Parts { form, column, reference, parameter }));
    match built_in {
        Some(effect) => Arc::<BuiltIn<f64>>::new(effect),
        None => Arc::new(made),
    }
}

/// An effect that gives no rows.
#[derive(Debug, Clone, PartialEq)]
pub enum BadShape {
    /// The shape of this one, an effect of the user's own, is not finite.
    NotFinite(String),
    /// There is no room for this one beside the others.
    NoRoom(String),
}
