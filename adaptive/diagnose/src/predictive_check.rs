//! Posterior predictive check: the prediction errors one second ahead on the training episodes, relative to
//! the instruments' noise.
//!
//! Model comparison only shows which of several models is better. The best of several wrong models can win by
//! a wide margin, for example with a mass that is eight times too large. A model is therefore named only if
//! its prediction errors agree with its own uncertainty or are small compared with the motion.

use crate::thresholds::{
    MAX_ERROR_RATIO, MAX_ERROR_SHARE, MAX_RESIDUAL_GAIN_SHARE, MIN_MATERIAL_VARIANCES, NEGLIGIBLE_SHARE,
};
use trundle_infer::{Channels, Fit, InferError, Window, windows};
use trundle_record::{Dataset, Prepared};

/// Prediction errors at the ends of one-second windows.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct PredictiveCheck {
    /// Mean square error per direction, in units of the covariance that the instruments' noise explains.
    pub standardised: f64,
    /// Mean square error divided by the mean square motion over a window. Angles count at the radius of
    /// gyration.
    pub share: f64,
}

impl PredictiveCheck {
    /// Whether a better model would predict noticeably better.
    pub fn is_material(&self) -> bool {
        self.is_refuted() || self.is_beyond_noise() && self.share > NEGLIGIBLE_SHARE
    }

    /// Whether the errors exceed the instruments' noise.
    pub fn is_beyond_noise(&self) -> bool {
        self.standardised > MIN_MATERIAL_VARIANCES
    }

    fn is_refuted(&self) -> bool {
        self.standardised > MAX_ERROR_RATIO * MAX_ERROR_RATIO
    }

    /// Whether the errors are too large for the model to be named: compared with the motion, or with the errors of
    /// the nominal model, whose check is `nominal`.
    pub fn is_poor(&self, nominal: &Self) -> bool {
        let largest = MAX_ERROR_SHARE.min(MAX_RESIDUAL_GAIN_SHARE * nominal.share);
        self.is_refuted() && self.share > largest
    }
}

/// Prediction at the end of a one-second window.
pub(crate) struct WindowEnd {
    /// Recorded minus predicted pose.
    pub error: [f64; 3],
    /// The whitened error.
    pub whitened: [f64; 3],
    /// Recorded motion over the window.
    pub motion: [f64; 3],
}

impl PredictiveCheck {
    /// The check over some windows. Angles count at the radius of gyration, m.
    pub fn from_windows(ends: impl Iterator<Item = WindowEnd>, dof: [bool; 3], gyration: f64) -> Self {
        let gyration = if dof[2] { gyration } else { 0.0 };
        let size = |[x, y, theta]: [f64; 3]| x * x + y * y + (gyration * theta).powi(2);
        let (mut chi_squared, mut errors, mut motions, mut count) = (0.0, 0.0, 0.0, 0.0);
        for WindowEnd { error, whitened, motion } in ends {
            chi_squared += whitened.iter().map(|e| e * e).sum::<f64>();
            errors += size(error);
            motions += size(motion);
            count += 1.0;
        }
        let directions = dof.iter().filter(|moves| **moves).count() as f64;
        if count == 0.0 || motions == 0.0 {
            return Self::default();
        }
        Self { standardised: chi_squared / (count * directions), share: errors / motions }
    }
}

/// The predictive check of a fit on its training episodes.
pub(crate) fn predictive_check(data: &Dataset, fit: &Fit) -> Result<PredictiveCheck, InferError> {
    let channels = Channels::of(&data.noise);
    let mut ends = vec![];
    for episode in &data.training {
        let all = windows(&fit.model, &fit.values, &channels, episode, &data.noise)?;
        ends.extend(all.iter().flatten().filter_map(|window| end(window, episode)));
    }
    Ok(PredictiveCheck::from_windows(ends.into_iter(), data.dof, fit.model.body.gyration))
}

fn end(window: &Window, episode: &Prepared) -> Option<WindowEnd> {
    let (first, last) = (window.samples.first()?, window.samples.last()?);
    let observed =
        |t: f64| episode.pose.get(episode.pose.partition_point(|p| p.t < t - 1e-9)).map(|p| p.pose);
    let (from, to) = (observed(first.t)?, observed(last.t)?);
    let motion = [0, 1, 2].map(|k| to[k] - from[k]);
    Some(WindowEnd { error: last.error.into(), whitened: (last.whitener * last.error).into(), motion })
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::{PredictiveCheck, predictive_check};
    use trundle_fixtures::{World, effect, locked};
    use trundle_infer::{Comparison, FitOptions, Quiet, fit};
    use trundle_model::{Effect, Kind, Model};

    fn observed(truth: Model, fitted: &Model) -> PredictiveCheck {
        let data = World::of(truth).recording(1);
        let comparison = Comparison::of(&data).unwrap();
        predictive_check(&data, &fit(&comparison, fitted, &[], &FitOptions::default(), &Quiet).unwrap())
            .unwrap()
    }

    #[test]
    fn only_the_right_model_has_calibrated_errors() {
        let nominal = Model::nominal(trundle_fixtures::table(), None, [true; 3]);
        let right = observed(locked(), &nominal);
        assert!((0.6..1.6).contains(&right.standardised) && !right.is_poor(&right), "{right:?}");
        // Friction that stops the table most of the time.
        let stuck = locked().with(effect(Kind::SupportFriction, &[("force", 25.0), ("spread", 1.0)]));
        let wrong = observed(stuck.clone(), &nominal);
        assert!(wrong.standardised > 9.0 && wrong.is_poor(&wrong), "{wrong:?}");
        let named = observed(stuck, &nominal.with(Effect::free(Kind::SupportFriction)));
        assert!(!named.is_poor(&wrong), "{named:?}");
    }

    #[test]
    fn effects_that_leave_half_of_the_nominal_errors_are_poor() {
        let check = |share: f64| PredictiveCheck { standardised: 100.0, share };
        assert!(check(0.03).is_poor(&check(0.1)) && !check(0.02).is_poor(&check(0.1)));
        let within_noise = PredictiveCheck { standardised: 2.0, ..check(0.03) };
        assert!(!within_noise.is_poor(&check(0.1)));
    }
}
