//! Localisation of the misfit of a simulation: in time, by channel, on the object, on the floor, and by motion
//! regime.
//!
//! p-values use whitened innovations (`score_test`), never the smoothed residual, whose samples are correlated.
//! Only identifiable results are reported, so that "no window", "no point" and "no region" are valid answers. The
//! same scans provide starts for the search.

mod body_points;
mod change_points;
mod floor;
mod knots;
mod lines_of_action;
mod misfit_shares;
mod places;
mod regime;
mod scan_data;
mod score_test;
mod windows;

#[cfg(test)]
mod tests;

use crate::answer::{Channels as Shares, Mismatch, Window};
use crate::lack_of_fit::LackOfFit;
use places::{RankedPlace, Region};
use regime::Regime;
use scan_data::ScanData;
use trundle_infer::{Channels, Comparison, Fit, FitOptions, InferError, MotionLikelihood, Quiet, Residual};
use trundle_model::{Body, Model};
use trundle_record::Prepared;

#[cfg(test)]
use change_points::ChangeKind;
pub(crate) use change_points::ChangePoint;
pub(crate) use misfit_shares::misfit_shares;
pub(crate) use windows::MAX_WINDOW_GAP_S;

/// The missing wrench along each episode, object axes.
pub(crate) type Residuals = Vec<Vec<Residual>>;

/// Results of the scans: the mismatch for the answer, and starts for the search. Lists are ranked, best first,
/// and empty if nothing is significant.
#[derive(Clone, Debug, Default)]
pub(crate) struct Located {
    /// Time windows in order. Each has a strength that one of a hundred clean recordings reaches.
    pub windows: Vec<Window>,
    /// Body points through which the missing force passes.
    #[cfg_attr(not(test), expect(dead_code, reason = "an intermediate result that tests check"))]
    pub body_points: Vec<RankedPlace>,
    /// The best of them, if it is identifiable.
    pub body_point: Option<RankedPlace>,
    /// Body points at which dry friction would explain the misfit.
    pub friction_points: Vec<RankedPlace>,
    /// Regions of the floor with drag.
    pub regions: Vec<Region>,
    /// Times from which the damping or the mass differs.
    #[cfg_attr(not(test), expect(dead_code, reason = "an intermediate result that tests check"))]
    pub change_points: Vec<ChangePoint>,
    /// Motion regime of the misfit.
    pub regime: Option<Regime>,
    /// χ² that any missing wrench explains.
    pub total: f64,
    /// Strength of the strongest window, reported or not.
    #[cfg_attr(not(test), expect(dead_code, reason = "an intermediate result that tests check"))]
    pub max_strength: f64,
}

/// Minimum share of `total` that dry friction at one point must explain for the point to be reported.
const MIN_FRICTION_SHARE: f64 = 0.6;

/// Seed of the bootstrap.
const BOOTSTRAP_SEED: u64 = 0x5eed;

impl Located {
    /// Scans the misfit of a fit to some episodes. If it is significant, the scan linearises at parameters that the
    /// missing effects do not bias.
    ///
    /// # Errors
    /// If the fit's values do not suit its model.
    pub fn new(
        motion: &MotionLikelihood,
        fit: &Fit,
        left: LackOfFit,
        episodes: &[Prepared],
    ) -> Result<Self, InferError> {
        let unbiased = if left.is_significant(0) { Some(unbiased(motion, left.channels, fit)) } else { None };
        let fit = unbiased.as_ref().unwrap_or(fit);
        let residuals = motion.with_channels(left.channels).residuals(&fit.model, &fit.values)?;
        let Some(residuals) = residuals.as_deref() else { return Ok(Self::default()) };
        let Some(data) = ScanData::new(motion, fit, residuals)? else { return Ok(Self::default()) };
        let names: Vec<String> = episodes.iter().map(|e| e.name.clone()).collect();
        let contacts: Vec<f64> = episodes.iter().map(|e| e.contact).collect();
        let (pieces, independent, max_strength) =
            windows::scan(&data.score_test, &data.knots, BOOTSTRAP_SEED);
        let body = &fit.model.body;
        let is_planar = data.score_test.free_directions() == 3 && !pieces.is_empty();
        let action_residuals = if is_planar { residuals } else { &[] };
        let (body_points, body_point) = body_points::action_points(action_residuals, body);
        let regions = floor::regions(&data.score_test, body);
        let change_points = change_points::change_points(&data);
        let regime = regime::regime(&data, &change_points, &regions, &names, &contacts);
        Ok(Self {
            windows: windows::windows(&pieces, &names, independent, data.score_test.free_directions()),
            body_points,
            body_point,
            friction_points: body_points::friction_points(&data.score_test, body),
            regions,
            change_points,
            regime: if pieces.is_empty() { None } else { regime },
            total: data.total,
            max_strength,
        })
    }

    /// Results from the smoothed missing wrench alone, with the windows in which it differs from zero.
    pub fn from_residuals(residuals: &[Vec<Residual>], windows: Vec<Window>, body: &Body) -> Self {
        let residuals = if windows.is_empty() { &[] } else { residuals };
        let (body_points, body_point) = body_points::action_points(residuals, body);
        Self { windows, body_points, body_point, ..Self::default() }
    }

    /// The body point to report, if one is identifiable: from the lines of action, or else the point whose dry
    /// friction explains most.
    fn reported_point(&self) -> Option<[f64; 2]> {
        let explains_enough =
            |r: &&RankedPlace| 2.0 * r.strength > MIN_FRICTION_SHARE * self.total && r.is_inside;
        self.body_point.as_ref().or(self.friction_points.first().filter(explains_enough)).map(|p| p.at)
    }

    /// The region to report, if it explains most of the misfit, and more than dry friction at a point of the object.
    fn reported_region(&self) -> Option<Vec<[f64; 2]>> {
        let best = self.regions.first()?;
        let friction = self.friction_points.first().map_or(0.0, |r| 2.0 * r.strength);
        let is_localised =
            best.chi_square > 0.5 * self.total && best.chi_square > friction && best.share < 0.6;
        is_localised.then(|| best.polygon.clone())
    }
}

/// Refits a model with a random-walk missing wrench, so that missing effects do not bias the parameters; the
/// original fit if that fails.
fn unbiased(motion: &MotionLikelihood, wander: Channels, fit: &Fit) -> Fit {
    let options = FitOptions { starts: 0, distant_starts: false, ..FitOptions::default() };
    let wandering = motion.with_channels(wander);
    trundle_infer::fit(
        &wandering,
        &with_free_parameters(fit),
        std::slice::from_ref(&fit.values),
        &options,
        &Quiet,
    )
    .unwrap_or_else(|_| fit.clone())
}

/// The model of a fit with its estimated parameters free again.
fn with_free_parameters(fit: &Fit) -> Model {
    let mut model = fit.model.clone();
    let names = model.effect_names();
    if fit.estimate("body.mass").is_some() {
        model.mass = None;
    }
    for (effect, name) in model.effects.iter_mut().zip(names) {
        let params = effect.kind.spec().params;
        for (value, param) in effect.values.iter_mut().zip(params) {
            if fit.estimate(&format!("{name}.{}", param.name)).is_some() {
                *value = None;
            }
        }
    }
    model
}

/// Scans the misfit of a fitted model; empty if only wrenches are compared.
///
/// # Errors
/// If the fit's values do not suit its model.
pub(crate) fn locate(
    comparison: &Comparison,
    fit: &Fit,
    left: Option<LackOfFit>,
    episodes: &[Prepared],
) -> Result<Located, InferError> {
    match (comparison.with_channels(fit.channels), left) {
        (Comparison::Motion(motion), Some(left)) => Located::new(&motion, fit, left, episodes),
        _ => Ok(Located::default()),
    }
}

impl Located {
    /// The mismatch for the answer.
    pub fn mismatch(&self, channels: Shares) -> Mismatch {
        Mismatch {
            channels,
            body_point: self.reported_point(),
            world_region: self.reported_region(),
            windows: self.windows.clone(),
            regime: self.regime.as_ref().map(|r| r.description.clone()),
            regime_kind: self.regime.as_ref().map(|r| r.kind),
        }
    }
}
