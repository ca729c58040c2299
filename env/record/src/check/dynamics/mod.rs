//! Regression of the wrench on the motion of a passive body, shared by several checks.
//!
//! A passive rigid body obeys `W = M ξ̇ + D ξ + F(ξ) + constants`, whatever its wheels and feet. Its inertia is a sum of
//! positive masses, its damping is symmetric and positive semidefinite, and its dry friction at support points is
//! dissipative. A wrench in wrong axes, units or time violates this equation. The checks correct each suspected mistake,
//! fit again, and compare the unexplained shares.
//!
//! Each row is a mean over a short block, in reading axes about the reference point. A mistake then changes only the
//! left-hand side, and the constants contain the sensor's offset.

mod blocks;
mod cone;
mod normal_equations;
mod regressors;

pub(crate) use blocks::{Blocks, Readings, WINDOWS_PER_EPISODE};
pub(crate) use cone::{Fit, fit};
pub(crate) use normal_equations::{LoadTransform, NormalEquations, identity};
pub(crate) use regressors::Convention;
