//! Screen of candidates: Rao's score test, which needs no fit.
//!
//! Let `r` be the whitened innovations of a fit, `N` their derivatives by its own parameters, and `C` those
//! by a candidate's amplitudes at neutral. The best small step gains `s' H⁻¹ s / 2`, with `s = C̃' r` and `H
//! = C̃' C̃`. Here `C̃` is the part of `C` that is orthogonal to `N`, so that the fit's own parameters are
//! profiled out. The Newton step is the starting point of the candidate's fit.

use crate::linear_model::LinearModel;
use crate::linearisation::{Linearisation, Start};
use crate::proposals::{Hints, nearby, proposals};
use rayon::prelude::*;
use trundle_infer::{Fit, InferError, Watch};
use trundle_model::{Effect, Kind, MAX_INNER_STATES, Proposal};
use trundle_record::Prepared;

/// Promised gain below which a kind of effect is not fitted, nats: the least price of a prior.
pub(crate) const MIN_SCREEN_GAIN_NATS: f64 = 5.0;

/// Candidates without states whose derivatives are computed together.
const MAX_BATCH: usize = 8;

/// Options of the screen.
#[derive(Clone, Copy)]
pub(crate) struct ScreenOptions<'a> {
    /// Parts of the floor that seem to add friction: convex polygons, world, m.
    pub regions: &'a [Vec<[f64; 2]>],
    /// Starting points that are kept for each kind.
    pub starts: usize,
    /// Number of kinds of interest. The shapes of kinds far behind are not searched further.
    pub most: usize,
    pub seed: u64,
}

/// Inputs of the screen.
#[derive(Clone, Copy)]
pub(crate) struct Screen<'a> {
    pub view: &'a dyn Linearisation,
    pub episodes: &'a [Prepared],
    pub hints: &'a Hints<'a>,
    pub options: &'a ScreenOptions<'a>,
}

impl Screen<'_> {
    /// Starting points of every kind in `kinds` that may be added to a fit. The best of each kind comes
    /// first, and the kinds are sorted by their best gain.
    pub fn of(&self, fit: &Fit, kinds: &[Kind], watch: &dyn Watch) -> Result<Vec<Vec<Start>>, InferError> {
        let ScreenOptions { starts: kept, most, seed, .. } = *self.options;
        let linear = LinearModel::new(self.view, fit)?;
        let free_states = MAX_INNER_STATES.saturating_sub(fit.model.inner().len());
        let promised = |shapes: &[Effect]| {
            let Some(first) = shapes.first() else { return Ok(vec![]) };
            // Few laws with states fit into a model at once.
            let states = first.kind.spec().inner_states.len();
            let together = free_states.checked_div(states).unwrap_or(MAX_BATCH).max(1);
            let groups: Vec<&[Effect]> = shapes.chunks(together).collect();
            let all = groups.par_iter().map(|group| {
                if watch.cancelled() {
                    return Err(InferError::Interrupted);
                }
                linear.starts(self.view, fit, group)
            });
            let all = all.collect::<Result<Vec<_>, InferError>>()?;
            Ok::<_, InferError>(ranked(all.into_iter().flatten().collect()))
        };
        let proposed = |kind: &Kind| {
            let shapes = proposals(&fit.model, *kind, self.episodes, self.hints, seed);
            Ok((promised(&shapes)?, shapes.len()))
        };
        let mut found: Vec<(Vec<Start>, usize)> =
            kinds.par_iter().map(proposed).collect::<Result<_, InferError>>()?;
        for (round, (radius, extra)) in NEIGHBOUR_SEARCHES.into_iter().enumerate() {
            found.sort_by(|a, b| gain(&b.0).total_cmp(&gain(&a.0)));
            let search_near = |(starts, shapes): &mut (Vec<Start>, usize)| {
                if *shapes < 2 || !has_neighbours(starts) || round > 0 && gain(starts) < MIN_SCREEN_GAIN_NATS
                {
                    return Ok(());
                }
                let parents: Vec<Effect> =
                    starts.iter().take(PARENTS_PER_KIND).map(|s| s.effect.clone()).collect();
                starts.extend(promised(&nearby(&fit.model, &parents, radius, seed))?);
                *starts = ranked(std::mem::take(starts));
                Ok(())
            };
            found.par_iter_mut().take(most + extra).map(search_near).collect::<Result<(), InferError>>()?;
        }
        let mut found: Vec<Vec<Start>> = found.into_iter().map(|(starts, _)| starts).collect();
        found.retain(|starts| !starts.is_empty());
        found.sort_by(|a, b| gain(b).total_cmp(&gain(a)));
        for starts in found.iter_mut().take(POLISHED_KINDS).filter(|starts| has_edges(starts[0].effect.kind))
        {
            polish(starts, |round, parents, radius| {
                promised(&nearby(&fit.model, parents, radius, seed.wrapping_add(round)))
            })?;
        }
        found.iter_mut().for_each(|starts| starts.truncate(kept));
        found.sort_by(|a, b| gain(b).total_cmp(&gain(a)));
        Ok(found)
    }
}

/// Best gain of a kind.
fn gain(starts: &[Start]) -> f64 {
    starts.first().map_or(0.0, |start| start.gain)
}

/// Whether to search shapes between the proposed ones. Events and contacts are proposed densely enough.
fn has_neighbours(starts: &[Start]) -> bool {
    starts.first().is_some_and(|start| {
        !matches!(start.effect.kind.proposal(), Proposal::ContactCandidate | Proposal::EventTime)
    })
}

/// Number of leading kinds whose shapes are polished.
const POLISHED_KINDS: usize = 2;
/// Most rounds of polishing, and the radius at which it stops.
const MAX_POLISHING_ROUNDS: u64 = 24;
const MIN_NEIGHBOUR_RADIUS: f64 = 0.01;

/// Whether an effect has edges that a gradient-based fit does not cross.
fn has_edges(kind: Kind) -> bool {
    kind.proposal() == Proposal::Region
}

/// Search better shapes around the best ones, within a radius that shrinks when the gain no longer grows.
fn polish(
    starts: &mut Vec<Start>,
    neighbours: impl Fn(u64, &[Effect], f64) -> Result<Vec<Start>, InferError>,
) -> Result<(), InferError> {
    let mut radius = NEIGHBOUR_SEARCHES[0].0;
    for round in 0..MAX_POLISHING_ROUNDS {
        let before = starts[0].gain;
        let parents: Vec<Effect> = starts.iter().take(PARENTS_PER_KIND).map(|s| s.effect.clone()).collect();
        starts.extend(neighbours(round, &parents, radius)?);
        *starts = ranked(std::mem::take(starts));
        starts.truncate(PARENTS_PER_KIND);
        if starts[0].gain < before * (1.0 + MIN_RELATIVE_GROWTH) {
            radius *= 0.6;
        }
        if radius < MIN_NEIGHBOUR_RADIUS {
            break;
        }
    }
    Ok(())
}

/// Relative growth of the gain below which the radius shrinks.
const MIN_RELATIVE_GROWTH: f64 = 1e-3;

/// Starting points with a positive gain, the best first.
fn ranked(mut starts: Vec<Start>) -> Vec<Start> {
    starts.retain(|s| s.gain > 0.0);
    starts.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    starts
}

/// Successive searches around the best shapes: the radius, and the number of kinds beyond the wanted ones.
const NEIGHBOUR_SEARCHES: [(f64, usize); 2] = [(0.4, 5), (0.2, 1)];
const PARENTS_PER_KIND: usize = 4;

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::ScreenOptions;
    use crate::engine::Engine;
    use crate::engine::plant_engine::PlantEngine;
    use trundle_fixtures::{World, effect, locked};
    use trundle_infer::Quiet;
    use trundle_model::{Effect, Kind, Model};

    /// Gain that the score test promises for each kind, the best first.
    fn promised(truth: Model) -> Vec<(Kind, f64)> {
        let data = World::of(truth).recording(2);
        let engine = PlantEngine::new(&data, None).unwrap();
        let base = engine.base(0, &Quiet).unwrap();
        let kinds =
            [Kind::FloorSlope, Kind::ForceBias, Kind::CoulombFriction, Kind::Latency, Kind::MassChange];
        let options = ScreenOptions { regions: &[], starts: 1, most: kinds.len(), seed: 0 };
        let found = engine.starts(&base, &kinds, &options, &Quiet).unwrap().unwrap();
        found.iter().map(|starts| (starts[0].effect.kind, starts[0].gain)).collect()
    }

    #[test]
    fn the_missing_effect_promises_most() {
        let hidden: [Effect; 3] = [
            effect(Kind::FloorSlope, &[("accel_x", 0.05), ("accel_y", -0.02)]),
            effect(Kind::CoulombFriction, &[("x", 0.45), ("y", 0.31), ("force", 8.0)]),
            effect(Kind::MassChange, &[("episode", 1.0), ("time", 2.0), ("mass", 8.0)]),
        ];
        for truth in hidden {
            let kind = truth.kind;
            let found = promised(locked().with(truth));
            assert_eq!(found[0].0, kind, "{found:?}");
            assert!(found[0].1 > 100.0, "{found:?}");
        }
    }

    #[test]
    fn a_complete_model_promises_no_gain() {
        let found = promised(locked());
        assert!(found.iter().all(|(_, gain)| *gain < 15.0), "{found:?}");
    }
}
