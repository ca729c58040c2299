//! The wrench that the motion explains: one regression that several checks share.
//!
//! Whatever its wheels and feet, a passive rigid body obeys `W = M ξ̇ + D ξ + F(ξ) + constants`, with an inertia of
//! positive masses, a symmetric positive semidefinite damping and dry friction at points that only brakes. A reading in
//! wrong axes, units or time does not fit that. So each suspected mistake is undone, the law is fitted again, and the
//! share of the load that stays unexplained decides.
//!
//! Rows are means over short blocks of both sides, in reading axes about the reading's point: a mistake then changes
//! the left side alone, and the constants are the sensor's offset.

mod blocks;
mod cone;
mod moments;
mod regressors;

pub(crate) use blocks::{Blocks, Readings, WINDOWS};
pub(crate) use cone::{Fit, fit};
pub(crate) use moments::{Linear, Moments, identity};
pub(crate) use regressors::Convention;
