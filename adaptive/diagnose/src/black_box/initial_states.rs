//! Estimation of the initial states of laws, such as the angle of a caster.
//!
//! If a state of a law has several possible starts, each episode uses the start that fits it best. The first
//! second after contact ranks the starts; Gauss–Newton steps within their prior refine the best few. Unknown
//! initial states are integrated out by the Laplace approximation.

use super::law_states::{InitialState, first_starts, state_specs};
use super::likelihood::PathLikelihood;
use super::path::Path;
use super::simulator::BlackBox;
use nalgebra::{DMatrix, DVector};
use trundle_infer::{Channels, InferError, SETTLING_TIME_S, Watch};
use trundle_model::{InnerState, MAX_INNER_STATES, Plant};
use trundle_record::{Noise, Prepared};

/// Maximum number of Gauss–Newton steps, and the gain of a step below which they have converged, nats.
const MAX_GAUSS_NEWTON_STEPS: usize = 3;
const MIN_GAIN_NATS: f64 = 1e-2;
/// Values tried around each possible start, in its standard deviations, and the number of starts that are
/// refined.
const START_OFFSETS_SD: [f64; 3] = [-0.5, 0.0, 0.5];
const MAX_REFINED_STARTS: usize = 3;
/// Step of a finite difference with respect to an initial state, in its standard deviations.
const RELATIVE_STEP: f64 = 1e-3;

/// Search for the initial states of an episode.
struct InitialStateSearch<'a> {
    specs: Vec<InnerState>,
    /// Indices of the states with several possible starts.
    unknown: Vec<usize>,
    /// Number of intervals that rank the starts.
    early_count: usize,
    innovations: &'a dyn Fn(&[f64; MAX_INNER_STATES], usize) -> Vec<f64>,
}

/// Initial states that are tried near a possible start, with their innovations.
#[derive(Clone)]
struct Trial {
    origin: [f64; MAX_INNER_STATES],
    inner: [f64; MAX_INNER_STATES],
    innovations: DVector<f64>,
    cost: f64,
}

impl InitialStateSearch<'_> {
    fn trial(&self, origin: [f64; MAX_INNER_STATES], inner: [f64; MAX_INNER_STATES], count: usize) -> Trial {
        let innovations = DVector::from_vec((self.innovations)(&inner, count));
        let moved = self.deviation(&origin, &inner);
        let cost = 0.5 * (innovations.norm_squared() + moved.dot(&self.prior().component_mul(&moved)));
        Trial { origin, inner, innovations, cost: if cost.is_finite() { cost } else { f64::INFINITY } }
    }

    fn deviation(&self, origin: &[f64; MAX_INNER_STATES], inner: &[f64; MAX_INNER_STATES]) -> DVector<f64> {
        DVector::from_iterator(self.unknown.len(), self.unknown.iter().map(|&k| inner[k] - origin[k]))
    }

    /// Prior precision of the unknown states.
    fn prior(&self) -> DVector<f64> {
        DVector::from_iterator(self.unknown.len(), self.unknown.iter().map(|&k| self.specs[k].sd.powi(-2)))
    }

    /// The best starts by the first intervals, refined by Gauss–Newton steps.
    fn ranked_starts(&self) -> Vec<Trial> {
        let (mut best, mut start) = (vec![], first_starts(&self.specs));
        for &k in &self.unknown {
            let InnerState { starts, sd, .. } = self.specs[k];
            let with = |value: f64| {
                let mut inner = start;
                inner[k] = value;
                inner
            };
            let between =
                |&start: &f64| START_OFFSETS_SD.map(|offset| (with(start), with(start + offset * sd)));
            let tried = starts.iter().flat_map(between);
            let mut tried: Vec<Trial> =
                tried.map(|(origin, at)| self.trial(origin, at, self.early_count)).collect();
            tried.sort_by(|a, b| a.cost.total_cmp(&b.cost));
            tried.truncate(MAX_REFINED_STARTS);
            best = tried.into_iter().map(|trial| self.refine(trial, self.early_count).0).collect();
            best.sort_by(|a, b| a.cost.total_cmp(&b.cost));
            start = best.first().map_or(start, |trial| trial.inner);
        }
        best
    }

    /// Refines a trial by Gauss–Newton steps over the first `count` intervals. Also returns the slopes at the result.
    fn refine(&self, mut at: Trial, count: usize) -> (Trial, DMatrix<f64>) {
        let prior = self.prior();
        let mut slopes = self.slopes(&at, count);
        for _ in 0..MAX_GAUSS_NEWTON_STEPS {
            let precision = slopes.tr_mul(&slopes) + DMatrix::from_diagonal(&prior);
            let penalty = prior.component_mul(&self.deviation(&at.origin, &at.inner));
            let Some(factor) = precision.cholesky() else { break };
            let step = factor.solve(&(slopes.tr_mul(&at.innovations) + penalty));
            let mut inner = at.inner;
            self.unknown.iter().zip(step.iter()).for_each(|(&k, step)| inner[k] -= step);
            let reached = self.trial(at.origin, inner, count);
            let (gain, better) = (at.cost - reached.cost, reached.cost < at.cost);
            if better {
                at = reached;
                slopes = self.slopes(&at, count);
            }
            if !better || gain < MIN_GAIN_NATS {
                break;
            }
        }
        (at, slopes)
    }

    fn slopes(&self, at: &Trial, count: usize) -> DMatrix<f64> {
        let column = |&k: &usize| {
            let (mut moved, h) = (at.inner, RELATIVE_STEP * self.specs[k].sd);
            moved[k] += h;
            (DVector::from_vec((self.innovations)(&moved, count)) - &at.innovations) / h
        };
        DMatrix::from_columns(&self.unknown.iter().map(column).collect::<Vec<_>>())
    }

    /// The most probable initial states.
    fn most_probable(&self) -> InitialState {
        let trials =
            self.ranked_starts().into_iter().map(|trial| self.trial(trial.origin, trial.inner, usize::MAX));
        let first = first_starts(&self.specs);
        let best = trials.min_by(|a, b| a.cost.total_cmp(&b.cost));
        let best = best.unwrap_or_else(|| self.trial(first, first, usize::MAX));
        let (at, slopes) = self.refine(best, usize::MAX);
        let (prior, moved) = (self.prior(), self.deviation(&at.origin, &at.inner));
        let precision = slopes.tr_mul(&slopes) + DMatrix::from_diagonal(&prior);
        let ratio = precision.determinant() / prior.product();
        let laplace_cost = 0.5 * (moved.dot(&prior.component_mul(&moved)) + ratio.ln());
        InitialState { inner: at.inner, slopes, precision, laplace_cost }
    }
}

impl PathLikelihood {
    /// Initial states of the laws in each episode.
    pub(super) fn initial_states(&self, plant: &Plant<f64>, sim_values: &[f64]) -> Vec<InitialState> {
        let specs = state_specs(plant);
        let unknown: Vec<usize> = (0..specs.len()).filter(|&k| specs[k].starts.len() > 1).collect();
        let known = InitialState { inner: first_starts(&specs), ..InitialState::default() };
        if unknown.is_empty() {
            return vec![known; self.paths.len()];
        }
        let without = self.innovations_without_laws(sim_values);
        let mut remaining = without.as_slice();
        let mut found = Vec::with_capacity(self.paths.len());
        for (e, path) in self.paths.iter().enumerate() {
            let (without_here, others) = remaining.split_at(3 * path.intervals.len());
            remaining = others;
            let innovations = |inner: &[f64; MAX_INNER_STATES], count: usize| {
                let laws = self.law_innovations_in(plant, e, inner, count);
                laws.iter().zip(without_here).map(|(law, without)| law + without).collect()
            };
            let early_count = path.intervals_before(SETTLING_TIME_S);
            found.push(
                InitialStateSearch {
                    specs: specs.clone(),
                    unknown: unknown.clone(),
                    early_count,
                    innovations: &innovations,
                }
                .most_probable(),
            );
        }
        found
    }
}

/// Estimates the initial states of the laws for the simulation of an episode, from the first second after
/// contact.
pub(super) fn estimate_initial_state(
    simulator: &BlackBox<'_>,
    (plant, values): (&Plant<f64>, &[f64]),
    episode: &Prepared,
    (noise, dof): (&Noise, [bool; 3]),
    watch: &dyn Watch,
) -> Result<[f64; MAX_INNER_STATES], InferError> {
    let specs = state_specs(plant);
    let first = first_starts(&specs);
    if specs.iter().all(|spec| spec.starts.len() < 2) {
        return Ok(first);
    }
    let Ok(mut path) = Path::new(episode, noise) else { return Ok(first) };
    path.intervals.truncate(path.intervals_before(SETTLING_TIME_S));
    let likelihood = PathLikelihood::new(simulator, values, &[path], Channels::of(noise), dof, watch)?;
    Ok(likelihood.initial_states(plant, values).first().map_or(first, |start| start.inner))
}
