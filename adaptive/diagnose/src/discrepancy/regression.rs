//! Weights of a discrepancy wrench by ridge regression on the whitened innovations.
//!
//! At the fit, the innovations are linear in the weights, and a Gaussian process prior makes their estimate a
//! ridge regression (Rasmussen & Williams 2006, ch. 8: subset of regressors). Leaving an episode out removes its
//! normal equations. The residual of the discrepancy is a random walk, which is part of the noise that whitens
//! the innovations.

use super::training_set::{Episode, TrainingSet};
use nalgebra::{Cholesky, DMatrix, DVector};
use trundle_model::Discrepancy;

/// Amplitudes of the process that are tried, relative to the residual wrench.
const AMPLITUDES: [f64; 5] = [0.3, 1.0, 3.0, 10.0, 30.0];
/// Independent variance of each weight relative to the process, which keeps the prior regular.
const JITTER: f64 = 1e-6;

/// Normal equations of one episode.
struct NormalEquations {
    gram: DMatrix<f64>,
    score: DVector<f64>,
    /// χ² without a discrepancy.
    square: f64,
}

/// Regression of a discrepancy wrench with given length scales and centres.
pub(super) struct Regression {
    /// χ² of left-out episodes, relative to that without a discrepancy.
    pub relative_chi_square: f64,
    unweighted: Discrepancy,
    parts: Vec<NormalEquations>,
    /// Prior precision of the weights.
    prior: DMatrix<f64>,
}

impl Regression {
    /// Chooses the amplitude that predicts left-out episodes best; `None` if the equations are singular.
    pub fn new(training: &TrainingSet, unweighted: Discrepancy) -> Option<Self> {
        let parts =
            training.episodes.iter().map(|episode| NormalEquations::new(episode, &unweighted)).collect();
        let unit = prior(&unweighted, training.arm);
        let mut regression =
            Self { relative_chi_square: f64::INFINITY, unweighted, parts, prior: unit.clone() };
        let mut best = None;
        for amplitude in AMPLITUDES {
            regression.prior = &unit / (amplitude * training.size).powi(2);
            let Some(relative_chi_square) = regression.leave_one_out_chi_square() else { continue };
            if relative_chi_square < regression.relative_chi_square {
                (regression.relative_chi_square, best) =
                    (relative_chi_square, Some(regression.prior.clone()));
            }
        }
        regression.prior = best?;
        Some(regression)
    }

    /// χ² of each episode with weights from the other episodes, relative to that without a discrepancy.
    fn leave_one_out_chi_square(&self) -> Option<f64> {
        let mut chi_square = 0.0;
        for (k, part) in self.parts.iter().enumerate() {
            let weights = self.weights(Some(k))?;
            chi_square +=
                part.square - 2.0 * weights.dot(&part.score) + weights.dot(&(&part.gram * &weights));
        }
        Some(chi_square / self.parts.iter().map(|part| part.square).sum::<f64>())
    }

    /// The wrench from all episodes, or from all but one.
    pub fn discrepancy(&self, without: Option<usize>) -> Option<Discrepancy> {
        let weights = self.weights(without)?;
        Some(self.unweighted.with_weights(weights.iter().copied()))
    }

    /// The regression with the same length scales, centres and amplitude on episodes that were linearised again.
    pub fn relinearised(&self, training: &TrainingSet) -> Option<Self> {
        let parts =
            training.episodes.iter().map(|episode| NormalEquations::new(episode, &self.unweighted)).collect();
        let mut relinearised = Self {
            relative_chi_square: f64::INFINITY,
            unweighted: self.unweighted.clone(),
            parts,
            prior: self.prior.clone(),
        };
        relinearised.relative_chi_square = relinearised.leave_one_out_chi_square()?;
        Some(relinearised)
    }

    /// Number of inputs.
    pub fn input_count(&self) -> usize {
        self.unweighted.width()
    }

    fn weights(&self, without: Option<usize>) -> Option<DVector<f64>> {
        let mut gram = self.prior.clone();
        let mut score = DVector::zeros(gram.nrows());
        for (_, part) in self.parts.iter().enumerate().filter(|(k, _)| Some(*k) != without) {
            gram += &part.gram;
            score += &part.score;
        }
        Some(Cholesky::new(gram)?.solve(&score))
    }
}

impl NormalEquations {
    fn new(episode: &Episode, unweighted: &Discrepancy) -> Self {
        let kernels =
            |z: Option<Vec<f64>>| z.map_or(vec![0.0; unweighted.centres.len()], |z| unweighted.kernels(&z));
        let kernels: Vec<Vec<f64>> = episode.inputs(unweighted).into_iter().map(kernels).collect();
        let column = |j: usize, axis: usize| {
            let at = |(step, kernels): (usize, &Vec<f64>)| {
                let mut wrench = [0.0; 3];
                wrench[axis] = kernels[j];
                episode.on_object(unweighted.axes, step, wrench)
            };
            let missing: Vec<[f64; 3]> = kernels.iter().enumerate().map(at).collect();
            DVector::from_vec(episode.response.respond(&missing))
        };
        let innovations = DVector::from_column_slice(&episode.response.innovations);
        let columns: Vec<_> =
            (0..unweighted.centres.len()).flat_map(|j| [0, 1, 2].map(|axis| column(j, axis))).collect();
        let design = DMatrix::from_columns(&columns);
        let transposed = design.transpose();
        Self {
            gram: &transposed * &design,
            score: &transposed * &innovations,
            square: innovations.norm_squared(),
        }
    }
}

/// Prior precision of the weights of a process with unit force, N, and the moment of a unit force at `arm`.
fn prior(unweighted: &Discrepancy, arm: f64) -> DMatrix<f64> {
    let kernels: Vec<Vec<f64>> = unweighted.centres.iter().map(|centre| unweighted.kernels(centre)).collect();
    let unit = [1.0, 1.0, arm];
    DMatrix::from_fn(3 * kernels.len(), 3 * kernels.len(), |i, j| {
        let jitter = if i == j { JITTER } else { 0.0 };
        if i % 3 == j % 3 { (kernels[i / 3][j / 3] + jitter) / unit[i % 3].powi(2) } else { 0.0 }
    })
}
