//! `ironout diagnose`: find the missing effect.

mod advice;
mod conclusion;
mod curve;
mod found;
mod next;
mod numbers;
mod place;
pub mod run;
mod told;
mod words;
