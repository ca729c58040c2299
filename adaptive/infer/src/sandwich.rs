//! Intervals that include model error: the covariance of an estimate from its spread between episodes.
//!
//! The inverse curvature is the covariance of an estimate only if the model is right. Otherwise the gradients of the
//! episodes scatter more than their curvature says, and the sandwich covariance is the one to use (Huber 1967, White
//! 1982). Samples within an episode are dependent, so that episodes are the independent units ("clusters"):
//!
//! ```text
//! V = H⁻¹ (Σₑ gₑ gₑᵀ) H⁻¹             H: posterior curvature, gₑ: gradient of episode e at the estimate
//! ```
//!
//! With few episodes this is too narrow, because the estimate bends to each of them. Its jackknife form corrects for that
//! (CR3; Bell and McCaffrey 2002, MacKinnon, Nielsen and Webb 2023):
//!
//! ```text
//! V = (m − 1)/m Σₑ (δₑ − δ̄)(δₑ − δ̄)ᵀ,    δₑ = (H − Hₑ)⁻¹ gₑ
//! ```
//!
//! δₑ is what leaving out the episode e would change, to first order. Intervals use Student's t with m − 1 degrees of
//! freedom. The covariance says how much an estimate varies from one set of episodes to another. An error that is the same
//! in all episodes is not in it.
//!
//! A parameter that the other episodes do not hold without one of them, like the moment of an event, has no spread between
//! episodes. Its standard deviation is that of the curvature times the factor by which those of the others grow, as a root
//! mean square.

use crate::{Coordinates, Estimate, Fit, InferError, Likelihood};
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use statrs::distribution::{ContinuousCDF, StudentsT};
use trundle_model::{Model, Slot};

/// Fewer episodes say nothing about the spread between episodes: two give one difference.
const MIN_EPISODES: usize = 3;

/// Central probability of the intervals.
const COVERAGE: f64 = 0.9;

/// Where the intervals of a fit come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Basis {
    /// Inverse curvature of the posterior: right if the model is.
    Curvature,
    /// Sandwich covariance over so many episodes.
    Sandwich(usize),
}

impl Basis {
    /// Half of the width of a 90 % interval, in standard deviations.
    pub fn quantile(self) -> f64 {
        // With so many degrees of freedom Student's t is normal.
        let freedom = match self {
            Self::Curvature => 1e6,
            Self::Sandwich(episodes) => (episodes.max(2) - 1) as f64,
        };
        StudentsT::new(0.0, 1.0, freedom).map_or(f64::INFINITY, |t| t.inverse_cdf(0.5 + COVERAGE / 2.0))
    }
}

impl Fit {
    /// The same fit with the sandwich covariance over the episodes of some likelihoods in the place of the inverse
    /// curvature; `None` with fewer than three episodes. No parameter becomes more certain.
    ///
    /// `model` is the model that was fitted, its free parameters shared by all episodes, and each likelihood has the
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
        let coordinates = Coordinates::of(model.slots().into_iter().chain(noise).collect()).under(model);
        let parts: Vec<_> = likelihoods.iter().flat_map(|l| l.split()).collect();
        let fitting = coordinates.free().len() == self.point.len();
        let posterior = self.spread.clone().try_inverse();
        let (true, true, Some(posterior)) = (fitting, parts.len() >= MIN_EPISODES, posterior) else {
            return Ok(None);
        };
        let (values, slopes) = coordinates.values(&self.point);
        let mut shifts = Vec::with_capacity(parts.len());
        let mut alone = vec![false; slopes.len()];
        for (_, part) in &parts {
            let at = part.linearise(model, &values, coordinates.free())?;
            let gradient = DVector::from_fn(slopes.len(), |k, _| at.gradient[k] * slopes[k]);
            let own = DMatrix::from_fn(slopes.len(), slopes.len(), |i, j| {
                at.curvature[(i, j)] * slopes[i] * slopes[j]
            });
            let Some(others) = Cholesky::<f64, Dyn>::new(&posterior - own) else { return Ok(None) };
            shifts.push(others.solve(&gradient));
            let without = others.inverse();
            for (k, alone) in alone.iter_mut().enumerate() {
                *alone |= !coordinates.identified(k, without[(k, k)].max(0.0).sqrt());
            }
        }
        let spread = no_narrower(shared(jackknife(&shifts), &self.spread, &alone), &self.spread);
        if !spread.iter().all(|v| v.is_finite()) {
            return Ok(None);
        }
        Ok(Some((self.with_spread(spread, &slopes), Basis::Sandwich(parts.len()))))
    }

    /// The same with its standard deviations such that 1.645 of them make the 90 % intervals of a `basis`, as if estimates
    /// were normal.
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

    /// The same with its standard deviations raised, root of sum of squares, by how far each parameter is in the fits of
    /// `other` models that the data do not exclude.
    #[must_use]
    pub fn allowing(&self, others: &[&Self]) -> Self {
        let mut wider = self.clone();
        for (k, estimate) in wider.estimates.iter_mut().enumerate() {
            let away = |other: &&Self| other.estimate(&estimate.name).map_or(0.0, |e| e.mean - estimate.mean);
            let most = others.iter().map(|other| away(other).abs()).fold(0.0, f64::max);
            let factor = (1.0 + (most / estimate.sd.max(f64::MIN_POSITIVE)).powi(2)).sqrt();
            estimate.sd *= factor;
            for matrix in [&mut wider.covariance, &mut wider.spread] {
                matrix.row_mut(k).scale_mut(factor);
                matrix.column_mut(k).scale_mut(factor);
            }
        }
        wider
    }

    /// The 90 % interval of the free parameter `k`, within its bounds.
    pub fn interval(&self, k: usize, basis: Basis) -> [f64; 2] {
        let slot = Slot { value: None, ..self.slots[k].clone() };
        let reach = basis.quantile() * self.spread[(k, k)].max(0.0).sqrt();
        let coordinate = Coordinates::of(vec![slot]);
        [-reach, reach].map(|away| coordinate.values(&[self.point[k] + away]).0[0])
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

/// Covariance of a mean from what leaving out each part changes.
fn jackknife(shifts: &[DVector<f64>]) -> DMatrix<f64> {
    let (m, n) = (shifts.len() as f64, shifts.first().map_or(0, DVector::len));
    let mean = shifts.iter().fold(DVector::zeros(n), |sum, shift| sum + shift) / m;
    let away = shifts.iter().map(|shift| shift - &mean);
    away.fold(DMatrix::zeros(n, n), |sum, d| sum + &d * d.transpose()) * ((m - 1.0) / m)
}

/// A covariance in which parameters that one episode tells `alone` have the curvature's times what the others' grow by.
fn shared(mut covariance: DMatrix<f64>, curvature: &DMatrix<f64>, alone: &[bool]) -> DMatrix<f64> {
    let growth = |k: usize| (covariance[(k, k)] / curvature[(k, k)].max(f64::MIN_POSITIVE)).max(1.0);
    let others: Vec<f64> = (0..alone.len()).filter(|&k| !alone[k]).map(growth).collect();
    let factor = if others.is_empty() { 1.0 } else { others.iter().sum::<f64>() / others.len() as f64 };
    for k in (0..alone.len()).filter(|&k| alone[k]) {
        covariance.row_mut(k).fill(0.0);
        covariance.column_mut(k).fill(0.0);
        covariance[(k, k)] = curvature[(k, k)] * factor;
    }
    covariance
}

/// A covariance with its standard deviations raised to those of `least`, its correlations kept.
fn no_narrower(covariance: DMatrix<f64>, least: &DMatrix<f64>) -> DMatrix<f64> {
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
    fn of_a_mean_the_jackknife_is_the_sample_variance_over_the_count() {
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
        let found = no_narrower(narrow, &dmatrix![1.0, 0.0; 0.0, 1.0]);
        assert!((found[(0, 0)] - 4.0).abs() < 1e-12 && (found[(1, 1)] - 1.0).abs() < 1e-12);
        assert!((found[(0, 1)] / 2.0 - 1.0).abs() < 1e-12);
    }

    #[test]
    fn what_one_episode_tells_alone_grows_like_the_others() {
        let spread = dmatrix![9.0, 1.0, 5.0; 1.0, 4.0, 5.0; 5.0, 5.0, 80.0];
        let curvature = dmatrix![1.0, 0.2, 0.0; 0.2, 4.0, 0.0; 0.0, 0.0, 2.0];
        let found = shared(spread, &curvature, &[false, false, true]);
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
