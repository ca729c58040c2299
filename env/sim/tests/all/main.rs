//! Tests of the simulator.
#![allow(clippy::unwrap_used, clippy::expect_used)]

mod contact;
mod effects;
mod gripper;
mod object;
mod recording;
mod regrasp;
mod task;
mod world;
