//! Modes of the posterior, found by several searches.
//!
//! The position of a wheel has local optima. Those with more than one part in a thousand of the evidence, by
//! Laplace's approximation, are sampled, each by some of the chains.

use nalgebra::{DMatrix, DVector};
use serde::Serialize;
use trundle_infer::{Fit, FitOptions, InferError, Likelihood, Target, Watch, fit};
use trundle_model::{Model, Prior};

/// Maximum difference of log evidence of a sampled mode from the best mode, nats.
const MAX_MODE_LOSS_NATS: f64 = 7.0;

/// Minimum distance between two modes, standard deviations.
const MIN_MODE_DISTANCE_SD: f64 = 6.0;

/// A mode of the posterior.
#[derive(Clone, Debug)]
pub struct Mode {
    /// Position in the coordinates of the target.
    pub point: Vec<f64>,
    /// Precision of the Laplace approximation.
    pub precision: DMatrix<f64>,
    /// Log evidence by Laplace's approximation.
    pub log_evidence: f64,
}

/// Summary of a mode.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ModeSummary {
    /// Values of the free parameters.
    pub values: Vec<f64>,
    /// Share of the evidence among the modes found, by Laplace's approximation.
    pub weight: f64,
}

/// Result of a search for modes.
pub struct FoundModes {
    /// The best fit, from which estimates and chains start.
    pub best: Fit,
    /// The modes to sample, that of the best fit first.
    pub modes: Vec<Mode>,
}

/// Extent of a search for modes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SearchExtent {
    /// Enough for the best fit: starts are searched individually only if no two agree on the best end.
    Best,
    /// Every start is also searched individually, for further modes with similar evidence.
    EveryMode,
}

/// Search from `warm` starts (values of all slots) and `options.starts` random ones together, then
/// individually from as many.
///
/// A joint search refines only the most promising starts. Where no two of them agree on the best end, for
/// example because the model does not explain the data, another start may end much lower. Both extents use
/// the same starts in that case and return the same best fit.
///
/// # Errors
/// As [`trundle_infer::fit`].
pub fn search_modes(
    likelihood: &dyn Likelihood,
    model: &Model,
    warm: &[Vec<f64>],
    options: &FitOptions,
    extent: SearchExtent,
    watch: &dyn Watch,
) -> Result<FoundModes, InferError> {
    let joint = fit(likelihood, model, warm, options, watch)?;
    let target = Target::new(likelihood, model, &options.per_episode)?;
    let agreed = joint.agreement.0 > 1;
    let alone = |k: u64| {
        let seed = options.seed.wrapping_add(1 + k);
        match fit(likelihood, model, &[], &FitOptions { starts: 1, seed, ..options.clone() }, watch) {
            Ok(found) => Ok(Some(found)),
            Err(InferError::NoStart { .. }) => Ok(None),
            Err(error) => Err(error),
        }
    };
    // A search from one start, or from given starts only, is not extended.
    let more = extent == SearchExtent::EveryMode || (options.starts > 1 && !agreed);
    // Sequential, because each search uses all cores.
    let seeds = 0..if more { options.starts as u64 } else { 0 };
    let others: Vec<Fit> = seeds.map(alone).collect::<Result<Vec<_>, _>>()?.into_iter().flatten().collect();
    let mut fits = ranked(joint, others);
    let modes = distinct(&target, fits.iter().map(|f| mode(&target, f)));
    Ok(FoundModes { best: fits.swap_remove(0), modes })
}

/// Maximum difference of log evidence between searches that end at the same optimum, nats.
const MAX_TIE_NATS: f64 = 1.0;

/// Fits in order of evidence. The joint fit comes first unless another one is better. The first fit receives
/// the number of agreeing starts.
fn ranked(joint: Fit, others: Vec<Fit>) -> Vec<Fit> {
    let alone = others.len();
    let mut fits = others;
    fits.sort_by(|a, b| b.log_evidence.total_cmp(&a.log_evidence));
    let together = joint.agreement;
    let beaten = fits.first().is_some_and(|other| other.log_evidence > joint.log_evidence + MAX_TIE_NATS);
    let place =
        if beaten { fits.partition_point(|other| other.log_evidence > joint.log_evidence) } else { 0 };
    let evidence = joint.log_evidence;
    fits.insert(place, joint);
    let lead = fits[0].log_evidence.max(evidence);
    let same = |other: &Fit| (other.log_evidence - lead).abs() <= MAX_TIE_NATS;
    let agreeing = fits.iter().enumerate().filter(|(k, other)| *k != place && same(other)).count();
    fits[0].agreement = (agreeing + if beaten { 0 } else { together.0 }, together.1 + alone);
    fits
}

fn mode(target: &Target<'_>, fit: &Fit) -> Mode {
    let mut precision = fit.information.clone();
    for k in 0..fit.point.len() {
        let (coordinates, parameter) = (target.coordinates(), target.parameter(k));
        precision[(k, k)] += coordinates.min_precision(parameter).max(coordinates.prior_precision(parameter));
    }
    Mode { point: fit.point.clone(), precision, log_evidence: fit.log_evidence }
}

/// Modes with non-negligible evidence that are far from all better ones; `modes` are in order of evidence.
fn distinct(target: &Target<'_>, modes: impl Iterator<Item = Mode>) -> Vec<Mode> {
    let mut kept: Vec<Mode> = vec![];
    for candidate in modes {
        let best = kept.first().map_or(candidate.log_evidence, |mode| mode.log_evidence);
        let far = kept.iter().all(|mode| distance(target, mode, &candidate.point) > MIN_MODE_DISTANCE_SD);
        if far && candidate.log_evidence > best - MAX_MODE_LOSS_NATS {
            kept.push(candidate);
        }
    }
    kept
}

/// Distance of a point from a mode in standard deviations; angles are wrapped.
fn distance(target: &Target<'_>, mode: &Mode, point: &[f64]) -> f64 {
    let mut near = point.to_vec();
    for (k, z) in near.iter_mut().enumerate() {
        *z = nearest(&target.slot(k).prior, *z, mode.point[k]);
    }
    let away = DVector::from_vec(near) - DVector::from_column_slice(&mode.point);
    away.dot(&(&mode.precision * &away)).max(0.0).sqrt()
}

/// An angle shifted by whole periods to within half a period of another.
pub(crate) fn nearest(prior: &Prior, z: f64, to: f64) -> f64 {
    match prior {
        Prior::Angle(period) => z - period * ((z - to) / period).round(),
        _ => z,
    }
}

/// Shares of the evidence.
pub(crate) fn weights(modes: &[Mode]) -> Vec<f64> {
    let best = modes.iter().map(|m| m.log_evidence).fold(f64::NEG_INFINITY, f64::max);
    let shares: Vec<f64> = modes.iter().map(|m| (m.log_evidence - best).exp()).collect();
    let sum: f64 = shares.iter().sum();
    shares.into_iter().map(|s| s / sum).collect()
}
