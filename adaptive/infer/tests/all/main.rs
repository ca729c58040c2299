//! Tests of the estimator.
#![allow(clippy::unwrap_used, clippy::expect_used)]

mod bandwidth;
mod effects;
mod footprint_prior;
mod friction;
mod gradient;
mod identify;
mod inertial;
mod online;
mod priors;
mod recover;
mod response;
mod sensing;
mod shooting;
mod starts;
mod states;
