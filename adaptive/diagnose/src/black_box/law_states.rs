//! Internal states of laws, such as the angle of a caster, along a measured motion.
//!
//! They depend on the motion only, so that just their initial values are unknown. If a state of a law has several
//! possible starts, each episode uses the start that fits it best. The first second after contact ranks the
//! starts; Gauss–Newton steps within their prior refine the best few. Unknown initial states are integrated out
//! by the Laplace approximation.

use super::likelihood::PathLikelihood;
use super::path::Path;
use super::simulator::BlackBox;
use nalgebra::{DMatrix, DVector};
use trundle_infer::{Channels, InferError, SETTLING_TIME_S, StateVector, Watch};
use trundle_model::{Clock, InnerState, MAX_INNER_STATES, Plant, State};
use trundle_record::{Motion, Noise, Prepared};

/// Maximum number of Gauss–Newton steps, and the gain of a step below which they have converged, nats.
const MAX_GAUSS_NEWTON_STEPS: usize = 3;
const MIN_GAIN_NATS: f64 = 1e-2;
/// Values tried around each possible start, in its standard deviations, and the number of starts that are
/// refined.
const START_OFFSETS_SD: [f64; 3] = [-0.5, 0.0, 0.5];
const MAX_REFINED_STARTS: usize = 3;
/// Step of a finite difference with respect to an initial state, in its standard deviations.
const RELATIVE_STEP: f64 = 1e-3;
/// Maximum step in which internal states follow a motion, s; the same as that of a simulation.
const MAX_STEP_S: f64 = 0.008;

/// A state at which laws are evaluated, and its weight within an interval.
#[derive(Clone, Copy, Debug)]
pub(crate) struct QuadratureNode {
    pub state: State<f64>,
    pub weight: f64,
}

/// Moves internal states along a straight line between two states, in parts of given clock and duration. Returns
/// the midpoints of the parts and the internal states at the end.
fn advance(
    plant: &Plant<f64>,
    [from, to]: [&StateVector; 2],
    mut inner: [f64; MAX_INNER_STATES],
    parts: impl Iterator<Item = (Clock, f64)>,
    span: f64,
) -> (Vec<QuadratureNode>, [f64; MAX_INNER_STATES]) {
    let (mut t, mut nodes) = (0.0, vec![]);
    for (clock, dt) in parts {
        let share = (t + dt / 2.0) / span;
        let at = |k: usize| from[k] + share * (to[k] - from[k]);
        let state = State::moving([at(0), at(1), at(2)], [at(3), at(4), at(5)]).with_inner(inner);
        let middle = plant.advanced_inner(&state, clock, dt / 2.0);
        nodes.push(QuadratureNode { state: state.with_inner(middle), weight: dt / span });
        inner = plant.advanced_inner(&state, clock, dt);
        t += dt;
    }
    (nodes, inner)
}

/// Nodes at which laws with internal states are evaluated in the first `count` intervals of a path; empty without
/// such laws.
pub(super) fn quadrature_nodes(
    plant: &Plant<f64>,
    path: &Path,
    mut inner: [f64; MAX_INNER_STATES],
    count: usize,
) -> Vec<Vec<QuadratureNode>> {
    if plant.inner() == 0 {
        return vec![];
    }
    let mut of_interval = |interval: &super::path::Interval| {
        let parts = interval.steps.iter().map(|step| (step.clock, step.dt));
        let (nodes, end) = advance(plant, [&interval.from, &interval.to], inner, parts, interval.span);
        inner = end;
        nodes
    };
    path.intervals.iter().take(count).map(&mut of_interval).collect()
}

/// Internal states at each of some motions of an episode, which start at `inner`.
pub(super) fn states_along(
    plant: &Plant<f64>,
    episode: &Prepared,
    motions: &[Motion],
    mut inner: [f64; MAX_INNER_STATES],
) -> Vec<[f64; MAX_INNER_STATES]> {
    let vector = |m: &Motion| [m.pose[0], m.pose[1], m.pose[2], m.twist[0], m.twist[1], m.twist[2]];
    let mut found = vec![inner];
    for pair in motions.windows(2) {
        let span = pair[1].t - pair[0].t;
        let count = (span / MAX_STEP_S).ceil().max(1.0);
        let dt = span / count;
        let part = |k: usize| {
            let t = pair[0].t + (k as f64 + 0.5) * dt;
            let since_contact = Clock::since_contact(t - episode.contact);
            (Clock { t, dt, episode: episode.ordinal as f64, ..since_contact }, dt)
        };
        let parts = (0..count as usize).map(part);
        if plant.inner() > 0 && span > 0.0 {
            inner = advance(plant, [&vector(&pair[0]), &vector(&pair[1])], inner, parts, span).1;
        }
        found.push(inner);
    }
    found
}

/// Specifications of the internal states of a plant's laws.
fn state_specs(plant: &Plant<f64>) -> Vec<InnerState> {
    plant.laws.iter().flat_map(|law| law.spec().inner_states).copied().collect()
}

/// First possible start of each internal state.
fn first_starts(specs: &[InnerState]) -> [f64; MAX_INNER_STATES] {
    let mut inner = [0.0; MAX_INNER_STATES];
    for (value, spec) in inner.iter_mut().zip(specs) {
        *value = spec.starts.first().copied().unwrap_or(0.0);
    }
    inner
}

/// Default initial states of a plant's laws.
pub(super) fn default_states(plant: &Plant<f64>) -> [f64; MAX_INNER_STATES] {
    first_starts(&state_specs(plant))
}

/// Initial states of the laws in an episode.
#[derive(Clone, Debug, Default)]
pub(super) struct InitialState {
    pub inner: [f64; MAX_INNER_STATES],
    /// Derivatives of the innovations with respect to each unknown initial state.
    pub slopes: DMatrix<f64>,
    /// Posterior precision of the unknown initial states.
    precision: DMatrix<f64>,
    /// Negative log prior and Laplace term of the unknown initial states, nats.
    pub laplace_cost: f64,
}

impl InitialState {
    /// Part of the curvature by some columns that the unknown initial states absorb; it is to be subtracted.
    pub fn absorbed_curvature(&self, columns: &DMatrix<f64>) -> Option<DMatrix<f64>> {
        if self.slopes.ncols() == 0 {
            return None;
        }
        let shared = self.slopes.tr_mul(columns);
        Some(shared.tr_mul(&self.precision.clone().cholesky()?.solve(&shared)))
    }
}

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
