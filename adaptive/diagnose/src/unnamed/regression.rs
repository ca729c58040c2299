//! Weights of an unnamed wrench, from what each would do to the whitened innovations.
//!
//! About the fit that is linear, so that the weights under a Gaussian process' prior are a ridge regression, and so are
//! those without an episode (Rasmussen & Williams 2006, ch. 8: subset of regressors). What the wrench leaves is taken
//! for a random walk, by which the innovations are whitened.

use super::course::{Course, Episode};
use nalgebra::{Cholesky, DMatrix, DVector};
use trundle_model::Unnamed;

/// Amplitudes of the process that are tried, in sizes of the missing wrench.
const AMPLITUDES: [f64; 5] = [0.3, 1.0, 3.0, 10.0, 30.0];
/// Share of the amplitude by which each weight may differ for itself: what keeps the prior regular.
const JITTER: f64 = 1e-6;

/// Normal equations of one episode.
struct Part {
    gram: DMatrix<f64>,
    score: DVector<f64>,
    /// χ² without an unnamed wrench.
    square: f64,
}

/// An unnamed wrench to be fitted, its lengths and centres given.
pub(super) struct Regression {
    /// χ² of episodes left out, over that without it.
    pub left: f64,
    blank: Unnamed,
    parts: Vec<Part>,
    /// Inverse of the weights' covariance before the data.
    prior: DMatrix<f64>,
}

impl Regression {
    /// With the amplitude that foresees episodes left out best; `None` where no equations can be solved.
    pub fn new(course: &Course, blank: Unnamed) -> Option<Self> {
        let parts = course.episodes.iter().map(|episode| Part::new(episode, &blank)).collect();
        let unit = prior(&blank, course.arm);
        let mut regression = Self { left: f64::INFINITY, blank, parts, prior: unit.clone() };
        let mut best = None;
        for amplitude in AMPLITUDES {
            regression.prior = &unit / (amplitude * course.size).powi(2);
            let Some(left) = regression.foreseen() else { continue };
            if left < regression.left {
                (regression.left, best) = (left, Some(regression.prior.clone()));
            }
        }
        regression.prior = best?;
        Some(regression)
    }

    /// χ² that is left of each episode by weights from the others, over all without.
    fn foreseen(&self) -> Option<f64> {
        let mut left = 0.0;
        for (k, part) in self.parts.iter().enumerate() {
            let weights = self.weights(Some(k))?;
            left += part.square - 2.0 * weights.dot(&part.score) + weights.dot(&(&part.gram * &weights));
        }
        Some(left / self.parts.iter().map(|part| part.square).sum::<f64>())
    }

    /// The wrench as all episodes have it, or all but one.
    pub fn unnamed(&self, without: Option<usize>) -> Option<Unnamed> {
        let weights = self.weights(without)?;
        Some(self.blank.weighted(weights.iter().copied()))
    }

    /// The same, its lengths, centres and amplitude kept, along a course that was seen anew.
    pub fn again(&self, course: &Course) -> Option<Self> {
        let parts = course.episodes.iter().map(|episode| Part::new(episode, &self.blank)).collect();
        let mut again =
            Self { left: f64::INFINITY, blank: self.blank.clone(), parts, prior: self.prior.clone() };
        again.left = again.foreseen()?;
        Some(again)
    }

    /// How many numbers it depends on.
    pub fn numbers(&self) -> usize {
        self.blank.width()
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

impl Part {
    fn new(episode: &Episode, blank: &Unnamed) -> Self {
        let kernels = |z: Option<Vec<f64>>| z.map_or(vec![0.0; blank.centres.len()], |z| blank.kernels(&z));
        let kernels: Vec<Vec<f64>> = episode.inputs(blank).into_iter().map(kernels).collect();
        let column = |j: usize, axis: usize| {
            let at = |(step, kernels): (usize, &Vec<f64>)| {
                let mut wrench = [0.0; 3];
                wrench[axis] = kernels[j];
                episode.on_object(blank.axes, step, wrench)
            };
            let missing: Vec<[f64; 3]> = kernels.iter().enumerate().map(at).collect();
            DVector::from_vec(episode.response.respond(&missing))
        };
        let innovations = DVector::from_column_slice(&episode.response.innovations);
        let columns: Vec<_> =
            (0..blank.centres.len()).flat_map(|j| [0, 1, 2].map(|axis| column(j, axis))).collect();
        let answers = DMatrix::from_columns(&columns);
        let turned = answers.transpose();
        Self { gram: &turned * &answers, score: &turned * &innovations, square: innovations.norm_squared() }
    }
}

/// Inverse covariance of the weights of a process of one newton, and of as much moment as that makes at `arm`.
fn prior(blank: &Unnamed, arm: f64) -> DMatrix<f64> {
    let kernels: Vec<Vec<f64>> = blank.centres.iter().map(|centre| blank.kernels(centre)).collect();
    let unit = [1.0, 1.0, arm];
    DMatrix::from_fn(3 * kernels.len(), 3 * kernels.len(), |i, j| {
        let jitter = if i == j { JITTER } else { 0.0 };
        if i % 3 == j % 3 { (kernels[i / 3][j / 3] + jitter) / unit[i % 3].powi(2) } else { 0.0 }
    })
}
