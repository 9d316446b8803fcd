//! Pairs of columns, by the names that ids of products give them.

use ironout::effect::MAX_COLUMN_NAME;
use std::sync::Arc;

/// Each two different columns as `ONE*OTHER`, in both orders, as far as a calibration can hold the name.
pub fn pairs(columns: &[&str]) -> Arc<Vec<String>> {
    let each = columns.iter().flat_map(|one| columns.iter().map(move |other| (one, other)));
    let different = each.filter(|(one, other)| one != other);
    let fits = different.filter(|(one, other)| one.len() + other.len() < MAX_COLUMN_NAME);
    Arc::new(fits.map(|(one, other)| format!("{one}*{other}")).collect())
}
