//! `--repair`, understood.

use ironout_analysis::plausible::breakage::Repair;

/// What `--repair` asks for.
#[derive(Debug, Clone, PartialEq)]
pub enum Asked {
    /// The numbers are taken as they are: nothing is recognised, and no row is set aside.
    Nothing,
    /// One repair.
    One(Repair),
    /// Changes of the range while the log ran, found in each log.
    Range,
}
