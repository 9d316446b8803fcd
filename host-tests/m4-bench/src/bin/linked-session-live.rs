//! Session, and correction with effects: see `linked`.
#![no_std]
#![no_main]

ironout_m4_bench::linked_program!(session_live);
