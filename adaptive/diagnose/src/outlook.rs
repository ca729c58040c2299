//! How a model predicts one second ahead on the training episodes, by the noise of the instruments.
//!
//! What is compared elsewhere is which model is better. The best of bad ones can still win, and by a wide
//! margin, with a mass eight times too large. So a name must also stand for a model whose predictions are
//! good: of the size of error that it claims itself, or at least small beside the motion.

use crate::thresholds::{MATERIAL_SHARE, MATERIAL_VARIANCES, POOR, REFUTED};
use nalgebra::Vector3;
use trundle_infer::{Channels, Fit, InferError, Window, windows};
use trundle_record::{Dataset, Prepared};

/// Prediction errors at the ends of one-second windows.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Outlook {
    /// Mean square in units of the covariance that the instruments' noise explains, per direction.
    pub standardised: f64,
    /// Mean square as a share of that of the motion over the window, a turn counted at the radius of gyration.
    pub share: f64,
}

impl Outlook {
    /// Whether the errors are large enough that a better model would predict better.
    pub fn is_material(&self) -> bool {
        self.is_refuted() || self.standardised > MATERIAL_VARIANCES && self.share > MATERIAL_SHARE
    }

    fn is_refuted(&self) -> bool {
        self.standardised > REFUTED * REFUTED
    }

    /// Whether a model must not be named.
    pub fn is_poor(&self) -> bool {
        self.is_refuted() && self.share > POOR
    }
}

/// How a fit predicts its own training episodes.
pub(crate) fn outlook(data: &Dataset, fit: &Fit) -> Result<Outlook, InferError> {
    let channels = Channels::of(&data.noise);
    let rho = if data.dof[2] { fit.model.body.gyration } else { 0.0 };
    let size = |[x, y, theta]: [f64; 3]| x * x + y * y + (rho * theta).powi(2);
    let (mut chi, mut left, mut moved, mut count) = (0.0, 0.0, 0.0, 0.0);
    for episode in &data.training {
        for window in windows(&fit.model, &fit.values, &channels, episode, &data.noise)? {
            let Some((error, whitened, motion)) = window.as_ref().and_then(|w| end(w, episode)) else {
                continue;
            };
            chi += whitened.norm_squared();
            left += size(error.into());
            moved += size(motion);
            count += 1.0;
        }
    }
    let directions = data.dof.iter().filter(|moves| **moves).count() as f64;
    if count == 0.0 || moved == 0.0 {
        return Ok(Outlook::default());
    }
    Ok(Outlook { standardised: chi / (count * directions), share: left / moved })
}

/// Error at the end of a window, the same whitened, and the motion seen over the window.
fn end(window: &Window, episode: &Prepared) -> Option<(Vector3<f64>, Vector3<f64>, [f64; 3])> {
    let (first, last) = (window.samples.first()?, window.samples.last()?);
    let seen = |t: f64| episode.pose.get(episode.pose.partition_point(|p| p.t < t - 1e-9)).map(|p| p.pose);
    let (from, to) = (seen(first.t)?, seen(last.t)?);
    Some((last.error, last.whitener * last.error, [0, 1, 2].map(|k| to[k] - from[k])))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::{Outlook, outlook};
    use crate::common::{self, World, effect, locked};
    use trundle_infer::{Comparison, FitOptions, Quiet, fit};
    use trundle_model::{Effect, Kind, Model};

    fn seen(truth: Model, fitted: &Model) -> Outlook {
        let data = World::of(truth).recording(1);
        let comparison = Comparison::of(&data).unwrap();
        outlook(&data, &fit(&comparison, fitted, &[], &FitOptions::default(), &Quiet).unwrap()).unwrap()
    }

    #[test]
    fn a_right_model_errs_as_it_claims_and_a_wrong_one_does_not() {
        let nominal = Model::nominal(common::table(), None, [true; 3]);
        let right = seen(locked(), &nominal);
        assert!((0.6..1.6).contains(&right.standardised) && !right.is_poor(), "{right:?}");
        // Friction that holds the table most of the time.
        let stuck = locked().with(effect(Kind::SupportFriction, &[("force", 25.0), ("spread", 1.0)]));
        let wrong = seen(stuck.clone(), &nominal);
        assert!(wrong.standardised > 9.0 && wrong.is_poor(), "{wrong:?}");
        let named = seen(stuck, &nominal.with(Effect::free(Kind::SupportFriction)));
        assert!(!named.is_poor(), "{named:?}");
    }
}
