//! The cheap test: what one small step of every candidate would gain, beside a refit of the simulation under test.
//!
//! With `r` the whitened innovations of a fit, `N` their slopes by its own parameters and `C` those by a candidate's
//! amplitudes at neutral, the gain of the best small step is `s' H⁻¹ s / 2` with `s = C̃' r`, `H = C̃' C̃` and `C̃` what of
//! `C` no change of the fitted parameters does: Rao's score test. It costs no fit. Its step is where the fit of the
//! candidate starts from.

use crate::ground::Ground;
use crate::proposals::{Hints, nearby, proposals};
use crate::search::HOPELESS;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use trundle_infer::{FilteredEpisodes, Fit, InferError, Watch};
use trundle_model::{Effect, INNER, Kind, Model, Proposal};
use trundle_record::Prepared;

/// A fitted model's whitened innovations, and what other values or effects would change in them.
pub(crate) trait View: Sync {
    /// All whitened innovations, one after the other.
    fn residual(&self) -> DVector<f64>;

    /// Their derivatives by everything that the fit estimated, and the slot of each where it is the model's own.
    fn own(&self, fit: &Fit) -> Result<(DMatrix<f64>, Vec<Option<usize>>), InferError>;

    /// Their derivatives by some slots of a model that does the same at `values` as the one that was fitted.
    fn slopes(&self, model: &Model, values: &[f64], free: &[usize]) -> Result<DMatrix<f64>, InferError>;
}

impl View for FilteredEpisodes<'_> {
    fn residual(&self) -> DVector<f64> {
        self.residual()
    }

    fn own(&self, fit: &Fit) -> Result<(DMatrix<f64>, Vec<Option<usize>>), InferError> {
        let slots = fit.model.slots();
        let free: Vec<usize> =
            fit.estimates.iter().filter_map(|e| slots.iter().position(|s| s.name == e.name)).collect();
        let slopes = self.slopes(&fit.model, &fit.values, &free)?;
        Ok((stacked(&slopes), free.into_iter().map(Some).collect()))
    }

    fn slopes(&self, model: &Model, values: &[f64], free: &[usize]) -> Result<DMatrix<f64>, InferError> {
        Ok(stacked(&self.slopes(model, values, free)?))
    }
}

/// A candidate with the values to start its fit from.
#[derive(Clone, Debug)]
pub(crate) struct Start {
    /// Every value of it.
    pub effect: Effect,
    /// Values of the fit's own slots.
    pub base: Vec<f64>,
    /// Gain in log likelihood that a linear step promises.
    pub gain: f64,
    /// The effect before that step.
    pub neutral: Effect,
}

/// Candidates whose slopes are taken together, where they have no states of their own.
const TOGETHER: usize = 8;

/// What is wanted of the cheap test.
#[derive(Clone, Copy)]
pub(crate) struct Wanted<'a> {
    /// Parts of the floor that seem to drag.
    pub regions: &'a [Vec<[f64; 2]>],
    /// Starts that are kept of a kind.
    pub starts: usize,
    /// Kinds that are wanted: the shapes of those far behind are not sought on.
    pub most: usize,
    pub seed: u64,
}

/// What the cheap test is made with.
#[derive(Clone, Copy)]
pub(crate) struct Screen<'a> {
    pub view: &'a dyn View,
    pub episodes: &'a [Prepared],
    pub hints: &'a Hints<'a>,
    pub wanted: &'a Wanted<'a>,
}

impl Screen<'_> {
    /// Starts of every kind of `kinds` on top of a fit, the best of each kind first, sorted by what the best of the kind
    /// promises.
    pub fn of(&self, fit: &Fit, kinds: &[Kind], watch: &dyn Watch) -> Result<Vec<Vec<Start>>, InferError> {
        let Wanted { starts: kept, most, seed, .. } = *self.wanted;
        let ground = Ground::new(self.view, fit)?;
        let spare = INNER.saturating_sub(fit.model.inner().len());
        let promised = |shapes: &[Effect]| {
            let Some(first) = shapes.first() else { return Ok(vec![]) };
            // States of the laws' own are few.
            let own = first.kind.spec().inner.len();
            let together = spare.checked_div(own).unwrap_or(TOGETHER).max(1);
            let groups: Vec<&[Effect]> = shapes.chunks(together).collect();
            let all = groups.par_iter().map(|group| {
                if watch.cancelled() {
                    return Err(InferError::Interrupted);
                }
                ground.starts(self.view, fit, group)
            });
            let all = all.collect::<Result<Vec<_>, InferError>>()?;
            Ok::<_, InferError>(best(all.into_iter().flatten().collect()))
        };
        let proposed = |kind: &Kind| {
            let shapes = proposals(&fit.model, *kind, self.episodes, self.hints, seed);
            Ok((promised(&shapes)?, shapes.len()))
        };
        let mut found: Vec<(Vec<Start>, usize)> =
            kinds.par_iter().map(proposed).collect::<Result<_, InferError>>()?;
        for (round, (share, behind)) in NEARER.into_iter().enumerate() {
            found.sort_by(|a, b| gain(&b.0).total_cmp(&gain(&a.0)));
            let near = |(starts, shapes): &mut (Vec<Start>, usize)| {
                if *shapes < 2 || !has_neighbours(starts) || round > 0 && gain(starts) < HOPELESS {
                    return Ok(());
                }
                let parents: Vec<Effect> = starts.iter().take(PARENTS).map(|s| s.effect.clone()).collect();
                starts.extend(promised(&nearby(&fit.model, &parents, share, seed))?);
                *starts = best(std::mem::take(starts));
                Ok(())
            };
            found.par_iter_mut().take(most + behind).map(near).collect::<Result<(), InferError>>()?;
        }
        let mut found: Vec<Vec<Start>> = found.into_iter().map(|(starts, _)| starts).collect();
        found.retain(|starts| !starts.is_empty());
        found.sort_by(|a, b| gain(b).total_cmp(&gain(a)));
        for starts in found.iter_mut().take(POLISHED).filter(|starts| has_edges(starts[0].effect.kind)) {
            polish(starts, |round, parents, share| {
                promised(&nearby(&fit.model, parents, share, seed.wrapping_add(round)))
            })?;
        }
        found.iter_mut().for_each(|starts| starts.truncate(kept));
        found.sort_by(|a, b| gain(b).total_cmp(&gain(a)));
        Ok(found)
    }
}

/// What the best of a kind promises.
fn gain(starts: &[Start]) -> f64 {
    starts.first().map_or(0.0, |start| start.gain)
}

/// Whether shapes are sought between those that were proposed: events and contacts are proposed densely.
fn has_neighbours(starts: &[Start]) -> bool {
    starts
        .first()
        .is_some_and(|start| !matches!(start.effect.kind.proposal(), Proposal::Touched | Proposal::Moment))
}

/// Kinds that promise most whose shapes are sought on.
const POLISHED: usize = 2;
/// Rounds of that, and the share at which it ends.
const ROUNDS: u64 = 24;
const FINEST: f64 = 0.01;

/// Whether an effect has edges, across which a fit finds no way.
fn has_edges(kind: Kind) -> bool {
    kind.proposal() == Proposal::Region
}

/// Better shapes around the best few, nearer where none is found.
fn polish(
    starts: &mut Vec<Start>,
    around: impl Fn(u64, &[Effect], f64) -> Result<Vec<Start>, InferError>,
) -> Result<(), InferError> {
    let mut share = NEARER[0].0;
    for round in 0..ROUNDS {
        let before = starts[0].gain;
        let parents: Vec<Effect> = starts.iter().take(PARENTS).map(|s| s.effect.clone()).collect();
        starts.extend(around(round, &parents, share)?);
        *starts = best(std::mem::take(starts));
        starts.truncate(PARENTS);
        if starts[0].gain < before * (1.0 + LITTLE) {
            share *= 0.6;
        }
        if share < FINEST {
            break;
        }
    }
    Ok(())
}

/// Growth of a gain that is worth another look as far around.
const LITTLE: f64 = 1e-3;

/// Those that gain, the best first.
fn best(mut starts: Vec<Start>) -> Vec<Start> {
    starts.retain(|s| s.gain > 0.0);
    starts.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    starts
}

/// Ever nearer shapes around the best few, and of how many kinds beyond those that are wanted.
const NEARER: [(f64, usize); 2] = [(0.4, 5), (0.2, 1)];
const PARENTS: usize = 4;

/// Matrices below one another.
fn stacked(parts: &[DMatrix<f64>]) -> DMatrix<f64> {
    let columns = parts.first().map_or(0, DMatrix::ncols);
    let mut all = DMatrix::zeros(parts.iter().map(DMatrix::nrows).sum(), columns);
    let mut row = 0;
    for part in parts {
        all.rows_mut(row, part.nrows()).copy_from(part);
        row += part.nrows();
    }
    all
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::Wanted;
    use crate::common::{World, effect, locked};
    use crate::engine::{Engine, Own};
    use trundle_infer::Quiet;
    use trundle_model::{Effect, Kind, Model};

    /// What the score test promises of each kind, the best first.
    fn promised(truth: Model) -> Vec<(Kind, f64)> {
        let data = World::of(truth).recording(2);
        let engine = Own::new(&data, None).unwrap();
        let base = engine.base(0, &Quiet).unwrap();
        let kinds =
            [Kind::FloorSlope, Kind::ForceBias, Kind::CoulombFriction, Kind::Latency, Kind::MassChange];
        let wanted = Wanted { regions: &[], starts: 1, most: kinds.len(), seed: 0 };
        let found = engine.starts(&base, &kinds, &wanted, &Quiet).unwrap().unwrap();
        found.iter().map(|starts| (starts[0].effect.kind, starts[0].gain)).collect()
    }

    #[test]
    fn what_is_missing_promises_most() {
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
    fn where_nothing_is_missing_nothing_is_promised() {
        let found = promised(locked());
        assert!(found.iter().all(|(_, gain)| *gain < 15.0), "{found:?}");
    }
}
