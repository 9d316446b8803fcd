//! The check of the layers, on this workspace and on made ones.

mod findings;
mod workspace;
