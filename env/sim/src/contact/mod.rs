//! Contact of one body with fixed obstacles, without a physics engine.
//!
//! [`ContactStepper`] gives the motion of [`crate::World`] at a small part of its cost: it has no broad phase, islands or
//! queries, and allocates nothing in a step. `tests/all/contact.rs` compares both.

mod closest;
mod manifold;
mod shape;
mod solver;
mod stepper;
mod vector;

pub(crate) use stepper::{CONTACT_DISTANCE_M, ContactState, ContactStepper};
