//! Columns that move together: several channels of one cause.

use crate::samples::samples::Samples;
use ironout::effect::ColumnKind;

/// Columns are of one family from this correlation on.
const TOGETHER: f64 = 0.8;
/// So many make a family whatever their names; two do if their names differ in a number only.
const FAMILY: usize = 3;

/// Which columns move together, and which of each family stands for what they have in common.
#[derive(Debug, Clone, Default)]
pub struct Families {
    /// Name, family, and whether it is the centre of the family.
    members: Vec<(String, usize, bool)>,
}

fn without_digits(name: &str) -> String {
    name.chars().filter(|letter| !letter.is_ascii_digit()).collect()
}

/// Correlations of the columns that can be tested; zero for the others.
fn correlations(samples: &Samples) -> Vec<Vec<f64>> {
    let columns = &samples.columns;
    let n = samples.len().max(1) as f64;
    let spread: Vec<f64> = columns
        .iter()
        .map(|column| (column.mean_square - column.mean * column.mean).max(0.0).sqrt())
        .collect();
    let mut table = vec![vec![0.0; columns.len()]; columns.len()];
    for i in 0..columns.len() {
        for j in 0..i {
            let (a, b) = (&columns[i], &columns[j]);
            if a.problem.is_some() || b.problem.is_some() || spread[i] * spread[j] <= 0.0 {
                continue;
            }
            let sum: f64 = a.values.iter().zip(&b.values).map(|(x, y)| (x - a.mean) * (y - b.mean)).sum();
            let value = sum / n / (spread[i] * spread[j]);
            (table[i][j], table[j][i]) = (value, value);
        }
    }
    table
}

impl Families {
    /// Of the columns of a log.
    pub fn of(samples: &Samples) -> Families {
        let table = correlations(samples);
        let count = samples.columns.len();
        let mut taken = vec![false; count];
        let mut members = Vec::new();
        let mut family = 0;
        loop {
            // The column with the most company, and among those the one that is nearest to it.
            let company = |i: usize| -> Vec<usize> {
                (0..count).filter(|&j| j != i && !taken[j] && table[i][j].abs() > TOGETHER).collect()
            };
            let nearness = |i: usize| company(i).iter().map(|&j| table[i][j].abs()).sum::<f64>();
            let centre = (0..count).filter(|&i| !taken[i]).max_by(|&a, &b| {
                company(a).len().cmp(&company(b).len()).then(nearness(a).total_cmp(&nearness(b)))
            });
            let Some(centre) = centre else { break };
            let mut others = company(centre);
            let name = |i: usize| samples.columns[i].name.as_str();
            if others.len() + 1 < FAMILY {
                others.retain(|&j| without_digits(name(j)) == without_digits(name(centre)));
            }
            taken[centre] = true;
            if others.is_empty() {
                continue;
            }
            // A current has the field itself; a command and the speed of a motor follow it.
            let is_current = |i: &usize| ColumnKind::of(name(*i)) == ColumnKind::Current;
            let central = Some(centre).filter(is_current).or_else(|| {
                let mut currents = others.iter().copied().filter(is_current);
                currents.next().filter(|_| currents.next().is_none())
            });
            let central = central.unwrap_or(centre);
            for j in std::iter::once(centre).chain(others) {
                taken[j] = true;
                members.push((name(j).to_string(), family, j == central));
            }
            family += 1;
        }
        Families { members }
    }

    fn family(&self, column: &str) -> Option<usize> {
        self.members.iter().find(|(name, ..)| name == column).map(|(_, family, _)| *family)
    }

    /// The column that stands for the family of this one; itself where it has none.
    pub fn centre<'s>(&'s self, column: &'s str) -> &'s str {
        let Some(family) = self.family(column) else { return column };
        self.members.iter().find(|(_, of, centre)| *of == family && *centre).map_or(column, |(name, ..)| name)
    }
}
