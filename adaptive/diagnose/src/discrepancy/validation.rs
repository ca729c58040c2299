//! Leave-one-episode-out validation of a discrepancy wrench, one second ahead and over whole episodes.

use super::fitter::Fitter;
use super::regression::Regression;
use rayon::prelude::*;
use trundle_infer::{Fit, InferError, score};
use trundle_record::{Dataset, Prepared};

/// Maximum mean square error one second ahead, relative to the nominal model.
const MAX_RELATIVE_ERROR: f64 = 0.9;

/// Mean square errors of one episode, m²: one second ahead, and over the whole simulation. Headings count at the
/// radius of gyration.
type Errors = [f64; 2];

/// Validation errors in comparison with those of the nominal model.
pub(super) struct Validation<'b, 'a> {
    fitter: &'b Fitter<'a>,
    before: Vec<Errors>,
}

/// Numbers of rounds, in which parameters and wrench are fitted alternately, that are tried.
const ROUND_CHOICES: [usize; 2] = [0, 2];

impl<'b, 'a> Validation<'b, 'a> {
    /// Computes the errors without a discrepancy.
    ///
    /// # Errors
    /// If the fit's values do not suit its model.
    pub fn new(fitter: &'b Fitter<'a>) -> Result<Self, InferError> {
        let one = |episode| errors(fitter.data, fitter.fit, episode);
        let before = fitter.data.training.par_iter().map(one).collect::<Result<_, _>>()?;
        Ok(Self { fitter, before })
    }

    /// Relative mean square error one second ahead, where each episode is predicted by a fit to the others. `None` if
    /// it is too large, or unless most episodes improve.
    ///
    /// # Errors
    /// If the fit's values do not suit its model.
    pub fn relative_error(&self, by: &Regression) -> Result<Option<f64>, InferError> {
        let after = self.leave_one_out_errors(by, 0)?;
        let better = after.iter().zip(&self.before).filter(|(after, before)| after[0] < before[0]).count();
        let error = self.relative_errors(&after)[0];
        Ok((error < MAX_RELATIVE_ERROR && 2 * better > after.len()).then_some(error))
    }

    /// Number of rounds with the smallest relative error one second ahead, among those that also improve whole
    /// simulations.
    ///
    /// # Errors
    /// If the user interrupts.
    pub fn rounds(&self, by: &Regression) -> Result<Option<usize>, InferError> {
        let mut best = None;
        let mut smallest = MAX_RELATIVE_ERROR;
        for rounds in ROUND_CHOICES {
            let [ahead, whole] = self.relative_errors(&self.leave_one_out_errors(by, rounds)?);
            if ahead < smallest && whole < 1.0 {
                (smallest, best) = (ahead, Some(rounds));
            }
        }
        Ok(best)
    }

    /// Errors of each episode with a fit to the others.
    fn leave_one_out_errors(&self, by: &Regression, rounds: usize) -> Result<Vec<Errors>, InferError> {
        let one = |(k, episode): (usize, &Prepared)| match self.fitter.fit(Some(k), by, rounds)? {
            Some(fit) => errors(self.fitter.data, &fit, episode),
            None => Ok([f64::INFINITY; 2]),
        };
        self.fitter.data.training.par_iter().enumerate().map(one).collect()
    }

    fn relative_errors(&self, after: &[Errors]) -> Errors {
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
