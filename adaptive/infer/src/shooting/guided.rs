//! Eq. 9 sees an episode's end alone and has many optima: a fit that also sees the way shows it where to begin.

use crate::{Fit, FitOptions, InferError, Likelihood, Watch, fit};
use trundle_model::Model;

/// A fit under `likelihood` that begins, beside its random starts, where a fit under `guide` ends: for final states
/// ([`super::Cut::Final`]) the same episodes over windows.
///
/// # Errors
/// As [`fit`].
pub fn guided_fit(
    guide: &dyn Likelihood,
    likelihood: &dyn Likelihood,
    model: &Model,
    options: &FitOptions,
    watch: &dyn Watch,
) -> Result<Fit, InferError> {
    let begin = fit(guide, model, &[], options, watch)?.values;
    fit(likelihood, model, &[begin], options, watch)
}
