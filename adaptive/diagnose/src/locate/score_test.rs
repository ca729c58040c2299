//! Score tests of missing wrenches on the whitened innovations.
//!
//! Under the right model, whitened innovations are independent and standard normal, whereas smoothed residuals
//! are correlated. A missing wrench is therefore tested on the innovations: their squares decrease by the best
//! multiple of its response, with the nominal parameters projected out, and the decrease is χ² distributed (score
//! test; Willsky & Jones 1976). The smoothed residual wrench serves for display only, never for a p-value.

use nalgebra::{DMatrix, DVector};
use trundle_infer::{Fit, InferError, MotionLikelihood, Residual, Response};
use trundle_model::to_body;

/// One episode as a linear system.
pub(crate) struct Episode {
    /// Response of the filter to a missing wrench.
    pub response: Response,
    /// Pose of the reading's frame in the object frame at each step.
    pub frames: Vec<[f64; 3]>,
    /// Smoothed motion and missing wrench at the end of each step.
    pub residuals: Vec<Residual>,
    /// Innovations with the nominal parameters projected out.
    pub innovations: DVector<f64>,
    /// Rows of this episode in an orthonormal basis of the nominal parameters' derivatives.
    pub nominal: DMatrix<f64>,
}

/// Linear responses of all episodes.
pub(crate) struct ScoreTest {
    pub episodes: Vec<Episode>,
    /// Free directions.
    pub dof: [bool; 3],
    /// Lever arm that converts a moment into a force, m.
    pub arm: f64,
}

/// A missing wrench at each step of some episodes, object axes about the object origin, `[N, N, N·m]`.
pub(crate) type WrenchProfile = Vec<Vec<[f64; 3]>>;

/// Response of the innovations to a wrench profile.
pub(crate) struct Column {
    /// Responses by episode; empty where they vanish.
    responses: Vec<DVector<f64>>,
    /// Products with the basis of the nominal parameters.
    nominal_products: DVector<f64>,
}

/// Joint test of some columns.
#[derive(Clone, Debug)]
pub(crate) struct TestResult {
    /// Reduction of the sum of squares.
    pub chi_square: f64,
    /// Number of independent columns.
    pub dof: usize,
    /// Best multiple of each column; zero for dependent columns.
    pub coefficients: Vec<f64>,
}

/// Share of a column's square below which it depends on the nominal parameters or on other columns.
const MIN_INDEPENDENT_SHARE: f64 = 1e-6;

impl ScoreTest {
    /// Linearises at a fit; `None` if it cannot be evaluated.
    ///
    /// # Errors
    /// If the fit's values do not suit its model.
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
        let is_consistent = responses.len() == residuals.len()
            && responses.iter().zip(residuals).all(|(r, residuals)| r.t.len() == residuals.len());
        if !is_consistent {
            return Ok(None);
        }
        let bases = orthonormal_basis(slopes);
        let mut episodes: Vec<Episode> = responses
            .into_iter()
            .zip(bases)
            .zip(residuals)
            .zip(motion.tracks())
            .map(|(((response, nominal), residuals), track)| {
                let innovations = DVector::from_column_slice(&response.innovations);
                let frames = track.steps.iter().map(|s| s.frame).collect();
                Episode { response, frames, residuals: residuals.clone(), innovations, nominal }
            })
            .collect();
        let explained =
            nominal_products(&episodes, &episodes.iter().map(|r| r.innovations.clone()).collect::<Vec<_>>());
        for episode in &mut episodes {
            episode.innovations -= &episode.nominal * &explained;
        }
        Ok(Some(Self { episodes, dof: model.dof, arm: model.body.gyration.max(1e-3) }))
    }

    /// Dimension of the basis of the nominal parameters.
    pub fn nominal_dimension(&self) -> usize {
        self.episodes.first().map_or(0, |r| r.nominal.ncols())
    }

    /// Number of free directions.
    pub fn free_directions(&self) -> usize {
        self.dof.iter().filter(|d| **d).count()
    }

    /// A wrench profile from the smoothed motion at each step of each episode.
    pub fn profile(&self, wrench: impl Fn(usize, &Residual) -> [f64; 3]) -> WrenchProfile {
        let of = |(k, episode): (usize, &Episode)| episode.residuals.iter().map(|r| wrench(k, r)).collect();
        self.episodes.iter().enumerate().map(of).collect()
    }

    /// Response to a wrench profile.
    pub fn column(&self, profile: &WrenchProfile) -> Column {
        let response = |(episode, missing): (&Episode, &Vec<[f64; 3]>)| {
            if missing.iter().all(|w| *w == [0.0; 3]) {
                return DVector::zeros(0);
            }
            DVector::from_vec(episode.response.respond(missing))
        };
        self.column_from_responses(self.episodes.iter().zip(profile).map(response).collect())
    }

    /// A column with known responses.
    pub fn column_from_responses(&self, responses: Vec<DVector<f64>>) -> Column {
        let nominal_products = nominal_products(&self.episodes, &responses);
        Column { responses, nominal_products }
    }

    /// Tests several columns together.
    pub fn test(&self, columns: &[&Column]) -> TestResult {
        let n = columns.len();
        let gram = DMatrix::from_fn(n, n, |i, j| columns[i].inner(columns[j]));
        let score = DVector::from_fn(n, |i, _| columns[i].score(&self.episodes));
        let squares: Vec<f64> = columns.iter().map(|c| c.square()).collect();
        solve(&gram, &score, &squares)
    }
}

impl Column {
    /// Inner product of two columns, with the nominal parameters projected out.
    pub fn inner(&self, other: &Self) -> f64 {
        let pairs = self.responses.iter().zip(&other.responses);
        let product: f64 = pairs.filter(|(a, b)| a.len() == b.len()).map(|(a, b)| a.dot(b)).sum();
        product - self.nominal_products.dot(&other.nominal_products)
    }

    /// Product with the innovations.
    pub fn score(&self, episodes: &[Episode]) -> f64 {
        let pairs = self.responses.iter().zip(episodes).filter(|(a, _)| !a.is_empty());
        pairs.map(|(a, episode)| a.dot(&episode.innovations)).sum()
    }

    /// Squared norm, without projection.
    fn square(&self) -> f64 {
        self.responses.iter().map(DVector::norm_squared).sum()
    }
}

/// Least squares in which columns that depend on earlier ones are skipped. `squares` are their squared norms
/// before the projection.
fn solve(gram: &DMatrix<f64>, score: &DVector<f64>, squares: &[f64]) -> TestResult {
    let mut kept: Vec<usize> = Vec::new();
    let mut best = None;
    for (k, &square) in squares.iter().enumerate() {
        let mut trial = kept.clone();
        trial.push(k);
        let part = gram.select_rows(&trial).select_columns(&trial);
        let Some(factor) = part.cholesky() else { continue };
        let pivot = factor.l_dirty()[(trial.len() - 1, trial.len() - 1)].powi(2);
        if pivot > MIN_INDEPENDENT_SHARE * square {
            kept = trial;
            best = Some(factor);
        }
    }
    let mut coefficients = vec![0.0; squares.len()];
    let Some(factor) = best else { return TestResult { chi_square: 0.0, dof: 0, coefficients } };
    let right = DVector::from_iterator(kept.len(), kept.iter().map(|&k| score[k]));
    let solution = factor.solve(&right);
    for (&k, value) in kept.iter().zip(solution.iter()) {
        coefficients[k] = *value;
    }
    TestResult { chi_square: solution.dot(&right).max(0.0), dof: kept.len(), coefficients }
}

/// Products of responses with the basis of the nominal parameters.
fn nominal_products(episodes: &[Episode], responses: &[DVector<f64>]) -> DVector<f64> {
    let zero = DVector::zeros(episodes.first().map_or(0, |r| r.nominal.ncols()));
    let pairs = episodes.iter().zip(responses).filter(|(_, a)| !a.is_empty());
    pairs.fold(zero, |sum, (episode, response)| sum + episode.nominal.tr_mul(response))
}

/// Orthonormal basis of the columns of stacked matrices, split like these.
fn orthonormal_basis(parts: Vec<DMatrix<f64>>) -> Vec<DMatrix<f64>> {
    let columns = parts.first().map_or(0, DMatrix::ncols);
    let mut kept: Vec<Vec<DVector<f64>>> = Vec::new();
    for k in 0..columns {
        let mut own: Vec<DVector<f64>> = parts.iter().map(|p| p.column(k).into_owned()).collect();
        let before: f64 = own.iter().map(DVector::norm_squared).sum();
        // Two passes of Gram–Schmidt suffice (Kahan; Giraud et al. 2005).
        for _ in 0..2 {
            for basis in &kept {
                let share: f64 = own.iter().zip(basis).map(|(a, b)| a.dot(b)).sum();
                own.iter_mut().zip(basis).for_each(|(a, b)| a.axpy(-share, b, 1.0));
            }
        }
        let remaining: f64 = own.iter().map(DVector::norm_squared).sum();
        if remaining.is_finite() && remaining > 1e-10 * before && remaining > 0.0 {
            kept.push(own.into_iter().map(|a| a / remaining.sqrt()).collect());
        }
    }
    let split =
        |(k, part): (usize, &DMatrix<f64>)| DMatrix::from_fn(part.nrows(), kept.len(), |i, j| kept[j][k][i]);
    parts.iter().enumerate().map(split).collect()
}

/// −log10 of the tail probability of χ² with `dof` degrees of freedom, finite for any value.
pub(crate) fn minus_log10_p(chi_square: f64, dof: usize) -> f64 {
    use statrs::distribution::{ChiSquared, ContinuousCDF};
    if dof == 0 {
        return 0.0;
    }
    let tail = ChiSquared::new(dof as f64).map_or(1.0, |d| d.sf(chi_square));
    if tail > 1e-280 {
        return -tail.log10();
    }
    // Leading term of the incomplete gamma function.
    let half = chi_square / 2.0;
    let shape = dof as f64 / 2.0;
    (half - (shape - 1.0) * half.ln() + statrs::function::gamma::ln_gamma(shape)) / std::f64::consts::LN_10
}

/// Velocity of a body point, object axes, m/s.
pub(crate) fn velocity_at(residual: &Residual, [x, y]: [f64; 2]) -> [f64; 2] {
    let [vx, vy, spin] = to_body(residual.twist, residual.pose[2]);
    [vx - spin * y, vy + spin * x]
}

/// Wrench about the origin of a force at a body point, object axes.
pub(crate) fn force_at([x, y]: [f64; 2], [fx, fy]: [f64; 2]) -> [f64; 3] {
    [fx, fy, x * fy - y * fx]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn minus_log10_p_is_finite_and_increases() {
        let values: Vec<f64> =
            [1.0, 20.0, 1000.0, 1200.0, 1400.0, 1e6].iter().map(|c| minus_log10_p(*c, 3)).collect();
        assert!(values.windows(2).all(|w| w[0] < w[1] && w[1].is_finite()), "{values:?}");
        // χ²₃ = 16.27 has p = 10⁻³.
        assert!((minus_log10_p(16.266, 3) - 3.0).abs() < 1e-3);
    }

    #[test]
    fn dependent_columns_are_skipped() {
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
        let bases = orthonormal_basis(parts.clone());
        assert_eq!(bases[0].ncols(), 2);
        let gram: DMatrix<f64> = bases.iter().map(|b| b.tr_mul(b)).sum();
        assert!((gram - DMatrix::identity(2, 2)).norm() < 1e-12);
        let column = |p: &DMatrix<f64>, k: usize| p.column(k).into_owned();
        let products: DMatrix<f64> = bases.iter().zip(&parts).map(|(b, p)| b.tr_mul(p)).sum();
        for k in 0..3 {
            let off: f64 =
                bases.iter().zip(&parts).map(|(b, p)| (column(p, k) - b * products.column(k)).norm()).sum();
            assert!(off < 1e-10);
        }
    }
}
