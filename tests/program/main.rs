//! The program as its users meet it, and the structure of its source.

#[path = "../common/mod.rs"]
mod common;

mod arrows;
mod cli;
mod killed;
mod patients;
mod render;
mod report;
