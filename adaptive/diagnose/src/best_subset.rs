//! Which candidates together promise most: best-subset selection in the linear model of the score test.
//!
//! The gain of a set is `s' H⁻¹ s / 2` with the score `s` and the information `H` of all its amplitudes together, so that what
//! two candidates both explain counts once, and what they explain only together counts. Every set is compared, which costs
//! a small solve each: no path of single effects has to lead there. A set pays Schwarz's price, `ln n / 2` nats an amplitude.

use crate::candidates::name;
use crate::linear_model::{LinearModel, amplitude_derivatives, stepped};
use crate::screen::{Linearisation, Start};
use crate::search::MIN_SCREEN_GAIN_NATS;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use trundle_infer::{Fit, InferError};
use trundle_model::{Effect, INNER, Slot};

/// Effects to add together, with the values to start their fit from.
#[derive(Clone, Debug)]
pub(crate) struct EffectSet {
    pub effects: Vec<Effect>,
    /// Values of the fit's own slots.
    pub base: Vec<f64>,
}

/// Sets that are kept of a size.
const MAX_SETS_PER_SIZE: usize = 3;

/// The best sets of two to `most` candidates on top of a fit. A size is left out where one more candidate promises no
/// more than a prior costs.
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
        let rank = linear.rank(&of_size);
        let Some(best) =
            rank.first().filter(|best| best.penalised_gain > penalised_gain + MIN_SCREEN_GAIN_NATS)
        else {
            break;
        };
        penalised_gain = best.penalised_gain;
        found.extend(rank.iter().filter_map(|one| linear.start(one)).take(MAX_SETS_PER_SIZE));
    }
    Ok(found)
}

/// A candidate in its best shape, and what its amplitudes change.
struct Candidate {
    effect: Effect,
    amplitudes: Vec<usize>,
    /// Values and slots of the fit's model with the candidate.
    values: Vec<f64>,
    slots: Vec<Slot>,
    columns: DMatrix<f64>,
    /// Which of all columns are its.
    at: std::ops::Range<usize>,
}

/// All candidates in one linear model.
struct SubsetModel<'a> {
    fit: &'a Fit,
    linear: LinearModel,
    candidates: Vec<Candidate>,
    score: DVector<f64>,
    information: DMatrix<f64>,
    /// States of laws' own that may be added.
    free_states: usize,
}

/// A set with its step.
struct RankedSet<'a> {
    set: &'a [usize],
    step: DVector<f64>,
    /// Gain less the price of its amplitudes, nats.
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
        let free_states = INNER.saturating_sub(fit.model.inner().len());
        Ok(Self { fit, linear, candidates, score, information, free_states })
    }

    /// Whether a set is a model: of each effect once, with few enough states.
    fn is_valid(&self, set: &[usize]) -> bool {
        let effects = || set.iter().map(|&k| &self.candidates[k].effect);
        let states: usize = effects().map(|e| e.kind.spec().inner.len()).sum();
        let last = effects().next_back().map(name);
        states <= self.free_states && effects().rev().skip(1).all(|e| Some(name(e)) != last)
    }

    /// Sets with their steps, what is worth most first.
    fn rank<'b>(&self, sets: &'b [Vec<usize>]) -> Vec<RankedSet<'b>> {
        let mut rank: Vec<RankedSet<'b>> = sets.par_iter().filter_map(|set| self.step(set)).collect();
        rank.sort_by(|a, b| b.penalised_gain.total_cmp(&a.penalised_gain));
        rank
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

    /// Where the fit of a set starts; `None` where its step leaves a bound.
    fn start(&self, rank: &RankedSet<'_>) -> Option<EffectSet> {
        let members: Vec<&Candidate> = rank.set.iter().map(|&k| &self.candidates[k]).collect();
        let columns: Vec<_> = members.iter().flat_map(|one| one.columns.column_iter()).collect();
        let base = self.linear.shifted(
            self.fit,
            &self.fit.model.slots(),
            &DMatrix::from_columns(&columns),
            &rank.step,
        );
        let mut steps = rank.step.as_slice();
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
