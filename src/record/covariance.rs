//! How the errors of offset and matrix hang together, as a record keeps it: in single precision.

#[cfg(feature = "record")]
use super::layout::{COVARIANCE_BYTES, Reader, Writer};
use crate::fit::Spread;

/// Numbers in the upper triangle of nine by nine.
const ENTRIES: usize = PARAMETERS * (PARAMETERS + 1) / 2;
#[cfg(feature = "record")]
const _: () = assert!(ENTRIES * size_of::<f32>() == COVARIANCE_BYTES);
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
    #[inline(never)]
    pub(super) fn of_spread(spread: &Spread) -> Option<Self> {
        let mut kept = Self([0.0; ENTRIES]);
        let mut entries = kept.0.iter_mut();
        for row in 0..PARAMETERS {
            for (column, entry) in (row..PARAMETERS).zip(&mut entries) {
                *entry = spread.product(row, column) as f32;
            }
        }
        kept.is_sound().then_some(kept)
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

    #[inline(never)]
    fn is_sound(&self) -> bool {
        let (mut diagonal, mut row_length) = (0, PARAMETERS);
        for (place, value) in self.0.iter().enumerate() {
            let is_variance = place == diagonal;
            if is_variance {
                diagonal += row_length;
                row_length -= 1;
            }
            if !value.is_finite() || is_variance && !(*value > 0.0) {
                return false;
            }
        }
        true
    }

    #[cfg(feature = "record")]
    pub(super) fn write(&self, writer: &mut Writer) {
        self.0.iter().for_each(|value| writer.put(&value.to_le_bytes()));
    }

    /// `None` where the bytes are none.
    #[cfg(feature = "record")]
    pub(super) fn read(reader: &mut Reader<'_>) -> Option<Self> {
        let mut kept = Self([0.0; ENTRIES]);
        for entry in &mut kept.0 {
            *entry = reader.single().ok()?;
        }
        kept.is_sound().then_some(kept)
    }
}
