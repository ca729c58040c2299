//! Where the simulation goes wrong: in time, by channel, over the body, on the floor, in which motions.
//!
//! p-values come from whitened innovations (`screen`), never from the smoothed residual, whose samples are
//! correlated. What is not held is not told: no window, no point, no region is an answer. The same scans give the
//! search its starting guesses.

mod body;
mod change;
mod channels;
mod floor;
mod knots;
mod lines;
mod regime;
mod screen;
mod time;

#[cfg(test)]
mod tests;

use crate::adequacy::Remainder;
use crate::answer::{Channels as Shares, Mismatch, Window};
use knots::Knots;
use screen::Screen;
use trundle_infer::{Channels, Comparison, Fit, FitOptions, InferError, MotionLikelihood, Quiet, Residual};
use trundle_model::{Body, Model};
use trundle_record::Prepared;

pub(crate) use change::Change;
#[cfg(test)]
use change::Kind as Changed;
pub(crate) use channels::channels;

/// The missing wrench along each episode, object axes.
pub(crate) type Residuals = Vec<Vec<Residual>>;

/// A place, ranked.
#[derive(Clone, Debug)]
pub(crate) struct Ranked {
    /// m; object frame or world, as the list says.
    pub at: [f64; 2],
    /// Standard deviations, m; infinite where not known.
    pub sd: [f64; 2],
    /// Log likelihood, up to a constant of its list.
    pub strength: f64,
    /// Share of the missing moment, squared, that is left about it.
    pub left: f64,
    /// Whether the search was not stopped there.
    pub inside: bool,
}

/// A part of the floor.
#[derive(Clone, Debug)]
#[allow(dead_code)] // its strength is for whoever ranks starts
pub(crate) struct Region {
    /// Convex, counter-clockwise, world, m.
    pub polygon: Vec<[f64; 2]>,
    /// Of one common viscous drag inside it.
    pub chi_square: f64,
    /// −log10 p, corrected for the cells among which it was chosen.
    pub strength: f64,
    /// Share of the cells that were visited.
    pub share: f64,
}

/// What all scans look at.
pub(crate) struct Seen {
    pub screen: Screen,
    pub knots: Vec<Knots>,
    /// χ² that a wrench of any kind explains.
    pub total: f64,
}

impl Seen {
    fn new(
        motion: &MotionLikelihood,
        fit: &Fit,
        residuals: &[Vec<Residual>],
    ) -> Result<Option<Self>, InferError> {
        let Some(screen) = Screen::new(motion, fit, residuals)? else { return Ok(None) };
        let knots = knots::knots(&screen);
        let total = knots::anything(&knots);
        Ok(Some(Self { screen, knots, total }))
    }
}

/// What the scans found: the mismatch for the answer, and where a search may start. Every list is ranked, best first,
/// and empty where nothing stands out.
#[derive(Clone, Debug, Default)]
#[allow(dead_code)] // what the answer does not tell is for the search
pub(crate) struct Located {
    /// Stretches of time, in order; each of a strength that a clean recording shows in one case of a hundred.
    pub windows: Vec<Window>,
    /// Body points through which the missing force passes.
    pub body_points: Vec<Ranked>,
    /// The one that the data hold.
    pub body_point: Option<Ranked>,
    /// Body points at which dry friction would help.
    pub rubbing: Vec<Ranked>,
    /// Parts of the floor that drag.
    pub regions: Vec<Region>,
    /// Moments from which on damping or mass are others.
    pub change_points: Vec<Change>,
    /// World points through which the missing force passes.
    pub world_points: Vec<Ranked>,
    /// The one that the data hold.
    pub world_point: Option<Ranked>,
    /// In which motions.
    pub regime: Option<String>,
    /// χ² that a wrench of any kind explains.
    pub total: f64,
    /// Strength of the strongest window, told or not.
    pub loudest: f64,
}

/// Share of what any wrench explains that dry friction at one point must explain to tell that point.
const RUBS: f64 = 0.6;

/// Seed of the bootstrap.
const SEED: u64 = 0x5eed;

impl Located {
    /// Scan what a fit leaves along episodes. Where it leaves something, the scan looks from values that do not bend
    /// to it.
    ///
    /// # Errors
    /// When the fit's values do not suit its model.
    pub fn new(
        motion: &MotionLikelihood,
        fit: &Fit,
        left: Remainder,
        episodes: &[Prepared],
    ) -> Result<Self, InferError> {
        let unbent = if left.matters(0) { Some(unbent(motion, left.channels, fit)) } else { None };
        let fit = unbent.as_ref().unwrap_or(fit);
        let residuals = motion.with_channels(left.channels).residuals(&fit.model, &fit.values)?;
        let Some(residuals) = residuals.as_deref() else { return Ok(Self::default()) };
        let Some(seen) = Seen::new(motion, fit, residuals)? else { return Ok(Self::default()) };
        let names: Vec<String> = episodes.iter().map(|e| e.name.clone()).collect();
        let contacts: Vec<f64> = episodes.iter().map(|e| e.contact).collect();
        let (pieces, independent, loudest) = time::scan(&seen.screen, &seen.knots, SEED);
        let body = &fit.model.body;
        let turns = seen.screen.directions() == 3 && !pieces.is_empty();
        let courses = if turns { residuals } else { &[] };
        let (body_points, body_point) = body::action(courses, body);
        let (world_points, world_point) = floor::world_points(courses, body);
        let regions = floor::regions(&seen.screen, body);
        let change_points = change::changes(&seen);
        let regime = regime::regime(&seen, &change_points, &regions, &names, &contacts);
        Ok(Self {
            windows: time::windows(&pieces, &names, independent, seen.screen.directions()),
            body_points,
            body_point,
            rubbing: body::rubbing(&seen.screen, body),
            regions,
            change_points,
            world_points,
            world_point,
            regime: if pieces.is_empty() { None } else { regime },
            total: seen.total,
            loudest,
        })
    }

    /// What the missing wrench alone tells, smoothed along the episodes, with the windows in which it is not zero.
    pub fn of_courses(courses: &[Vec<Residual>], windows: Vec<Window>, body: &Body) -> Self {
        let courses = if windows.is_empty() { &[] } else { courses };
        let (body_points, body_point) = body::action(courses, body);
        let (world_points, world_point) = floor::world_points(courses, body);
        Self { windows, body_points, body_point, world_points, world_point, ..Self::default() }
    }

    /// The body point, if the data hold one: of the lines of action, or else the foot whose dry friction explains most.
    fn point(&self) -> Option<[f64; 2]> {
        let rubs = |r: &&Ranked| 2.0 * r.strength > RUBS * self.total && r.inside;
        self.body_point.as_ref().or(self.rubbing.first().filter(rubs)).map(|p| p.at)
    }

    /// The region, if what is missing is tied to it: it explains most, and more than anything else that has a place.
    fn region(&self) -> Option<Vec<[f64; 2]>> {
        let best = self.regions.first()?;
        let rival = self.rubbing.first().map_or(0.0, |r| 2.0 * r.strength);
        let place = best.chi_square > 0.5 * self.total && best.chi_square > rival && best.share < 0.6;
        place.then(|| best.polygon.clone())
    }
}

/// A fit again, from where it ended, with the missing wrench free to wander: parameters that do not bend to what the
/// model lacks, to linearise about. As it was where it cannot be fitted so.
fn unbent(motion: &MotionLikelihood, wander: Channels, fit: &Fit) -> Fit {
    let options = FitOptions { starts: 0, distant_starts: false, ..FitOptions::default() };
    let wandering = motion.with_channels(wander);
    trundle_infer::fit(&wandering, &freed(fit), std::slice::from_ref(&fit.values), &options, &Quiet)
        .unwrap_or_else(|_| fit.clone())
}

/// A fit's model with what was estimated free again.
fn freed(fit: &Fit) -> Model {
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

/// Scan what a fitted model leaves; nothing where only wrenches are compared.
///
/// # Errors
/// When the fit's values do not suit its model.
pub(crate) fn located(
    comparison: &Comparison,
    fit: &Fit,
    left: Option<Remainder>,
    episodes: &[Prepared],
) -> Result<Located, InferError> {
    match (comparison.with_channels(fit.channels), left) {
        (Comparison::Motion(motion), Some(left)) => Located::new(&motion, fit, left, episodes),
        _ => Ok(Located::default()),
    }
}

impl Located {
    /// What a model misses, for the answer.
    pub fn mismatch(&self, channels: Shares) -> Mismatch {
        Mismatch {
            channels,
            body_point: self.point(),
            world_region: self.region(),
            windows: self.windows.clone(),
            regime: self.regime.clone(),
        }
    }
}
