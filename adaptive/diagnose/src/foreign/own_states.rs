//! The laws' own states, such as a caster's angle, along a motion that was seen.
//!
//! They follow the motion whatever acts, so that along the seen motion only their beginning is open. Where a law's state may
//! start in several ways, each episode's start is the one that fits it best: of those on offer the best few by the first second
//! after contact, then by Gauss–Newton steps within their prior. A start that is not known is integrated out (Laplace).

use super::likelihood::Along;
use super::path::Path;
use super::simulator::Foreign;
use nalgebra::{DMatrix, DVector};
use trundle_infer::{Channels, InferError, SETTLING_TIME_S, StateVector, Watch};
use trundle_model::{Clock, INNER, Inner, Plant, State};
use trundle_record::{Motion, Noise, Prepared};

/// Gauss–Newton steps to a start at most, and the gain below which it is reached, nats.
const STEPS: usize = 3;
const SETTLED: f64 = 1e-2;
/// Places tried around each start on offer, in its standard deviation, and how many are followed.
const BETWEEN: [f64; 3] = [-0.5, 0.0, 0.5];
const KEPT: usize = 3;
/// Step of a finite difference by a start, in its standard deviation.
const RELATIVE: f64 = 1e-3;
/// Longest part of a motion in which laws' states are followed at a time, s: as a simulation's step.
const LONGEST: f64 = 0.008;

/// An instant at which laws are asked, and its share of an interval.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Moment {
    pub state: State<f64>,
    pub share: f64,
}

/// From one state to another on a straight line in parts, each with its clock and duration: the middles of the parts, and the
/// laws' states at the end.
fn passed(
    plant: &Plant<f64>,
    [from, to]: [&StateVector; 2],
    mut inner: [f64; INNER],
    parts: impl Iterator<Item = (Clock, f64)>,
    span: f64,
) -> (Vec<Moment>, [f64; INNER]) {
    let (mut t, mut moments) = (0.0, vec![]);
    for (clock, dt) in parts {
        let share = (t + dt / 2.0) / span;
        let at = |k: usize| from[k] + share * (to[k] - from[k]);
        let state = State::moving([at(0), at(1), at(2)], [at(3), at(4), at(5)]).with_inner(inner);
        let middle = plant.carried_on(&state, clock, dt / 2.0);
        moments.push(Moment { state: state.with_inner(middle), share: dt / span });
        inner = plant.carried_on(&state, clock, dt);
        t += dt;
    }
    (moments, inner)
}

/// When laws with states of their own are asked in the first `count` intervals of a path; empty where there are none.
pub(super) fn moments(
    plant: &Plant<f64>,
    path: &Path,
    mut inner: [f64; INNER],
    count: usize,
) -> Vec<Vec<Moment>> {
    if plant.inner() == 0 {
        return vec![];
    }
    let mut of_interval = |interval: &super::path::Interval| {
        let parts = interval.steps.iter().map(|step| (step.clock, step.dt));
        let (moments, end) = passed(plant, [&interval.from, &interval.to], inner, parts, interval.span);
        inner = end;
        moments
    };
    path.intervals.iter().take(count).map(&mut of_interval).collect()
}

/// The laws' own states at each of some motions of an episode, which begin at `inner`.
pub(super) fn followed(
    plant: &Plant<f64>,
    episode: &Prepared,
    known: &[Motion],
    mut inner: [f64; INNER],
) -> Vec<[f64; INNER]> {
    let vector = |m: &Motion| [m.pose[0], m.pose[1], m.pose[2], m.twist[0], m.twist[1], m.twist[2]];
    let mut found = vec![inner];
    for pair in known.windows(2) {
        let span = pair[1].t - pair[0].t;
        let count = (span / LONGEST).ceil().max(1.0);
        let dt = span / count;
        let part = |k: usize| {
            let t = pair[0].t + (k as f64 + 0.5) * dt;
            let since_contact = Clock::since_contact(t - episode.contact);
            (Clock { t, dt, episode: episode.ordinal as f64, ..since_contact }, dt)
        };
        let parts = (0..count as usize).map(part);
        if plant.inner() > 0 && span > 0.0 {
            inner = passed(plant, [&vector(&pair[0]), &vector(&pair[1])], inner, parts, span).1;
        }
        found.push(inner);
    }
    found
}

/// The states of a plant's laws, each with its index.
fn states(plant: &Plant<f64>) -> Vec<Inner> {
    plant.laws.iter().flat_map(|law| law.spec().inner).copied().collect()
}

/// Where the laws' own states begin where nothing is known.
fn first_on_offer(states: &[Inner]) -> [f64; INNER] {
    let mut inner = [0.0; INNER];
    for (value, state) in inner.iter_mut().zip(states) {
        *value = state.starts.first().copied().unwrap_or(0.0);
    }
    inner
}

/// Where a plant's laws' own states may begin.
pub(super) fn on_offer(plant: &Plant<f64>) -> [f64; INNER] {
    first_on_offer(&states(plant))
}

/// Where the laws' own states begin in an episode.
#[derive(Clone, Debug, Default)]
pub(super) struct Start {
    pub inner: [f64; INNER],
    /// What a change of each state that is not known changes in the innovations.
    pub slopes: DMatrix<f64>,
    /// Precision of those states: by the innovations and their prior.
    precision: DMatrix<f64>,
    /// What it costs that they are not known, nats.
    pub price: f64,
}

impl Start {
    /// What of the products of some columns goes to the states that are not known: to be taken from a curvature.
    pub fn absorbed(&self, columns: &DMatrix<f64>) -> Option<DMatrix<f64>> {
        if self.slopes.ncols() == 0 {
            return None;
        }
        let shared = self.slopes.tr_mul(columns);
        Some(shared.tr_mul(&self.precision.clone().cholesky()?.solve(&shared)))
    }
}

/// How the start of an episode is found: the innovations of its first intervals by the start.
struct Search<'a> {
    states: Vec<Inner>,
    /// Those that may start in several ways.
    open: Vec<usize>,
    /// Intervals by which starts are sorted.
    early: usize,
    of: &'a dyn Fn(&[f64; INNER], usize) -> Vec<f64>,
}

/// A start that is tried, near one on offer, with the innovations that it leaves.
#[derive(Clone)]
struct Trial {
    offered: [f64; INNER],
    inner: [f64; INNER],
    left: DVector<f64>,
    cost: f64,
}

impl Search<'_> {
    fn trial(&self, offered: [f64; INNER], inner: [f64; INNER], count: usize) -> Trial {
        let left = DVector::from_vec((self.of)(&inner, count));
        let moved = self.away(&offered, &inner);
        let cost = 0.5 * (left.norm_squared() + moved.dot(&self.prior().component_mul(&moved)));
        Trial { offered, inner, left, cost: if cost.is_finite() { cost } else { f64::INFINITY } }
    }

    fn away(&self, offered: &[f64; INNER], inner: &[f64; INNER]) -> DVector<f64> {
        DVector::from_iterator(self.open.len(), self.open.iter().map(|&k| inner[k] - offered[k]))
    }

    /// Prior precision of the states that are not known.
    fn prior(&self) -> DVector<f64> {
        DVector::from_iterator(self.open.len(), self.open.iter().map(|&k| self.states[k].sd.powi(-2)))
    }

    /// The best starts by the first intervals: on offer, between those, and by steps from there.
    fn ranked(&self) -> Vec<Trial> {
        let (mut best, mut known) = (vec![], first_on_offer(&self.states));
        for &k in &self.open {
            let Inner { starts, sd, .. } = self.states[k];
            let with = |value: f64| {
                let mut inner = known;
                inner[k] = value;
                inner
            };
            let between = |&start: &f64| BETWEEN.map(|share| (with(start), with(start + share * sd)));
            let tried = starts.iter().flat_map(between);
            let mut tried: Vec<Trial> =
                tried.map(|(offered, at)| self.trial(offered, at, self.early)).collect();
            tried.sort_by(|a, b| a.cost.total_cmp(&b.cost));
            tried.truncate(KEPT);
            best = tried.into_iter().map(|trial| self.settled(trial, self.early).0).collect();
            best.sort_by(|a, b| a.cost.total_cmp(&b.cost));
            known = best.first().map_or(known, |trial| trial.inner);
        }
        best
    }

    /// Gauss–Newton steps over the first `count` intervals, with the slopes where they end.
    fn settled(&self, mut at: Trial, count: usize) -> (Trial, DMatrix<f64>) {
        let prior = self.prior();
        let mut slopes = self.slopes(&at, count);
        for _ in 0..STEPS {
            let precision = slopes.tr_mul(&slopes) + DMatrix::from_diagonal(&prior);
            let pull = prior.component_mul(&self.away(&at.offered, &at.inner));
            let Some(factor) = precision.cholesky() else { break };
            let step = factor.solve(&(slopes.tr_mul(&at.left) + pull));
            let mut inner = at.inner;
            self.open.iter().zip(step.iter()).for_each(|(&k, step)| inner[k] -= step);
            let reached = self.trial(at.offered, inner, count);
            let (gain, better) = (at.cost - reached.cost, reached.cost < at.cost);
            if better {
                at = reached;
                slopes = self.slopes(&at, count);
            }
            if !better || gain < SETTLED {
                break;
            }
        }
        (at, slopes)
    }

    fn slopes(&self, at: &Trial, count: usize) -> DMatrix<f64> {
        let column = |&k: &usize| {
            let (mut moved, h) = (at.inner, RELATIVE * self.states[k].sd);
            moved[k] += h;
            (DVector::from_vec((self.of)(&moved, count)) - &at.left) / h
        };
        DMatrix::from_columns(&self.open.iter().map(column).collect::<Vec<_>>())
    }

    /// The most probable start.
    fn start(&self) -> Start {
        let whole = self.ranked().into_iter().map(|early| self.trial(early.offered, early.inner, usize::MAX));
        let first = first_on_offer(&self.states);
        let best = whole.min_by(|a, b| a.cost.total_cmp(&b.cost));
        let best = best.unwrap_or_else(|| self.trial(first, first, usize::MAX));
        let (at, slopes) = self.settled(best, usize::MAX);
        let (prior, moved) = (self.prior(), self.away(&at.offered, &at.inner));
        let precision = slopes.tr_mul(&slopes) + DMatrix::from_diagonal(&prior);
        let grown = precision.determinant() / prior.product();
        let price = 0.5 * (moved.dot(&prior.component_mul(&moved)) + grown.ln());
        Start { inner: at.inner, slopes, precision, price }
    }
}

impl Along {
    /// Where the laws' own states begin in each episode.
    pub(super) fn starts(&self, plant: &Plant<f64>, own: &[f64]) -> Vec<Start> {
        let states = states(plant);
        let open: Vec<usize> = (0..states.len()).filter(|&k| states[k].starts.len() > 1).collect();
        let known = Start { inner: first_on_offer(&states), ..Start::default() };
        if open.is_empty() {
            return vec![known; self.paths.len()];
        }
        let without = self.without_laws(own);
        let mut rest = without.as_slice();
        let mut found = Vec::with_capacity(self.paths.len());
        for (e, path) in self.paths.iter().enumerate() {
            let (mine, others) = rest.split_at(3 * path.intervals.len());
            rest = others;
            let of = |inner: &[f64; INNER], count: usize| {
                let laws = self.of_laws_in(plant, e, inner, count);
                laws.iter().zip(mine).map(|(law, rest)| law + rest).collect()
            };
            let early = path.until(SETTLING_TIME_S);
            found.push(Search { states: states.clone(), open: open.clone(), early, of: &of }.start());
        }
        found
    }
}

/// Where the laws' own states begin in an episode that is simulated: the first second after contact tells.
pub(super) fn beginning(
    foreign: &Foreign<'_>,
    (plant, values): (&Plant<f64>, &[f64]),
    episode: &Prepared,
    (noise, dof): (&Noise, [bool; 3]),
    watch: &dyn Watch,
) -> Result<[f64; INNER], InferError> {
    let states = states(plant);
    let first = first_on_offer(&states);
    if states.iter().all(|state| state.starts.len() < 2) {
        return Ok(first);
    }
    let Ok(mut path) = Path::new(episode, noise) else { return Ok(first) };
    path.intervals.truncate(path.until(SETTLING_TIME_S));
    let along = Along::new(foreign, values, &[path], Channels::of(noise), dof, watch)?;
    Ok(along.starts(plant, values).first().map_or(first, |start| start.inner))
}
