//! Whether an unnamed wrench predicts training episodes that it was not fitted to: one second ahead, and to the end.

use super::Bench;
use super::regression::Regression;
use rayon::prelude::*;
use trundle_infer::{Fit, InferError, score};
use trundle_record::{Dataset, Prepared};

/// Share of the mean square error one second ahead that it may leave, at most.
const LEAVES: f64 = 0.9;

/// Mean square errors of one episode, m²: one second ahead, and of the whole simulation; a turn counts at the radius of
/// gyration.
type Errors = [f64; 2];

/// What the simulation under test errs by itself.
pub(super) struct Proof<'b, 'a> {
    bench: &'b Bench<'a>,
    before: Vec<Errors>,
}

/// Rounds of fitting parameters and wrench in turn that are tried.
const ROUNDS: [usize; 2] = [0, 2];

impl<'b, 'a> Proof<'b, 'a> {
    /// Of the bench's fit, without an unnamed wrench.
    ///
    /// # Errors
    /// When the fit's values do not suit its model.
    pub fn new(bench: &'b Bench<'a>) -> Result<Self, InferError> {
        let one = |episode| errors(bench.data, bench.fit, episode);
        let before = bench.data.training.par_iter().map(one).collect::<Result<_, _>>()?;
        Ok(Self { bench, before })
    }

    /// Share of the mean square error one second ahead that is left where each episode is predicted by what the others
    /// taught; `None` where that is too much, or more than before in every other episode.
    ///
    /// # Errors
    /// When the fit's values do not suit its model.
    pub fn share(&self, by: &Regression) -> Result<Option<f64>, InferError> {
        let after = self.left_out(by, 0)?;
        let better = after.iter().zip(&self.before).filter(|(after, before)| after[0] < before[0]).count();
        let share = self.shares(&after)[0];
        Ok((share < LEAVES && 2 * better > after.len()).then_some(share))
    }

    /// After how many rounds it predicts best one second ahead, of those after which whole simulations err less as well.
    ///
    /// # Errors
    /// When the user interrupts.
    pub fn rounds(&self, by: &Regression) -> Result<Option<usize>, InferError> {
        let mut best = None;
        let mut least = LEAVES;
        for rounds in ROUNDS {
            let [ahead, whole] = self.shares(&self.left_out(by, rounds)?);
            if ahead < least && whole < 1.0 {
                (least, best) = (ahead, Some(rounds));
            }
        }
        Ok(best)
    }

    /// Errors of each episode, with what the others taught.
    fn left_out(&self, by: &Regression, rounds: usize) -> Result<Vec<Errors>, InferError> {
        let one = |(k, episode): (usize, &Prepared)| match self.bench.settled(Some(k), by, rounds)? {
            Some(fit) => errors(self.bench.data, &fit, episode),
            None => Ok([f64::INFINITY; 2]),
        };
        self.bench.data.training.par_iter().enumerate().map(one).collect()
    }

    fn shares(&self, after: &[Errors]) -> Errors {
        let sum = |all: &[Errors], k: usize| all.iter().map(|e| e[k]).sum::<f64>();
        [0, 1].map(|k| sum(after, k) / sum(&self.before, k))
    }
}

fn errors(data: &Dataset, fit: &Fit, episode: &Prepared) -> Result<Errors, InferError> {
    let episodes = std::slice::from_ref(episode);
    let score = score(&fit.model, &fit.values, &fit.channels, episodes, &data.noise, false)?;
    let rho = fit.model.body.gyration;
    let square = |position: Option<f64>, heading: Option<f64>| {
        position.map_or(f64::INFINITY, |p| p.powi(2) + (rho * heading.unwrap_or(0.0)).powi(2))
    };
    Ok([
        square(score.window_position_rmse, score.window_heading_rmse),
        square(score.position_rmse, score.heading_rmse),
    ])
}
