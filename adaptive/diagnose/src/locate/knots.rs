//! The missing wrench as steps of a tenth of a second or so: what each does to the innovations, and how much a missing
//! wrench of any kind would explain.

use super::screen::{Run, Screen};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// Shortest knot, s.
const SHORTEST: f64 = 0.1;
/// Most knots of an episode; a long one gets longer knots.
const MOST: usize = 96;
/// Wrench components of a knot.
pub(crate) const WIDE: usize = 3;

/// What a piecewise constant missing wrench does in one episode.
pub(crate) struct Knots {
    /// Steps of each knot: from, to.
    pub steps: Vec<(usize, usize)>,
    /// Times between knots, s; one more than knots.
    pub edges: Vec<f64>,
    /// Gram matrix of the answers to a unit wrench at each knot: 1 N, 1 N, and the moment of 1 N at the gyration
    /// radius; a direction that does not move has none.
    pub gram: DMatrix<f64>,
    /// Their products with the innovations.
    pub score: DVector<f64>,
    /// Their products with what nominal parameters can do.
    pub nominal: DMatrix<f64>,
    /// The answers.
    pub answers: DMatrix<f64>,
}

impl Knots {
    /// Of one episode.
    pub fn new(run: &Run, dof: [bool; 3], arm: f64) -> Self {
        let steps = cut(&run.response.dt);
        let rows = run.innovations.len();
        let mut answers = DMatrix::zeros(rows, WIDE * steps.len());
        for (k, &(from, to)) in steps.iter().enumerate() {
            for c in (0..WIDE).filter(|&c| dof[c]) {
                let mut unit = [0.0; 3];
                unit[c] = if c == 2 { arm } else { 1.0 };
                let answer = run.response.respond_from(from, &vec![unit; to - from]);
                answers.column_mut(WIDE * k + c).copy_from_slice(&answer);
            }
        }
        let begin = |k: usize| run.response.t[k] - run.response.dt[k] / 2.0;
        let mut edges: Vec<f64> = steps.iter().map(|&(from, _)| begin(from)).collect();
        edges.extend(run.response.t.last().zip(run.response.dt.last()).map(|(t, dt)| t + dt / 2.0));
        Self {
            gram: answers.tr_mul(&answers),
            score: answers.tr_mul(&run.innovations),
            nominal: answers.tr_mul(&run.nominal),
            answers,
            steps,
            edges,
        }
    }

    /// How many.
    pub fn len(&self) -> usize {
        self.steps.len()
    }
}

/// Steps cut into knots of equal duration.
fn cut(dt: &[f64]) -> Vec<(usize, usize)> {
    let whole: f64 = dt.iter().sum();
    let length = SHORTEST.max(whole / MOST as f64);
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
pub(crate) fn knots(screen: &Screen) -> Vec<Knots> {
    screen.runs.par_iter().map(|run| Knots::new(run, screen.dof, screen.arm)).collect()
}

/// Log likelihood ratio to no missing wrench of one that is standard normal at each knot, in units of `sd`, nominal
/// parameters marginalised.
fn evidence(knots: &[Knots], sd: f64) -> f64 {
    let parts: Vec<Option<Part>> = knots.par_iter().map(|k| Part::new(k, sd)).collect();
    let nominal = knots.first().map_or(0, |k| k.nominal.ncols());
    let mut left = DMatrix::<f64>::identity(nominal, nominal);
    let mut share = DVector::<f64>::zeros(nominal);
    let mut twice = 0.0;
    for part in parts {
        let Some(part) = part else { return f64::NEG_INFINITY };
        twice += part.twice;
        share += part.share;
        left -= part.taken;
    }
    // Woodbury: what nominal parameters can do is taken out of all episodes at once.
    let Some(factor) = left.cholesky() else { return f64::NEG_INFINITY };
    twice += share.dot(&factor.solve(&share)) - volume(&factor);
    0.5 * twice
}

/// One episode's part of the evidence.
struct Part {
    /// Explained sum of squares less the log determinant.
    twice: f64,
    share: DVector<f64>,
    taken: DMatrix<f64>,
}

impl Part {
    fn new(knots: &Knots, sd: f64) -> Option<Self> {
        let n = knots.score.len();
        let factor = (DMatrix::identity(n, n) + &knots.gram * (sd * sd)).cholesky()?;
        let (score, along) = (&knots.score * sd, &knots.nominal * sd);
        let solved = factor.solve(&score);
        let twice = score.dot(&solved) - volume(&factor);
        Some(Self { twice, share: along.tr_mul(&solved), taken: along.tr_mul(&factor.solve(&along)) })
    }
}

/// Log determinant.
fn volume(factor: &nalgebra::Cholesky<f64, nalgebra::Dyn>) -> f64 {
    2.0 * factor.l_dirty().diagonal().iter().map(|d| d.ln()).sum::<f64>()
}

/// Sizes tried of a knot's wrench, N.
const SIZES: [f64; 7] = [0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0];

/// Twice the log likelihood ratio of a missing wrench of any kind, of the size that suits best, to none.
pub(crate) fn anything(knots: &[Knots]) -> f64 {
    SIZES.into_iter().map(|sd| 2.0 * evidence(knots, sd)).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::cut;

    #[test]
    fn knots_cover_every_step_once() {
        let dt = vec![1.0 / 120.0; 131];
        let steps = cut(&dt);
        assert_eq!((steps[0], steps.last().copied()), ((0, 12), Some((120, 131))));
        assert!(steps.windows(2).all(|w| w[0].1 == w[1].0));
        assert!(cut(&vec![0.01; 60_000]).len() <= 97);
    }
}
