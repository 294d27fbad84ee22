//! From targets, recordings and scans to activations and their certainty.

#[path = "../common/mod.rs"]
mod common;

mod certainty;
mod expected;
mod programs;
mod qp;
mod registration;
mod sparse_effort;
mod starts;
mod targets;
mod tracking;
