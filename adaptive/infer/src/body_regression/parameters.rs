//! Parameters of a body regression.

use nalgebra::{SMatrix, SVector};

/// Number of parameters: mass, two first moments, inertia, six entries of the damping matrix, dry friction.
pub(super) const PARAMETERS: usize = 11;
/// Index of the dry friction, N.
pub(super) const DRY_FRICTION: usize = 10;

pub(super) type Parameters = SVector<f64, PARAMETERS>;
pub(super) type Precision = SMatrix<f64, PARAMETERS, PARAMETERS>;

/// Smallest mass, as a fraction of the most probable one before any data.
pub(super) const MIN_MASS_RATIO: f64 = 0.02;
