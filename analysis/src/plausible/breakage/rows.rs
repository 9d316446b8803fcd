//! One repair for several axes.

use super::evidence::Breakage;
use super::repair::Repair;

/// Joins the same repair of several axes into one.
pub fn joined(list: &mut Vec<Breakage>, numbers: [&[f64]; 3]) {
    let mut out: Vec<Breakage> = Vec::new();
    for next in list.drain(..) {
        match out.iter_mut().find(|known| same_kind(&known.repair, &next.repair)) {
            Some(known) => {
                add_axes(&mut known.repair, next.repair.axes());
                known.rows = known.rows.max(next.rows);
                known.first_row = known.first_row.min(next.first_row);
                known.explained = known.explained.min(next.explained);
            }
            None => out.push(next),
        }
    }
    for found in &mut out {
        // An axis of the same sensor that never crosses zero shows no jump, and is read in the same way.
        if let Repair::Unsigned { axes, modulus } = &mut found.repair {
            for (is, values) in axes.iter_mut().zip(numbers) {
                *is |= values.iter().all(|value| (0.0..*modulus).contains(value));
            }
        }
    }
    *list = out;
}

fn same_kind(a: &Repair, b: &Repair) -> bool {
    let near = |a: f64, b: f64| (a - b).abs() <= 1e-3 * a.abs();
    match (a, b) {
        (Repair::Unsigned { modulus: a, .. }, Repair::Unsigned { modulus: b, .. }) => near(*a, *b),
        (Repair::SwappedBytes { step: a, .. }, Repair::SwappedBytes { step: b, .. }) => near(*a, *b),
        (Repair::SignedLowByte { step: a, .. }, Repair::SignedLowByte { step: b, .. }) => near(*a, *b),
        _ => false,
    }
}

fn add_axes(repair: &mut Repair, more: [bool; 3]) {
    if let Repair::Unsigned { axes, .. }
    | Repair::SwappedBytes { axes, .. }
    | Repair::SignedLowByte { axes, .. } = repair
    {
        for (own, more) in axes.iter_mut().zip(more) {
            *own |= more;
        }
    }
}
