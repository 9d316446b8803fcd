//! What the board measures beside field and motion.

use heapless::Vec;

use crate::effect::ColumnName;
use crate::protocol::Assigned;

/// The most columns of a board's own: two temperatures, and three pins.
pub const MAX_OWN: usize = 5;
/// The column of the sensor's temperature, ...
pub(super) const TEMPERATURE: &str = "temp_c";
/// ... and of the processor's.
const PROCESSOR: &str = "cpu_temp_c";

/// Where a column of the board's own comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Origin {
    /// A part of the board: it is in every log.
    Inside,
    /// A pin that perhaps nothing is wired to: it is in a log once it is asked for, or in use.
    Pin,
}

/// Whether a column is tested.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Wish {
    /// The sensor's temperature is, or the processor's where that has none.
    None,
    /// `cov NAME=on`
    Tested,
    /// `cov NAME=-`
    Not,
    /// Another value is fed in its place.
    ByHand,
}

#[derive(Debug, Clone, Copy)]
struct Own {
    name: ColumnName,
    value: f32,
    wish: Wish,
}

/// The columns and their last values.
#[derive(Debug, Clone)]
pub(super) struct OwnColumns(Vec<Own, MAX_OWN>);

impl OwnColumns {
    pub(super) const fn new() -> Self {
        Self(Vec::new())
    }

    fn of(&self, name: &str) -> Option<&Own> {
        self.0.iter().find(|own| own.name.as_str() == name)
    }

    /// A column was measured. Its name, and whether it is tested; `None` where another value stands in its place, or there is no room.
    pub(super) fn measured(
        &mut self,
        name: &str,
        value: f32,
        no_temperature: bool,
    ) -> Option<(ColumnName, bool)> {
        let place = match self.0.iter().position(|own| own.name.as_str() == name) {
            Some(place) => place,
            None => {
                let name = ColumnName::new(name).ok()?;
                self.0.push(Own { name, value, wish: Wish::None }).ok()?;
                self.0.len() - 1
            }
        };
        let own = self.0.get_mut(place)?;
        own.value = value;
        let is_tested = match own.wish {
            Wish::ByHand => return None,
            Wish::None => name == TEMPERATURE || (name == PROCESSOR && no_temperature),
            Wish::Tested => true,
            Wish::Not => false,
        };
        Some((own.name, is_tested))
    }

    /// What `cov` says of one; of any other, nothing. The sensor's temperature may be fed before it was measured.
    pub(super) fn assign(&mut self, name: &str, assigned: Assigned) {
        let Some(own) = self.0.iter_mut().find(|own| own.name.as_str() == name) else {
            if let (TEMPERATURE, Assigned::Value(value), Ok(name)) = (name, assigned, ColumnName::new(name)) {
                let _ = self.0.push(Own { name, value: value as f32, wish: Wish::ByHand });
            }
            return;
        };
        own.wish = match (assigned, own.wish) {
            (Assigned::Value(_), _) => Wish::ByHand,
            (Assigned::Own, _) => Wish::Tested,
            (Assigned::Forgotten, Wish::ByHand) => Wish::None,
            (Assigned::Forgotten, _) => Wish::Not,
        };
    }

    /// The last value of one.
    pub(super) fn value(&self, name: &str) -> Option<f32> {
        self.of(name).map(|own| own.value)
    }

    /// Their names.
    pub(super) fn names(&self) -> impl Iterator<Item = &str> {
        self.0.iter().map(|own| own.name.as_str())
    }
}
