//! What a diagnosis says.

pub mod asked;
pub mod at_rest;
pub mod axes_status;
pub mod blank;
pub mod contradiction;
pub mod explain;
pub mod finish;
pub mod json;
pub mod lower_order;
pub mod outcome;
pub mod request;
pub mod rows;
pub mod shows;
pub mod study;
pub mod transients;
pub mod view;
