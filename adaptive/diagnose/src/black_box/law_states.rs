//! Internal states of laws, such as the angle of a caster, along a measured motion.
//!
//! They depend on the motion only, so that just their initial values are unknown.

use super::path::Path;
use nalgebra::DMatrix;
use trundle_infer::StateVector;
use trundle_model::{Clock, InnerState, MAX_INNER_STATES, Plant, State};
use trundle_record::{Motion, Prepared};

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
pub(super) fn state_specs(plant: &Plant<f64>) -> Vec<InnerState> {
    plant.laws.iter().flat_map(|law| law.spec().inner_states).copied().collect()
}

/// First possible start of each internal state.
pub(super) fn first_starts(specs: &[InnerState]) -> [f64; MAX_INNER_STATES] {
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
    pub precision: DMatrix<f64>,
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
