//! Best-subset selection of candidates in the linear model of the score test.
//!
//! The gain of a set is `s' H⁻¹ s / 2`, with the score `s` and the information matrix `H` of all its
//! amplitudes. Shared explanations therefore count once, and joint explanations count. Every set is compared,
//! at the cost of one small linear solve. A set pays the penalty of Schwarz's criterion, `ln n / 2` nats for
//! each amplitude.

use crate::candidates::name;
use crate::linear_model::{LinearModel, amplitude_derivatives, stepped};
use crate::linearisation::{Linearisation, Start};
use crate::screen::MIN_SCREEN_GAIN_NATS;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use trundle_infer::{Fit, InferError};
use trundle_model::{Effect, MAX_INNER_STATES, Slot};

/// Effects to add together, with the starting values of their fit.
#[derive(Clone, Debug)]
pub(crate) struct EffectSet {
    pub effects: Vec<Effect>,
    /// Values of the fit's own slots.
    pub base: Vec<f64>,
}

/// Most sets that are kept of one size.
const MAX_SETS_PER_SIZE: usize = 3;

/// The best sets of two to `most` candidates to add to a fit. The search stops at the first size whose best
/// set gains less than [`MIN_SCREEN_GAIN_NATS`] over the next smaller one.
pub(crate) fn best_sets(
    view: &dyn Linearisation,
    fit: &Fit,
    starts: &[Vec<Start>],
    most: usize,
) -> Result<Vec<EffectSet>, InferError> {
    let linear = SubsetModel::new(view, fit, starts)?;
    let count = linear.candidates.len();
    let mut found = vec![];
    let mut of_size: Vec<Vec<usize>> = (0..count).map(|k| vec![k]).collect();
    let mut penalised_gain = linear.rank(&of_size).first().map_or(0.0, |best| best.penalised_gain);
    for _ in 1..most {
        let larger = |set: &Vec<usize>| {
            let next = set.last().map_or(0, |k| k + 1);
            (next..count).map(|k| [set.as_slice(), &[k]].concat()).collect::<Vec<_>>()
        };
        of_size = of_size.iter().flat_map(larger).filter(|set| linear.is_valid(set)).collect();
        let ranked = linear.rank(&of_size);
        let Some(best) =
            ranked.first().filter(|best| best.penalised_gain > penalised_gain + MIN_SCREEN_GAIN_NATS)
        else {
            break;
        };
        penalised_gain = best.penalised_gain;
        found.extend(ranked.iter().filter_map(|one| linear.start(one)).take(MAX_SETS_PER_SIZE));
    }
    Ok(found)
}

/// A candidate in its best shape, with the derivatives by its amplitudes.
struct Candidate {
    effect: Effect,
    amplitudes: Vec<usize>,
    /// Values and slots of the fit's model with the candidate.
    values: Vec<f64>,
    slots: Vec<Slot>,
    columns: DMatrix<f64>,
    /// Its range of columns.
    at: std::ops::Range<usize>,
}

/// All candidates in one linear model.
struct SubsetModel<'a> {
    fit: &'a Fit,
    linear: LinearModel,
    candidates: Vec<Candidate>,
    score: DVector<f64>,
    information: DMatrix<f64>,
    /// Number of law states that may be added.
    free_states: usize,
}

/// A set with its Newton step.
struct RankedSet<'a> {
    set: &'a [usize],
    step: DVector<f64>,
    /// Gain minus the penalty for its amplitudes, nats.
    penalised_gain: f64,
}

impl<'a> SubsetModel<'a> {
    fn new(view: &dyn Linearisation, fit: &'a Fit, starts: &[Vec<Start>]) -> Result<Self, InferError> {
        let linear = LinearModel::new(view, fit)?;
        let one = |start: &Start| -> Result<Candidate, InferError> {
            let effect = start.neutral.clone();
            let mut all = amplitude_derivatives(view, fit, std::slice::from_ref(&effect))?;
            let (amplitudes, columns) = all.columns.pop().unwrap_or_else(|| (vec![], DMatrix::zeros(0, 0)));
            let slots = all.model.slots();
            Ok(Candidate { effect, amplitudes, values: all.values, slots, columns, at: 0..0 })
        };
        let best: Vec<&Start> = starts.iter().filter_map(|of_kind| of_kind.first()).collect();
        let mut candidates = best.into_par_iter().map(one).collect::<Result<Vec<_>, InferError>>()?;
        let mut width = 0;
        for one in &mut candidates {
            one.at = width..width + one.columns.ncols();
            width = one.at.end;
        }
        let mut all = DMatrix::zeros(linear.residual.len(), width);
        for one in &candidates {
            all.columns_mut(one.at.start, one.at.len()).copy_from(&one.columns);
        }
        let (score, information) = linear.normal_equations(&all);
        let free_states = MAX_INNER_STATES.saturating_sub(fit.model.inner().len());
        Ok(Self { fit, linear, candidates, score, information, free_states })
    }

    /// Whether a set contains each effect once and fits into the available states.
    fn is_valid(&self, set: &[usize]) -> bool {
        let effects = || set.iter().map(|&k| &self.candidates[k].effect);
        let states: usize = effects().map(|e| e.kind.spec().inner_states.len()).sum();
        let last = effects().next_back().map(name);
        states <= self.free_states && effects().rev().skip(1).all(|e| Some(name(e)) != last)
    }

    /// Sets with their steps, the largest penalised gain first.
    fn rank<'b>(&self, sets: &'b [Vec<usize>]) -> Vec<RankedSet<'b>> {
        let mut ranked: Vec<RankedSet<'b>> = sets.par_iter().filter_map(|set| self.step(set)).collect();
        ranked.sort_by(|a, b| b.penalised_gain.total_cmp(&a.penalised_gain));
        ranked
    }

    fn step<'b>(&self, set: &'b [usize]) -> Option<RankedSet<'b>> {
        let at: Vec<usize> = set.iter().flat_map(|&k| self.candidates[k].at.clone()).collect();
        let score = DVector::from_fn(at.len(), |i, _| self.score[at[i]]);
        let information = DMatrix::from_fn(at.len(), at.len(), |i, j| self.information[(at[i], at[j])]);
        let step = information.cholesky()?.solve(&score);
        let price = 0.5 * (self.linear.residual.len() as f64).ln();
        let penalised_gain = 0.5 * step.dot(&score) - price * at.len() as f64;
        penalised_gain.is_finite().then_some(RankedSet { set, step, penalised_gain })
    }

    /// Starting values for the fit of a set; `None` if its step leaves the bounds.
    fn start(&self, ranked: &RankedSet<'_>) -> Option<EffectSet> {
        let members: Vec<&Candidate> = ranked.set.iter().map(|&k| &self.candidates[k]).collect();
        let columns: Vec<_> = members.iter().flat_map(|one| one.columns.column_iter()).collect();
        let base = self.linear.shifted(
            self.fit,
            &self.fit.model.slots(),
            &DMatrix::from_columns(&columns),
            &ranked.step,
        );
        let mut steps = ranked.step.as_slice();
        let mut effects = Vec::with_capacity(members.len());
        for one in members {
            let (own, rest) = steps.split_at(one.at.len());
            steps = rest;
            let first = self.fit.values.len();
            effects.push(stepped(&one.effect, first, &one.amplitudes, own, &one.values, &one.slots)?);
        }
        Some(EffectSet { effects, base })
    }
}
