//! Open-loop trials: a plan made with a wrong model is executed without feedback.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use serde::Serialize;
use trundle_infer::{InferError, Watch, r2};
use trundle_model::{Model, Prior, Slot};

use crate::{ObservationNoise, Observations, PaperError, PathTask, PbrSettings, fit_physics};

/// Stream of the random numbers of parameter errors.
const PARAMETER_ERROR_STREAM: u64 = 3;

/// Origin of the error of a model.
#[derive(Clone, Copy, Debug)]
pub enum ModelError {
    /// Relative error of the parameters: of the logarithm for positive ones, as a share of the body's size for
    /// places, in rad for angles.
    Perturbed(f64),
    /// The model was fitted to this number of noisy pushes.
    Fitted(usize, ObservationNoise),
}

/// Result of a trial.
#[derive(Clone, Debug, Serialize)]
pub struct OpenLoopOutcome {
    /// r² of the model on test pushes.
    pub r2: f64,
    /// Distance of the last pose from the goal, m.
    pub error: f64,
    /// The same as predicted by the model, m.
    pub planned: f64,
    /// Whether the object touched the obstacle.
    pub touched: bool,
    /// Poses that the model predicts, m, m, rad.
    pub expected: Vec<[f64; 3]>,
    /// Poses of the object, m, m, rad.
    pub poses: Vec<[f64; 3]>,
}

/// An object, a task, and the settings of a trial.
#[derive(Clone, Copy, Debug)]
pub struct OpenLoopTrial<'a> {
    /// The object with all its values.
    pub object: &'a Model,
    /// The task.
    pub task: &'a PathTask,
    /// Number of test pushes.
    pub test_count: usize,
    /// Settings of fits; the seed also determines pushes and parameter errors.
    pub settings: PbrSettings<'a>,
}

impl OpenLoopTrial<'_> {
    /// Runs the trial with a wrong model.
    ///
    /// # Errors
    /// If a model is incomplete, a fit fails, or the user interrupts.
    pub fn run(&self, error: ModelError, watch: &dyn Watch) -> Result<OpenLoopOutcome, PaperError> {
        if watch.cancelled() {
            return Err(PaperError::Infer(InferError::Interrupted));
        }
        let model = match error {
            ModelError::Perturbed(size) => perturbed(self.object, size, self.settings.seed)?,
            ModelError::Fitted(count, noise) => {
                fit_physics(&self.observations(noise, count)?.training, &self.settings, watch)?
            }
        };
        let test = self.observations(ObservationNoise::Wrench(0.0), 0)?.test;
        let plan = self.task.plan(&model)?;
        let (poses, touched) = self.task.execute(self.object, &plan.wrenches)?;
        Ok(OpenLoopOutcome {
            r2: r2(&model.resolved()?, &test),
            error: self.task.final_error(&poses),
            planned: self.task.final_error(&plan.poses),
            touched,
            expected: plan.poses,
            poses,
        })
    }

    fn observations(&self, noise: ObservationNoise, count: usize) -> Result<Observations, PaperError> {
        let (counts, seed) = ([count, self.test_count], self.settings.seed);
        Observations::simulate(self.object, noise, counts, seed, self.task.hold)
    }
}

/// A model with parameter errors of a given size. The same seed gives the same errors up to their size.
fn perturbed(object: &Model, size: f64, seed: u64) -> Result<Model, PaperError> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(PARAMETER_ERROR_STREAM);
    let [low, high] = object.body.bounds();
    let perturbed_value = |slot: Slot| {
        let z: f64 = StandardNormal.sample(&mut rng);
        let value = slot.value.unwrap_or(0.0);
        match slot.prior {
            Prior::LogNormal { .. } => value * (size * z).exp(),
            Prior::OnBody(axis) => value + size * z * (high[axis] - low[axis]),
            Prior::Angle(_) => value + size * z,
            Prior::Normal { sd, .. } => value + size * z * sd,
            Prior::Uniform => value,
        }
    };
    let values: Vec<f64> = object.slots().into_iter().map(perturbed_value).collect();
    Ok(object.with_values(&values)?)
}
