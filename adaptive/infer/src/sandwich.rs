//! Intervals that include model error: the covariance of an estimate from its variation between episodes.
//!
//! The inverse curvature is the covariance of an estimate only if the model is correct. Otherwise the
//! gradients of the episodes vary more than their curvature implies, and the sandwich covariance applies
//! (Huber 1967, White 1982). Samples within an episode are dependent, so the episodes are the independent
//! clusters:
//!
//! ```text
//! V = H⁻¹ (Σₑ gₑ gₑᵀ) H⁻¹             H: posterior curvature, gₑ: gradient of episode e at the estimate
//! ```
//!
//! With few episodes this is too narrow, because the estimate adapts to each of them. The jackknife form
//! corrects the bias (CR3; Bell and McCaffrey 2002, MacKinnon, Nielsen and Webb 2023):
//!
//! ```text
//! V = (m − 1)/m Σₑ (δₑ − δ̄)(δₑ − δ̄)ᵀ,    δₑ = (H − Hₑ)⁻¹ gₑ
//! ```
//!
//! δₑ is the first-order change of the estimate when episode e is left out. Intervals use Student's t with m
//! − 1 degrees of freedom. The covariance describes the variation between sets of episodes; an error common
//! to all episodes is not included.
//!
//! A parameter that a single episode determines, such as the time of an event, has no variation between
//! episodes. Its standard deviation is that of the curvature times the root mean square factor by which those
//! of the other parameters grow.

use crate::{Coordinates, Estimate, Fit, InferError, Likelihood};
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use statrs::distribution::{ContinuousCDF, StudentsT};
use trundle_model::{Model, Slot};

/// Minimum number of episodes: two give only one difference.
const MIN_EPISODES: usize = 3;

/// Central probability of intervals.
pub const INTERVAL_COVERAGE: f64 = 0.9;

/// Source of the intervals of a fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Basis {
    /// Inverse curvature of the posterior: valid if the model is correct.
    Curvature,
    /// Sandwich covariance over this number of episodes.
    Sandwich(usize),
}

impl Basis {
    /// Half width of a 90 % interval, in standard deviations.
    pub fn quantile(self) -> f64 {
        // With this many degrees of freedom Student's t is normal.
        let freedom = match self {
            Self::Curvature => 1e6,
            Self::Sandwich(episodes) => (episodes.max(2) - 1) as f64,
        };
        StudentsT::new(0.0, 1.0, freedom)
            .map_or(f64::INFINITY, |t| t.inverse_cdf(0.5 + INTERVAL_COVERAGE / 2.0))
    }
}

impl Fit {
    /// The same fit with the sandwich covariance over the episodes of some likelihoods instead of the inverse
    /// curvature; `None` with fewer than three episodes. No standard deviation decreases.
    ///
    /// `model` is the fitted model, with its free parameters shared by all episodes. Each likelihood has the
    /// noise of the fit.
    ///
    /// # Errors
    /// When a likelihood cannot be evaluated.
    pub fn sandwiched(
        &self,
        model: &Model,
        likelihoods: &[&dyn Likelihood],
    ) -> Result<Option<(Self, Basis)>, InferError> {
        let noise = likelihoods.iter().take(1).flat_map(|l| l.noise());
        let coordinates =
            Coordinates::of(model.slots().into_iter().chain(noise).collect()).with_footprint(model);
        let parts: Vec<_> = likelihoods.iter().flat_map(|l| l.split()).collect();
        let fitting = coordinates.free().len() == self.point.len();
        let posterior = self.spread.clone().try_inverse();
        let (true, true, Some(posterior)) = (fitting, parts.len() >= MIN_EPISODES, posterior) else {
            return Ok(None);
        };
        let (values, slopes) = coordinates.values(&self.point);
        let mut shifts = Vec::with_capacity(parts.len());
        let mut single = vec![false; slopes.len()];
        for (_, part) in &parts {
            let at = part.linearise(model, &values, coordinates.free())?;
            let gradient = DVector::from_fn(slopes.len(), |k, _| at.gradient[k] * slopes[k]);
            let own = DMatrix::from_fn(slopes.len(), slopes.len(), |i, j| {
                at.curvature[(i, j)] * slopes[i] * slopes[j]
            });
            let Some(others) = Cholesky::<f64, Dyn>::new(&posterior - own) else { return Ok(None) };
            shifts.push(others.solve(&gradient));
            let without = others.inverse();
            for (k, single) in single.iter_mut().enumerate() {
                *single |= !coordinates.identified(k, without[(k, k)].max(0.0).sqrt());
            }
        }
        let spread = no_smaller(with_single_episode(jackknife(&shifts), &self.spread, &single), &self.spread);
        if !spread.iter().all(|v| v.is_finite()) {
            return Ok(None);
        }
        Ok(Some((self.with_spread(spread, &slopes), Basis::Sandwich(parts.len()))))
    }

    /// The same fit with standard deviations scaled so that 1.645 of them give the 90 % intervals of a
    /// `basis`.
    #[must_use]
    pub fn as_normal(&self, basis: Basis) -> Self {
        let factor = basis.quantile() / Basis::Curvature.quantile();
        let estimates = self.estimates.iter().map(|e| Estimate { sd: e.sd * factor, ..e.clone() });
        Self {
            estimates: estimates.collect(),
            spread: &self.spread * factor.powi(2),
            covariance: &self.covariance * factor.powi(2),
            ..self.clone()
        }
    }

    /// The same fit with larger standard deviations: the largest distance of each parameter from its estimate
    /// in the fits of `others` acceptable models is added in quadrature.
    #[must_use]
    pub fn widened_by(&self, others: &[&Self]) -> Self {
        let mut wider = self.clone();
        for (k, estimate) in wider.estimates.iter_mut().enumerate() {
            let deviation =
                |other: &&Self| other.estimate(&estimate.name).map_or(0.0, |e| e.mean - estimate.mean);
            let most = others.iter().map(|other| deviation(other).abs()).fold(0.0, f64::max);
            let factor = (1.0 + (most / estimate.sd.max(f64::MIN_POSITIVE)).powi(2)).sqrt();
            estimate.sd *= factor;
            for matrix in [&mut wider.covariance, &mut wider.spread] {
                matrix.row_mut(k).scale_mut(factor);
                matrix.column_mut(k).scale_mut(factor);
            }
        }
        wider
    }

    /// 90 % interval of the free parameter `k`, within its bounds.
    pub fn interval(&self, k: usize, basis: Basis) -> [f64; 2] {
        let slot = Slot { value: None, ..self.slots[k].clone() };
        let half_width = basis.quantile() * self.spread[(k, k)].max(0.0).sqrt();
        let coordinate = Coordinates::of(vec![slot]);
        [-half_width, half_width].map(|deviation| coordinate.values(&[self.point[k] + deviation]).0[0])
    }

    fn with_spread(&self, spread: DMatrix<f64>, slopes: &[f64]) -> Self {
        let covariance =
            DMatrix::from_fn(slopes.len(), slopes.len(), |i, j| spread[(i, j)] * slopes[i] * slopes[j]);
        let wider =
            |(k, e): (usize, &Estimate)| Estimate { sd: covariance[(k, k)].max(0.0).sqrt(), ..e.clone() };
        let estimates = self.estimates.iter().enumerate().map(wider).collect();
        Self { estimates, spread, covariance, ..self.clone() }
    }
}

/// Covariance of an estimate from the changes when each episode is left out.
fn jackknife(shifts: &[DVector<f64>]) -> DMatrix<f64> {
    let (m, n) = (shifts.len() as f64, shifts.first().map_or(0, DVector::len));
    let mean = shifts.iter().fold(DVector::zeros(n), |sum, shift| sum + shift) / m;
    let deviation = shifts.iter().map(|shift| shift - &mean);
    deviation.fold(DMatrix::zeros(n, n), |sum, d| sum + &d * d.transpose()) * ((m - 1.0) / m)
}

/// Replaces the variances of parameters that a single episode determines by the curvature's, times the mean
/// growth of the other variances.
fn with_single_episode(
    mut covariance: DMatrix<f64>,
    curvature: &DMatrix<f64>,
    single: &[bool],
) -> DMatrix<f64> {
    let growth = |k: usize| (covariance[(k, k)] / curvature[(k, k)].max(f64::MIN_POSITIVE)).max(1.0);
    let others: Vec<f64> = (0..single.len()).filter(|&k| !single[k]).map(growth).collect();
    let factor = if others.is_empty() { 1.0 } else { others.iter().sum::<f64>() / others.len() as f64 };
    for k in (0..single.len()).filter(|&k| single[k]) {
        covariance.row_mut(k).fill(0.0);
        covariance.column_mut(k).fill(0.0);
        covariance[(k, k)] = curvature[(k, k)] * factor;
    }
    covariance
}

/// Raises standard deviations to at least those of `least` and keeps the correlations.
fn no_smaller(covariance: DMatrix<f64>, least: &DMatrix<f64>) -> DMatrix<f64> {
    let n = covariance.nrows();
    let factor = |k: usize| (least[(k, k)] / covariance[(k, k)].max(f64::MIN_POSITIVE)).sqrt().max(1.0);
    let factors: Vec<f64> = (0..n).map(factor).collect();
    DMatrix::from_fn(n, n, |i, j| covariance[(i, j)] * factors[i] * factors[j])
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::dmatrix;

    #[test]
    fn the_jackknife_of_a_mean_is_the_sample_variance_over_the_count() {
        // The mean of x without xₑ moves by (mean − xₑ)/(m − 1).
        let x = [1.0, 4.0, 2.5, 7.0, 3.0];
        let mean = x.iter().sum::<f64>() / 5.0;
        let shifts: Vec<_> = x.iter().map(|v| DVector::from_element(1, (mean - v) / 4.0)).collect();
        let sample = x.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / 4.0;
        assert!((jackknife(&shifts)[(0, 0)] - sample / 5.0).abs() < 1e-12);
    }

    #[test]
    fn no_standard_deviation_shrinks_and_correlations_stay() {
        let narrow = dmatrix![4.0, 0.6; 0.6, 0.09];
        let found = no_smaller(narrow, &dmatrix![1.0, 0.0; 0.0, 1.0]);
        assert!((found[(0, 0)] - 4.0).abs() < 1e-12 && (found[(1, 1)] - 1.0).abs() < 1e-12);
        assert!((found[(0, 1)] / 2.0 - 1.0).abs() < 1e-12);
    }

    #[test]
    fn parameters_of_a_single_episode_grow_like_the_others() {
        let spread = dmatrix![9.0, 1.0, 5.0; 1.0, 4.0, 5.0; 5.0, 5.0, 80.0];
        let curvature = dmatrix![1.0, 0.2, 0.0; 0.2, 4.0, 0.0; 0.0, 0.0, 2.0];
        let found = with_single_episode(spread, &curvature, &[false, false, true]);
        assert_eq!(found, dmatrix![9.0, 1.0, 0.0; 1.0, 4.0, 0.0; 0.0, 0.0, 10.0]);
    }

    #[test]
    fn as_normal_widens_to_students_interval() {
        let factor = Basis::Sandwich(6).quantile() / Basis::Curvature.quantile();
        assert!((factor - 2.015_05 / 1.644_85).abs() < 1e-4);
    }

    #[test]
    fn quantiles_are_students() {
        assert!((Basis::Curvature.quantile() - 1.644_85).abs() < 1e-4);
        assert!((Basis::Sandwich(6).quantile() - 2.015_05).abs() < 1e-4);
    }
}
