//! Missing wrenches along the episodes of a recording.

use crate::locate::Residuals;
use serde::Serialize;

/// Recorded and needed wrench, object axes, N, N, N·m.
#[derive(Clone, Debug, Serialize)]
pub struct Wrench {
    /// Times, s.
    pub t: Vec<f64>,
    /// Recorded wrench.
    pub recorded: Vec<[f64; 3]>,
    /// Wrench that the nominal model needs.
    pub before: Vec<[f64; 3]>,
    /// Wrench that the model with the named effects needs.
    pub after: Vec<[f64; 3]>,
}

/// Missing wrenches of the training and the held-out episodes.
pub(crate) struct MissingWrenches {
    pub training: Option<Residuals>,
    pub held_out: Option<Residuals>,
}
