//! Facial biomechanics: a linear finite-element face whose muscles push by their curvature, and the
//! inverse that finds the bounded activations behind an expression.

#![cfg_attr(not(test), warn(clippy::unwrap_used, clippy::print_stdout))]

pub mod calibration;
pub mod certainty;
pub mod contact;
pub mod face;
pub mod forward;
pub mod inverse;
pub mod io;
pub mod mesh;
pub mod qp;
pub mod recording;
pub mod registration;
pub mod render;
pub mod report;
pub mod study;
pub mod units;

/// The example of README.md is a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
