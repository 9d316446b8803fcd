//! Which effects a log allows to be tested, and what the others need.

use crate::base::ground::Ground;
use crate::fit::diagnosed::leave_out;
use crate::outcome::request::Options;
use crate::search::candidates::{Catalogue, Untestable};
use crate::table::Table;

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
    let of = |column: &str| {
        let own = catalogue.offered().filter(|named| named.column == column);
        own.map(|named| named.to_string()).collect::<Vec<String>>()
    };
    let columns = catalogue.usable_columns().map(|column| (column.to_string(), of(column))).collect();
    let others = of("");
    Allowed { columns, others, untestable: catalogue.untestable() }
}
