//! The effects that this program knows: a tool of one's own adds its families here.

use ironout::effect::Registry;

/// Those of the library.
pub const REGISTRY: Registry = Registry::BUILT_IN;
