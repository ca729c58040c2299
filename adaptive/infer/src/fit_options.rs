//! Settings of a fit.

use std::collections::BTreeSet;

/// Settings of a fit.
#[derive(Clone, Debug)]
pub struct FitOptions {
    /// Number of random starts, in addition to given starts.
    pub starts: usize,
    /// Seed of the random starts.
    pub seed: u64,
    /// Optimiser of each search.
    pub optimiser: Optimiser,
    /// Whether starts may lie far from the optimum. Set to false for starts taken from the fit of a simpler
    /// model.
    pub distant_starts: bool,
    /// If set, the given starts lie near their optima: only these are used, and the best is refined for at
    /// most this many steps.
    pub local_steps: Option<usize>,
    /// Maximum number of rounds in which unstated noise is estimated, each followed by a search.
    pub noise_rounds: usize,
    /// Whether the final search measures the gradient by finite differences where the approximate gradient no
    /// longer leads to a decrease. It has no effect with [`FitOptions::local_steps`].
    pub measure_gradient: bool,
    /// Names of parameters with a separate value in each episode.
    pub per_episode: BTreeSet<String>,
}

/// Gradient-based optimisers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Optimiser {
    /// Levenberg–Marquardt on the Gauss-Newton curvature.
    #[default]
    LevenbergMarquardt,
    /// L-BFGS within bounds, as in the paper; it uses the gradient alone.
    Lbfgs,
}

impl Default for FitOptions {
    fn default() -> Self {
        Self {
            starts: 6,
            seed: 0,
            optimiser: Optimiser::default(),
            distant_starts: true,
            local_steps: None,
            noise_rounds: 2,
            measure_gradient: false,
            per_episode: BTreeSet::new(),
        }
    }
}
