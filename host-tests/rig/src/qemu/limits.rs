//! What the emulated sensor can show.

/// The largest field per axis that the emulated sensor takes. Below zero it takes none.
pub const MAX_FIELD_UT: f64 = 186.0;
