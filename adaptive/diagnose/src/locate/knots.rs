//! The missing wrench as a piecewise constant function: the response of the innovations to each piece, and the χ²
//! that any missing wrench explains.

use super::score_test::{Episode, ScoreTest};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// Minimum duration of a knot, s.
const MIN_KNOT_S: f64 = 0.1;
/// Maximum number of knots per episode; long episodes have longer knots.
const MAX_KNOTS: usize = 96;
/// Number of wrench components per knot.
pub(crate) const COMPONENTS: usize = 3;

/// Responses to a piecewise constant missing wrench in one episode.
pub(crate) struct Knots {
    /// Range of the steps of each knot.
    pub steps: Vec<(usize, usize)>,
    /// Times between knots, s; one more than knots.
    pub edges: Vec<f64>,
    /// Gram matrix of the responses to a unit wrench at each knot: 1 N, 1 N, and the moment of 1 N at the radius of
    /// gyration. The responses of fixed directions are zero.
    pub gram: DMatrix<f64>,
    /// Products of the responses with the innovations.
    pub score: DVector<f64>,
    /// Products of the responses with the basis of the nominal parameters.
    pub nominal: DMatrix<f64>,
    /// The responses.
    pub responses: DMatrix<f64>,
}

impl Knots {
    /// Computes the responses of one episode.
    pub fn new(episode: &Episode, dof: [bool; 3], arm: f64) -> Self {
        let steps = split_into_knots(&episode.response.dt);
        let rows = episode.innovations.len();
        let mut responses = DMatrix::zeros(rows, COMPONENTS * steps.len());
        for (k, &(from, to)) in steps.iter().enumerate() {
            for c in (0..COMPONENTS).filter(|&c| dof[c]) {
                let mut unit = [0.0; 3];
                unit[c] = if c == 2 { arm } else { 1.0 };
                let answer = episode.response.respond_from(from, &vec![unit; to - from]);
                responses.column_mut(COMPONENTS * k + c).copy_from_slice(&answer);
            }
        }
        let start = |k: usize| episode.response.t[k] - episode.response.dt[k] / 2.0;
        let mut edges: Vec<f64> = steps.iter().map(|&(from, _)| start(from)).collect();
        edges.extend(episode.response.t.last().zip(episode.response.dt.last()).map(|(t, dt)| t + dt / 2.0));
        Self {
            gram: responses.tr_mul(&responses),
            score: responses.tr_mul(&episode.innovations),
            nominal: responses.tr_mul(&episode.nominal),
            responses,
            steps,
            edges,
        }
    }

    /// Number of knots.
    pub fn len(&self) -> usize {
        self.steps.len()
    }
}

/// Splits steps into knots of equal duration.
fn split_into_knots(dt: &[f64]) -> Vec<(usize, usize)> {
    let total: f64 = dt.iter().sum();
    let length = MIN_KNOT_S.max(total / MAX_KNOTS as f64);
    let (mut steps, mut from, mut since) = (Vec::new(), 0, 0.0);
    for (k, step) in dt.iter().enumerate() {
        since += step;
        if since > length * (1.0 - 1e-9) || k + 1 == dt.len() {
            steps.push((from, k + 1));
            (from, since) = (k + 1, 0.0);
        }
    }
    steps
}

/// The knots of all episodes.
pub(crate) fn knots(score_test: &ScoreTest) -> Vec<Knots> {
    score_test
        .episodes
        .par_iter()
        .map(|episode| Knots::new(episode, score_test.dof, score_test.arm))
        .collect()
}

/// Log evidence of a missing wrench over none. The wrench at each knot is normal with standard deviation `sd`;
/// the nominal parameters are marginalised.
fn log_evidence(knots: &[Knots], sd: f64) -> f64 {
    let parts: Vec<Option<EpisodeEvidence>> = knots.par_iter().map(|k| EpisodeEvidence::new(k, sd)).collect();
    let nominal = knots.first().map_or(0, |k| k.nominal.ncols());
    let mut remaining = DMatrix::<f64>::identity(nominal, nominal);
    let mut share = DVector::<f64>::zeros(nominal);
    let mut twice_log_evidence = 0.0;
    for part in parts {
        let Some(part) = part else { return f64::NEG_INFINITY };
        twice_log_evidence += part.twice_log_evidence;
        share += part.share;
        remaining -= part.absorbed;
    }
    // By the Woodbury identity, project out the nominal parameters of all episodes at once.
    let Some(factor) = remaining.cholesky() else { return f64::NEG_INFINITY };
    twice_log_evidence += share.dot(&factor.solve(&share)) - log_determinant(&factor);
    0.5 * twice_log_evidence
}

/// Contribution of one episode to the log evidence.
struct EpisodeEvidence {
    /// Explained sum of squares minus the log determinant.
    twice_log_evidence: f64,
    share: DVector<f64>,
    absorbed: DMatrix<f64>,
}

impl EpisodeEvidence {
    fn new(knots: &Knots, sd: f64) -> Option<Self> {
        let n = knots.score.len();
        let factor = (DMatrix::identity(n, n) + &knots.gram * (sd * sd)).cholesky()?;
        let (score, nominal) = (&knots.score * sd, &knots.nominal * sd);
        let solved = factor.solve(&score);
        let twice_log_evidence = score.dot(&solved) - log_determinant(&factor);
        Some(Self {
            twice_log_evidence,
            share: nominal.tr_mul(&solved),
            absorbed: nominal.tr_mul(&factor.solve(&nominal)),
        })
    }
}

/// Log determinant.
fn log_determinant(factor: &nalgebra::Cholesky<f64, nalgebra::Dyn>) -> f64 {
    2.0 * factor.l_dirty().diagonal().iter().map(|d| d.ln()).sum::<f64>()
}

/// Standard deviations of a knot's wrench that are tried, N.
const WRENCH_SIZES_N: [f64; 7] = [0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0];

/// Twice the log evidence of a missing wrench over none, maximised over its standard deviation.
pub(crate) fn explainable_chi_square(knots: &[Knots]) -> f64 {
    WRENCH_SIZES_N.into_iter().map(|sd| 2.0 * log_evidence(knots, sd)).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::split_into_knots;

    #[test]
    fn knots_cover_every_step_once() {
        let dt = vec![1.0 / 120.0; 131];
        let steps = split_into_knots(&dt);
        assert_eq!((steps[0], steps.last().copied()), ((0, 12), Some((120, 131))));
        assert!(steps.windows(2).all(|w| w[0].1 == w[1].0));
        assert!(split_into_knots(&vec![0.01; 60_000]).len() <= 97);
    }
}
