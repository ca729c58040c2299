//! Tests of recordings.
#![allow(clippy::unwrap_used, clippy::expect_used)]

mod fuzz;
mod joints;
mod parquet;
mod refusals;
mod round_trip;
mod sample;
mod streams;
