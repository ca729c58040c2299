//! Tests of models and their plant.
#![allow(clippy::unwrap_used, clippy::expect_used)]

mod derivatives;
mod discrepancy;
mod inner;
mod loads;
mod plant;
mod room;
