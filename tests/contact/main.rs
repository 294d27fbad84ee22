//! Surfaces that touch, and what that does to a face and to a fit.

#[path = "../common/mod.rs"]
mod common;

mod barrier_contact;
mod contact_forward;
mod contact_points;
mod contact_settled;
mod inverse_contact;
mod surfaces;
