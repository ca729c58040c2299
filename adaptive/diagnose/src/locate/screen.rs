//! The linear view of a misfit: what any course of missing wrench would do to the whitened innovations, beside what
//! another value of a nominal parameter would do.
//!
//! Where the simulation under test is right, its whitened innovations are independent and standard normal however its
//! smoothed residuals are correlated, so a missing wrench is judged on them: the reduction of their squares by the
//! best multiple of its answer, nominal parameters projected out, is χ² (a score test; Willsky & Jones 1976). The
//! smoothed residual wrench is for looking at, never for a p-value.

use nalgebra::{DMatrix, DVector};
use trundle_infer::{Fit, InferError, MotionLikelihood, Residual, Response};
use trundle_model::to_body;

/// One episode.
pub(crate) struct Run {
    /// The filter as a linear system.
    pub response: Response,
    /// Pose of the reading's frame in the object frame at each step.
    pub frames: Vec<[f64; 3]>,
    /// Smoothed motion and missing wrench at the end of each step.
    pub course: Vec<Residual>,
    /// Innovations less what other nominal values would take away.
    pub innovations: DVector<f64>,
    /// This episode's rows of an orthonormal basis of what nominal parameters can do.
    pub nominal: DMatrix<f64>,
}

/// All episodes.
pub(crate) struct Screen {
    pub runs: Vec<Run>,
    /// Directions that move.
    pub dof: [bool; 3],
    /// What makes a moment comparable with a force, m.
    pub arm: f64,
}

/// A missing wrench at each step of some episodes, object axes about the object origin, `[N, N, N·m]`.
pub(crate) type Profile = Vec<Vec<[f64; 3]>>;

/// What a profile does to the innovations.
pub(crate) struct Column {
    /// Answers by run; empty where it does nothing.
    answers: Vec<DVector<f64>>,
    /// Part that nominal parameters can do as well.
    along: DVector<f64>,
}

/// What some columns together explain.
#[derive(Clone, Debug)]
pub(crate) struct Test {
    /// Reduction of the sum of squares.
    pub chi_square: f64,
    /// How many independent columns there were.
    pub dof: usize,
    /// Best multiple of each column; 0 for those that depend on others.
    pub coefficients: Vec<f64>,
}

/// Share of a column's square below which nominal parameters, or other columns, do the same.
const INDEPENDENT: f64 = 1e-6;

impl Screen {
    /// About a fitted simulation; `None` where it cannot be evaluated.
    ///
    /// # Errors
    /// When the fit's values do not suit its model.
    pub fn new(
        motion: &MotionLikelihood,
        fit: &Fit,
        residuals: &[Vec<Residual>],
    ) -> Result<Option<Self>, InferError> {
        let model = &fit.model;
        let free: Vec<usize> = model
            .slots()
            .iter()
            .enumerate()
            .filter(|(_, slot)| fit.estimate(&slot.name).is_some())
            .map(|(k, _)| k)
            .collect();
        let Some(responses) = motion.responses(model, &fit.values)? else { return Ok(None) };
        let Some(seen) = motion.filtered(model, &fit.values)? else { return Ok(None) };
        let slopes = seen.slopes(model, &fit.values, &free)?;
        let fits = responses.len() == residuals.len()
            && responses.iter().zip(residuals).all(|(r, course)| r.t.len() == course.len());
        if !fits {
            return Ok(None);
        }
        let bases = orthonormal(slopes);
        let mut runs: Vec<Run> = responses
            .into_iter()
            .zip(bases)
            .zip(residuals)
            .zip(motion.tracks())
            .map(|(((response, nominal), course), track)| {
                let innovations = DVector::from_column_slice(&response.innovations);
                let frames = track.steps.iter().map(|s| s.frame).collect();
                Run { response, frames, course: course.clone(), innovations, nominal }
            })
            .collect();
        let explained = along(&runs, &runs.iter().map(|r| r.innovations.clone()).collect::<Vec<_>>());
        for run in &mut runs {
            run.innovations -= &run.nominal * &explained;
        }
        Ok(Some(Self { runs, dof: model.dof, arm: model.body.gyration.max(1e-3) }))
    }

    /// How many nominal directions there are.
    pub fn nominal(&self) -> usize {
        self.runs.first().map_or(0, |r| r.nominal.ncols())
    }

    /// Directions that move.
    pub fn directions(&self) -> usize {
        self.dof.iter().filter(|d| **d).count()
    }

    /// A profile from what is seen at each step of each episode.
    pub fn profile(&self, wrench: impl Fn(usize, &Residual) -> [f64; 3]) -> Profile {
        let of = |(k, run): (usize, &Run)| run.course.iter().map(|r| wrench(k, r)).collect();
        self.runs.iter().enumerate().map(of).collect()
    }

    /// What a profile does to the innovations.
    pub fn column(&self, profile: &Profile) -> Column {
        let answer = |(run, missing): (&Run, &Vec<[f64; 3]>)| {
            if missing.iter().all(|w| *w == [0.0; 3]) {
                return DVector::zeros(0);
            }
            DVector::from_vec(run.response.respond(missing))
        };
        self.gathered(self.runs.iter().zip(profile).map(answer).collect())
    }

    /// A column whose answers are known.
    pub fn gathered(&self, answers: Vec<DVector<f64>>) -> Column {
        let along = along(&self.runs, &answers);
        Column { answers, along }
    }

    /// What several columns together explain.
    pub fn test(&self, columns: &[&Column]) -> Test {
        let n = columns.len();
        let gram = DMatrix::from_fn(n, n, |i, j| columns[i].inner(columns[j]));
        let score = DVector::from_fn(n, |i, _| columns[i].score(&self.runs));
        let whole: Vec<f64> = columns.iter().map(|c| c.square()).collect();
        solve(&gram, &score, &whole)
    }
}

impl Column {
    /// Scalar product of two columns, nominal parameters projected out.
    pub fn inner(&self, other: &Self) -> f64 {
        let pairs = self.answers.iter().zip(&other.answers);
        let plain: f64 = pairs.filter(|(a, b)| a.len() == b.len()).map(|(a, b)| a.dot(b)).sum();
        plain - self.along.dot(&other.along)
    }

    /// Its product with the innovations.
    pub fn score(&self, runs: &[Run]) -> f64 {
        let pairs = self.answers.iter().zip(runs).filter(|(a, _)| !a.is_empty());
        pairs.map(|(a, run)| a.dot(&run.innovations)).sum()
    }

    /// Its square, nominal parameters not projected out.
    fn square(&self) -> f64 {
        self.answers.iter().map(DVector::norm_squared).sum()
    }
}

/// Weighted least squares with dependent columns left out, in order: `whole` are their squares before anything was
/// projected out.
fn solve(gram: &DMatrix<f64>, score: &DVector<f64>, whole: &[f64]) -> Test {
    let mut kept: Vec<usize> = Vec::new();
    let mut best = None;
    for (k, &square) in whole.iter().enumerate() {
        let mut tried = kept.clone();
        tried.push(k);
        let part = gram.select_rows(&tried).select_columns(&tried);
        let Some(factor) = part.cholesky() else { continue };
        let pivot = factor.l_dirty()[(tried.len() - 1, tried.len() - 1)].powi(2);
        if pivot > INDEPENDENT * square {
            kept = tried;
            best = Some(factor);
        }
    }
    let mut coefficients = vec![0.0; whole.len()];
    let Some(factor) = best else { return Test { chi_square: 0.0, dof: 0, coefficients } };
    let right = DVector::from_iterator(kept.len(), kept.iter().map(|&k| score[k]));
    let solution = factor.solve(&right);
    for (&k, value) in kept.iter().zip(solution.iter()) {
        coefficients[k] = *value;
    }
    Test { chi_square: solution.dot(&right).max(0.0), dof: kept.len(), coefficients }
}

/// Products of answers with the nominal basis.
fn along(runs: &[Run], answers: &[DVector<f64>]) -> DVector<f64> {
    let zero = DVector::zeros(runs.first().map_or(0, |r| r.nominal.ncols()));
    let pairs = runs.iter().zip(answers).filter(|(_, a)| !a.is_empty());
    pairs.fold(zero, |sum, (run, answer)| sum + run.nominal.tr_mul(answer))
}

/// An orthonormal basis of what the columns of stacked matrices span, cut as they were.
fn orthonormal(parts: Vec<DMatrix<f64>>) -> Vec<DMatrix<f64>> {
    let columns = parts.first().map_or(0, DMatrix::ncols);
    let mut kept: Vec<Vec<DVector<f64>>> = Vec::new();
    for k in 0..columns {
        let mut own: Vec<DVector<f64>> = parts.iter().map(|p| p.column(k).into_owned()).collect();
        let whole: f64 = own.iter().map(DVector::norm_squared).sum();
        // Twice is enough (Kahan; Giraud et al. 2005).
        for _ in 0..2 {
            for basis in &kept {
                let share: f64 = own.iter().zip(basis).map(|(a, b)| a.dot(b)).sum();
                own.iter_mut().zip(basis).for_each(|(a, b)| a.axpy(-share, b, 1.0));
            }
        }
        let left: f64 = own.iter().map(DVector::norm_squared).sum();
        if left.is_finite() && left > 1e-10 * whole && left > 0.0 {
            kept.push(own.into_iter().map(|a| a / left.sqrt()).collect());
        }
    }
    let cut =
        |(k, part): (usize, &DMatrix<f64>)| DMatrix::from_fn(part.nrows(), kept.len(), |i, j| kept[j][k][i]);
    parts.iter().enumerate().map(cut).collect()
}

/// −log10 of the tail probability of χ² with `dof` degrees of freedom, finite for any value.
pub(crate) fn surprise(chi_square: f64, dof: usize) -> f64 {
    use statrs::distribution::{ChiSquared, ContinuousCDF};
    if dof == 0 {
        return 0.0;
    }
    let tail = ChiSquared::new(dof as f64).map_or(1.0, |d| d.sf(chi_square));
    if tail > 1e-280 {
        return -tail.log10();
    }
    // Leading term of the incomplete gamma function, its own factor left out.
    let half = chi_square / 2.0;
    let shape = dof as f64 / 2.0;
    (half - (shape - 1.0) * half.ln() + statrs::function::gamma::ln_gamma(shape)) / std::f64::consts::LN_10
}

/// Velocity of a body point, object axes, m/s.
pub(crate) fn velocity_at(seen: &Residual, [x, y]: [f64; 2]) -> [f64; 2] {
    let [vx, vy, spin] = to_body(seen.twist, seen.pose[2]);
    [vx - spin * y, vy + spin * x]
}

/// A force at a body point as a wrench about the origin, object axes.
pub(crate) fn force_at([x, y]: [f64; 2], [fx, fy]: [f64; 2]) -> [f64; 3] {
    [fx, fy, x * fy - y * fx]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn surprise_is_finite_and_grows() {
        let values: Vec<f64> =
            [1.0, 20.0, 1000.0, 1200.0, 1400.0, 1e6].iter().map(|c| surprise(*c, 3)).collect();
        assert!(values.windows(2).all(|w| w[0] < w[1] && w[1].is_finite()), "{values:?}");
        // χ²₃ = 16.27 has p = 10⁻³.
        assert!((surprise(16.266, 3) - 3.0).abs() < 1e-3);
    }

    #[test]
    fn dependent_columns_are_left_out() {
        let gram = DMatrix::from_row_slice(3, 3, &[2.0, 2.0, 0.0, 2.0, 2.0, 0.0, 0.0, 0.0, 1.0]);
        let test = solve(&gram, &DVector::from_vec(vec![4.0, 4.0, 3.0]), &[2.0, 2.0, 1.0]);
        assert_eq!((test.dof, test.coefficients[1]), (2, 0.0));
        assert!((test.coefficients[0] - 2.0).abs() < 1e-12 && (test.coefficients[2] - 3.0).abs() < 1e-12);
        assert!((test.chi_square - 17.0).abs() < 1e-12);
    }

    #[test]
    fn a_basis_spans_its_columns_and_drops_repeats() {
        let part = |s: f64| DMatrix::from_fn(4, 3, |i, j| if j == 2 { s * i as f64 } else { (i + j) as f64 });
        let parts = vec![part(1.0), part(1.0)];
        let bases = orthonormal(parts.clone());
        assert_eq!(bases[0].ncols(), 2);
        let gram: DMatrix<f64> = bases.iter().map(|b| b.tr_mul(b)).sum();
        assert!((gram - DMatrix::identity(2, 2)).norm() < 1e-12);
        let left = |p: &DMatrix<f64>, k: usize| p.column(k).into_owned();
        let products: DMatrix<f64> = bases.iter().zip(&parts).map(|(b, p)| b.tr_mul(p)).sum();
        for k in 0..3 {
            let off: f64 =
                bases.iter().zip(&parts).map(|(b, p)| (left(p, k) - b * products.column(k)).norm()).sum();
            assert!(off < 1e-10);
        }
    }
}
