//! Which effects a log allows to be tested, and what the others need.

use crate::base::ground::Ground;
use crate::fit::diagnosed::leave_out;
use crate::outcome::request::Options;
use crate::search::candidates::{Catalogue, Untestable};
use crate::table::Table;
use ironout::effect::Named;

/// The effects of a log.
#[derive(Debug, Clone, PartialEq)]
pub struct Allowed {
    /// Each column that effects can use, with the ids of those effects.
    pub columns: Vec<(String, Vec<String>)>,
    /// Effects that need no column.
    pub others: Vec<String>,
    /// Effects that cannot be tested, with the reason.
    pub untestable: Vec<Untestable>,
}

/// The effects that a log allows, without a search.
pub fn allowed(table: &Table, options: &Options) -> Allowed {
    let mut ground = Ground::of(table, options.method, options.scale_ut(), options.dip_deg);
    leave_out(&mut ground, &Options { search: true, ..options.clone() });
    let catalogue = Catalogue::new(&ground.counted.samples, table, options.registry);
    let plain: Vec<String> = catalogue.plain(false).into_iter().map(|term| term.id).collect();
    let column_of = |id: &str| {
        let named = options.registry.parse(id).filter(|named| named.form.column)?;
        Some(named.column.to_string())
    };
    let columns = catalogue.usable_columns().map(|column| {
        let fixed = plain.iter().filter(|id| column_of(id).as_deref() == Some(column)).cloned();
        (column.to_string(), fixed.chain(catalogue.late(column).iter().map(Named::to_string)).collect())
    });
    let columns = columns.collect();
    let others = plain.iter().filter(|id| column_of(id).is_none()).cloned();
    let others = others.chain(catalogue.searched().iter().map(Named::to_string)).collect();
    Allowed { columns, others, untestable: catalogue.untestable() }
}
