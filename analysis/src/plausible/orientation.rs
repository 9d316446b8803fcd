//! Columns that are an orientation: the parts of a quaternion, of a rotation matrix or of a direction. They are known by what they are,
//! whatever they are called: the sum of their squares is one in every row.

/// Share of the rows in which the sum holds.
const MIN_SHARE: f64 = 0.95;
/// How far the sum may be from one.
const OFF: f64 = 0.02;
/// Rows that are looked at.
const MOST: usize = 2000;
/// Fewer rows say nothing.
const LEAST: usize = 10;

/// What neighbouring columns are together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Orientation {
    /// Nine columns of a rotation matrix.
    Matrix,
    /// Four columns of a quaternion.
    Quaternion,
    /// Three columns of a direction.
    Direction,
}

impl Orientation {
    /// Columns that it takes.
    pub fn width(self) -> usize {
        match self {
            Orientation::Matrix => 9,
            Orientation::Quaternion => 4,
            Orientation::Direction => 3,
        }
    }

    /// As it is said.
    pub fn words(self) -> &'static str {
        match self {
            Orientation::Matrix => "a rotation matrix: its rows have length 1",
            Orientation::Quaternion => "a quaternion: the squares of the four columns sum to 1",
            Orientation::Direction => "a direction: the squares of the three columns sum to 1",
        }
    }
}

/// What begins at the first of these neighbouring columns; `None` where it is not an orientation, or where fewer than two columns change.
pub fn beginning_with(columns: &[&[f64]]) -> Option<Orientation> {
    [Orientation::Matrix, Orientation::Quaternion, Orientation::Direction].into_iter().find(|form| {
        let Some(columns) = columns.get(..form.width()) else { return false };
        let of_length_one = match form {
            Orientation::Matrix => columns.chunks(3).all(have_length_one),
            _ => have_length_one(columns),
        };
        of_length_one && columns.iter().filter(|column| changes(column)).count() >= 2
    })
}

/// Whether the squares of the columns sum to one in nearly every row.
fn have_length_one(columns: &[&[f64]]) -> bool {
    let rows = columns.iter().map(|column| column.len()).min().unwrap_or(0);
    let (mut known, mut one) = (0_usize, 0_usize);
    for row in (0..rows).step_by(rows.div_ceil(MOST).max(1)) {
        let sum: f64 = columns.iter().map(|column| column[row] * column[row]).sum();
        if sum.is_finite() {
            known += 1;
            one += usize::from((sum - 1.0).abs() <= OFF);
        }
    }
    known >= LEAST && one as f64 >= MIN_SHARE * known as f64
}

fn changes(column: &[f64]) -> bool {
    let first = column.first().copied().unwrap_or(f64::NAN);
    column.iter().step_by(column.len().div_ceil(MOST).max(1)).any(|value| (value - first).abs() > OFF)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orientations_are_known_by_their_length() {
        let angle: Vec<f64> = (0..100).map(|i| f64::from(i) * 0.05).collect();
        let of = |value: fn(f64) -> f64| angle.iter().map(|angle| value(*angle)).collect::<Vec<_>>();
        let (cos, sin, minus) = (of(f64::cos), of(f64::sin), of(|angle| -angle.sin()));
        let (zero, one, slow) = (vec![0.0; 100], vec![1.0; 100], of(|angle| 0.1 * angle));
        let matrix: [&[f64]; 9] = [&cos, &minus, &zero, &sin, &cos, &zero, &zero, &zero, &one];
        assert_eq!(beginning_with(&matrix), Some(Orientation::Matrix));
        assert_eq!(beginning_with(&[&cos, &zero, &sin, &zero, &slow]), Some(Orientation::Quaternion));
        assert_eq!(beginning_with(&[&slow, &cos, &sin]), None);
        assert_eq!(beginning_with(&[&one, &zero, &zero, &zero]), None, "nothing changes");
        assert_eq!(beginning_with(&[]), None);
    }
}
