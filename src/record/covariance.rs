//! How the errors of offset and matrix hang together, as a record keeps it: in single precision.

use super::layout::{COVARIANCE_BYTES, Reader, Writer};
use crate::fit::Spread;

/// Numbers in the upper triangle of nine by nine.
const ENTRIES: usize = COVARIANCE_BYTES / size_of::<f32>();
/// Parameters: three of the offset, and the matrix's six from the diagonal on, row by row.
const PARAMETERS: usize = 9;

/// The covariance of `offset_ut[0…2]` and the matrix's upper triangle, row by row, in µT and 1.
///
/// ```
/// use ironout::record::Covariance;
/// let unit: [[f64; 9]; 9] = core::array::from_fn(|i| core::array::from_fn(|k| f64::from(u8::from(i == k))));
/// assert_eq!(Covariance::of(&unit).map(|kept| kept.matrix()), Some(unit));
/// assert_eq!(Covariance::of(&[[f64::NAN; 9]; 9]), None);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Covariance([f32; ENTRIES]);

impl Covariance {
    /// Of a symmetric matrix; `None` where it is none of a covariance that can be kept: not finite in single precision, or a variance
    /// that is not positive.
    pub fn of(matrix: &[[f64; PARAMETERS]; PARAMETERS]) -> Option<Self> {
        let mut kept = Self([0.0; ENTRIES]);
        let upper = matrix.iter().enumerate().flat_map(|(i, row)| row.iter().skip(i));
        kept.0.iter_mut().zip(upper).for_each(|(entry, value)| *entry = *value as f32);
        kept.is_sound().then_some(kept)
    }

    /// Of the spread that a fit has.
    pub(super) fn of_spread(spread: &Spread) -> Option<Self> {
        Self::of(&spread.covariance())
    }

    /// The rows of the upper triangle, each from its diagonal on: nine numbers, then eight, and so on.
    pub fn rows(&self) -> impl Iterator<Item = &[f32]> {
        let mut rest = self.0.as_slice();
        (0..PARAMETERS).map(move |row| {
            let (own, others) = rest.split_at_checked(PARAMETERS - row).unwrap_or((rest, &[]));
            rest = others;
            own
        })
    }

    /// The whole matrix.
    pub fn matrix(&self) -> [[f64; PARAMETERS]; PARAMETERS] {
        let mut matrix = [[0.0; PARAMETERS]; PARAMETERS];
        for (i, row) in self.rows().enumerate() {
            for (k, value) in (i..).zip(row) {
                for (r, c) in [(i, k), (k, i)] {
                    if let Some(entry) = matrix.get_mut(r).and_then(|row| row.get_mut(c)) {
                        *entry = f64::from(*value);
                    }
                }
            }
        }
        matrix
    }

    fn is_sound(&self) -> bool {
        self.0.iter().all(|value| value.is_finite())
            && self.rows().all(|row| row.first().is_some_and(|variance| *variance > 0.0))
    }

    pub(super) fn write(&self, writer: &mut Writer) {
        self.0.iter().for_each(|value| writer.put(&value.to_le_bytes()));
    }

    /// `None` where the bytes are none.
    pub(super) fn read(reader: &mut Reader<'_>) -> Option<Self> {
        let mut kept = Self([0.0; ENTRIES]);
        for entry in &mut kept.0 {
            *entry = reader.single().ok()?;
        }
        kept.is_sound().then_some(kept)
    }
}
