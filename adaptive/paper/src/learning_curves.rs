//! Learning curves (Figs. 6 and 8): prediction of noise-free pushes after a number of noisy ones.

use trundle_infer::{ConstantVelocity, InferError, Pushes, Watch, r2};
use trundle_model::Model;

use crate::{Learner, ObservationNoise, Observations, PaperError, PbrSettings};

/// Scores of learners after numbers of training pushes.
#[derive(Clone, Debug, PartialEq)]
pub struct LearningCurves {
    /// r² of each learner (rows) after each number of training pushes (columns).
    pub r2: Vec<Vec<f64>>,
    /// r² of the prediction of a constant velocity.
    pub baseline: f64,
}

/// Scores `learners` after the numbers `counts` of noisy pushes of `object`, on `test_count` noise-free ones.
/// Fits run one after another, because each uses all cores.
///
/// # Errors
/// If a value of `object` is free, a fit fails, or the user interrupts.
pub fn learning_curves(
    object: &Model,
    learners: &[Learner],
    counts: &[usize],
    (noise, test_count): (ObservationNoise, usize),
    settings: &PbrSettings<'_>,
    watch: &dyn Watch,
) -> Result<LearningCurves, PaperError> {
    let largest = counts.iter().copied().max().unwrap_or(0);
    let dt = Pushes::default().dt;
    let data = Observations::simulate(object, noise, [largest, test_count], settings.seed, dt)?;
    let score = |learner: Learner, count: usize| {
        if watch.cancelled() {
            return Err(PaperError::Infer(InferError::Interrupted));
        }
        let training = &data.training[..count.min(data.training.len())];
        Ok(r2(&*learner.learn(training, settings, watch)?, &data.test))
    };
    let curve = |&learner: &Learner| counts.iter().map(|&count| score(learner, count)).collect();
    let r2_by_learner = learners.iter().map(curve).collect::<Result<_, PaperError>>()?;
    Ok(LearningCurves { r2: r2_by_learner, baseline: r2(&ConstantVelocity, &data.test) })
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use trundle_infer::{Features, Quiet};
    use trundle_model::{Body, Effect, Kind};

    fn square() -> Model {
        let corners = [[-0.3, -0.3], [0.3, -0.3], [0.3, 0.3], [-0.3, 0.3]];
        Model::nominal(Body::from_footprint(&corners, 10.0).unwrap(), Some(10.0), [true; 3])
    }

    #[test]
    fn physics_learns_from_fewer_pushes_than_regression() {
        let wheel = [("x", 0.2), ("y", 0.1), ("angle", 0.4), ("mu_x", 1.0), ("mu_y", 40.0)];
        let wheel = wheel.iter().fold(Effect::free(Kind::ViscousWheel), |e, (k, v)| e.with(k, Some(*v)));
        let object = Model { effects: vec![wheel], ..square() };
        let form = Model::nominal(object.body.clone(), None, [true; 3]);
        let settings = PbrSettings { model: &form, starts: 6, seed: 1 };
        let learners = [Learner::Physics, Learner::Linear(Features::Body)];
        let noise = (ObservationNoise::Wrench(0.0), 50);
        let found = learning_curves(&object, &learners, &[8, 20], noise, &settings, &Quiet).unwrap();
        assert!(found.r2[0][1] > 0.999, "{found:?}");
        assert!(found.r2[0][0] > found.r2[1][0], "{found:?}");
        assert!(found.baseline < found.r2[0][0], "{found:?}");
    }

    #[test]
    fn unknown_names_are_errors() {
        let error = Learner::named("svm").unwrap_err().to_string();
        assert_eq!(error, "\"svm\": choose one of pbr, lr, lwr, lr_body and lwr_body");
        assert!(ObservationNoise::named("mm", 1.0).unwrap_err().to_string().contains("cm_deg"));
    }
}
