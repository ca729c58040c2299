//! Guided fit: eq. 9 compares only the end of an episode and has many optima. A fit to the whole path
//! provides the start.

use crate::{Fit, FitOptions, InferError, Likelihood, Watch, fit};
use trundle_model::Model;

/// Fit under `likelihood` from random starts and from the estimate of a fit under `guide`. For final states
/// ([`super::Cut::Final`]), the guide compares the same episodes over windows.
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
