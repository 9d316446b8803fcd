//! A reading outside the range that an effect was fitted over.

use crate::math::Real;

/// A column that is now outside the values that an effect was fitted over: further than the range is wide the effect is
/// held, and its error grows with the distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outside<'a, T> {
    /// The effect's place in the calibration.
    pub effect: usize,
    /// The place of the column among the effect's.
    pub input: usize,
    /// The column.
    pub column: &'a str,
    /// What the effect goes by now, in the column's unit: of a column that acts late, its value of a while ago.
    pub value: T,
    /// The least and the greatest value that the effect was fitted over.
    pub range: [T; 2],
}

impl<'a, T: Real> Outside<'a, T> {
    /// `None` where the value lies inside, or is not known.
    pub(super) fn of(
        (effect, input): (usize, usize),
        column: &'a str,
        value: T,
        range: [T; 2],
    ) -> Option<Self> {
        let [least, most] = range;
        (value < least || value > most).then_some(Self { effect, input, column, value, range })
    }

    /// The end of the range that is nearer.
    pub fn nearest(&self) -> T {
        let [least, most] = self.range;
        if self.value < least { least } else { most }
    }

    /// How far outside, in the column's unit; positive.
    pub fn distance(&self) -> T {
        (self.value - self.nearest()).abs()
    }
}
