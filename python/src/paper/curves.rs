//! Learning curves (Figs. 6 and 8): prediction of noise-free pushes after a number of noisy ones.

use pyo3::prelude::*;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use trundle_infer::{
    ConstantVelocity, InferError, Pushes, SigmaReading, Stage, Transition, Watch, noisy, r2, transitions,
};
use trundle_model::Model;

use super::learners::{Given, Learner, Trouble};
use crate::error::refused;
use crate::watch::{once, watched};

/// Many fits, each of which reports its own share.
const STAGES: [Stage; 1] = once("fit");

pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(_learning_curves, module)?)
}

/// Test pushes are drawn with seeds from here on, far from those of training.
const TEST_SEED: u64 = 1 << 32;

/// Noise on what is observed, as its σ is read.
#[derive(Clone, Copy)]
pub(super) enum Noise {
    /// On the state after.
    State(SigmaReading, f64),
    /// On the wrench: σ N on each force, σ N·m on the torque.
    Wrench(f64),
}

impl Noise {
    pub(super) fn of(reading: &str, sigma: f64) -> Result<Self, Trouble> {
        match reading {
            "si" => Ok(Self::State(SigmaReading::Si, sigma)),
            "cm_deg" => Ok(Self::State(SigmaReading::CentimetreDegree, sigma)),
            "of_motion" => Ok(Self::State(SigmaReading::OfMotion, sigma)),
            "wrench" => Ok(Self::Wrench(sigma)),
            _ => Err(Trouble::Other(format!("{reading:?}: readings are si, cm_deg, of_motion and wrench"))),
        }
    }

    /// Noisy observations of some pushes; σ as a share of the motion is that of the test pushes' motion.
    pub(super) fn add(self, data: &[Transition], test: &[Transition], seed: u64) -> Vec<Transition> {
        match self {
            Self::State(reading, sigma) => noisy(data, &reading.sd(sigma, test), seed),
            Self::Wrench(sigma) => {
                let mut rng = ChaCha8Rng::seed_from_u64(seed);
                rng.set_stream(2);
                let mut one = |w: f64| w + sigma * normal(&mut rng);
                data.iter().map(|t| Transition { wrench: t.wrench.map(&mut one), ..*t }).collect()
            }
        }
    }
}

fn normal(rng: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(rng)
}

/// The same pushes, `dt` seconds each, for everything that is measured on an object: `n` noisy ones to learn from,
/// and the test.
pub(super) fn data(
    truth: &Model,
    noise: Noise,
    n: usize,
    tested: usize,
    seed: u64,
    dt: f64,
) -> Result<(Vec<Transition>, Vec<Transition>), Trouble> {
    let pushes = Pushes { dt, ..Pushes::default() };
    let test = transitions(truth, tested, seed + TEST_SEED, &pushes)?;
    let training = noise.add(&transitions(truth, n, seed, &pushes)?, &test, seed);
    Ok((training, test))
}

/// R² after `counts` observations: for each learner, one a count; and that of no learning.
///
/// `truth` and `form` are texts of `model.toml`: the object, and the model whose free values are learnt.
#[pyfunction]
#[pyo3(signature = (truth, form, learners, counts, noise, seed, *, tested=200, starts=8, progress=None))]
#[expect(clippy::too_many_arguments, reason = "called from one place, by name")]
fn _learning_curves(
    py: Python<'_>,
    truth: &str,
    form: &str,
    learners: Vec<String>,
    counts: Vec<usize>,
    noise: (String, f64),
    seed: u64,
    tested: usize,
    starts: usize,
    progress: Option<Py<PyAny>>,
) -> PyResult<(Vec<Vec<f64>>, f64)> {
    let truth = Model::from_toml(truth).map_err(refused)?.0;
    let form = Model::from_toml(form).map_err(refused)?.0;
    watched(py, progress, &STAGES, |watch| {
        let learners = learners.iter().map(|name| Learner::of(name)).collect::<Result<Vec<_>, _>>()?;
        let dt = Pushes::default().dt;
        let most = counts.iter().copied().max().unwrap_or(0);
        let (training, test) = data(&truth, Noise::of(&noise.0, noise.1)?, most, tested, seed, dt)?;
        let job = Job { training, test, given: Given { form: &form, starts, seed } };
        let scores = job.scores(&learners, &counts, watch)?;
        let rows = scores.chunks(counts.len().max(1)).map(<[f64]>::to_vec).collect();
        Ok((rows, r2(&ConstantVelocity, &job.test)))
    })
}

/// One object, one noise, one seed.
struct Job<'a> {
    training: Vec<Transition>,
    test: Vec<Transition>,
    given: Given<'a>,
}

impl Job<'_> {
    /// A score for each learner and count, the counts of the first learner first. One after another: each fit
    /// uses all cores.
    fn scores(
        &self,
        learners: &[Learner],
        counts: &[usize],
        watch: &dyn Watch,
    ) -> Result<Vec<f64>, InferError> {
        let pairs: Vec<_> = learners.iter().flat_map(|&l| counts.iter().map(move |&n| (l, n))).collect();
        pairs.into_iter().map(|(learner, count)| self.score(learner, count, watch)).collect()
    }

    fn score(&self, learner: Learner, count: usize, watch: &dyn Watch) -> Result<f64, InferError> {
        if watch.cancelled() {
            return Err(InferError::Interrupted);
        }
        let learnt = learner.learn(&self.training[..count.min(self.training.len())], &self.given, watch)?;
        Ok(r2(&*learnt, &self.test))
    }
}
