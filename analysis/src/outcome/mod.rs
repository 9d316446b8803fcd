//! What a diagnosis says.

pub mod asked;
pub mod at_rest;
pub mod blank;
pub mod contradiction;
pub mod doubts;
pub mod explain;
pub mod finish;
pub mod json;
pub mod lower_order;
pub mod outcome;
pub mod passes;
pub mod request;
pub mod rows;
pub mod shows;
pub mod standing;
pub mod study;
pub mod view;
