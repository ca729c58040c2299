//! Free motion: one step of a model under an applied wrench.
//!
//! The laws give `push − drag·twist`; the drag is treated implicitly, because a locked wheel makes
//! `μ·dt/m` much larger than one. A half step of implicit Euler finds the middle of the interval,
//! where drag, push and heading are taken; the whole step then is the (0,2) Padé approximant
//!
//! ```text
//! (I + hA + h²A²/2) u' = u + (h + h²A/2) w,    A = M^-½ D M^-½,  u = M^½ v,  w = M^-½ push
//! ```
//! second order, L-stable, and without overshoot where dry friction stops a body (`D = f/|v|`).

use crate::heading::Heading;
use crate::implicit::{Inert, Inertia};
use crate::law::{Acting, Action, Clock, INNER, Lags, Rigid, Situation};
use crate::loaded::Loaded;
use crate::mount::Mount;
use crate::{Body, Glide, Law, ModelError, Real, State, Unnamed};
use std::sync::Arc;

/// A step is halved at most so often: to 1/16.
const HALVINGS: u32 = 4;

/// What a change of the drag within half a step may do to the velocity over a step before it is halved, m/s.
const STEADY: f64 = 7e-4;

/// The same for a fit, taken with the velocity that the change acts on, m/s. In steps of 10 ms a foot that sticks and slides
/// is then 0.14 mm off after 3 s (`tests/plant.rs`); at 7e-4 m/s it is 1.4 mm off.
const CLOSELY: f64 = 2e-4;

/// The same for a plan, m/s.
const ROUGHLY: f64 = 0.02;

/// How exactly a step is followed where the drag changes within it, as dry friction does when a body stops.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Precision {
    /// As a simulation must: the change counts with the whole speed, so that a direction which sticks while another
    /// slides is followed in the finest parts.
    Exact,
    /// As a fit to noisy poses needs it: the change counts with the velocity that it acts on.
    Fit,
    /// As a plan needs it, of which only the beginning is carried out.
    Rough,
}

impl Precision {
    /// Whether a step is exact enough, by what a change of its `C` does to the velocity, m/s: taken with the whole
    /// speed, and with the velocity itself.
    #[inline]
    fn is_met(self, by_speed: f64, by_velocity: impl FnOnce() -> f64) -> bool {
        match self {
            Self::Exact => by_speed < STEADY,
            Self::Fit => by_speed < CLOSELY || by_velocity() < CLOSELY,
            Self::Rough => by_speed < ROUGHLY,
        }
    }
}

/// How a step is divided: so often at most, and how exactly.
#[derive(Clone, Copy)]
struct Parts {
    halvings: u32,
    precision: Precision,
}

/// A model with its parameters in place, ready to be stepped.
#[derive(Clone, Debug)]
pub struct Plant<T> {
    /// Mass, kg.
    pub mass: T,
    /// Inertia about the mass centre, kg·m².
    pub inertia: T,
    /// Mass centre, object frame, m.
    pub com: [T; 2],
    /// The laws.
    pub laws: Vec<Law<T>>,
    /// What resists a change of velocity where no law changes it.
    resistance: Inertia<T>,
    dof: [bool; 3],
    /// Whether a law changes what is moved.
    loads: bool,
    /// Number of the laws' own states.
    inner: usize,
    /// Whether a law says that readings are late.
    late: bool,
    lags: Option<Lags<T>>,
    /// The tracked frame, where it is not the object's.
    mount: Option<Mount<T>>,
    /// What the laws do together that no state changes.
    steady: Action<T>,
    /// Whether there are others that act on the object.
    varies: bool,
    unnamed: Option<Arc<Unnamed>>,
}

/// Where each law's own states begin and end.
fn windows<T: Real>(laws: &[Law<T>]) -> impl Iterator<Item = (&Law<T>, std::ops::Range<usize>)> {
    let mut end = 0;
    laws.iter().map(move |law| {
        let start = end;
        end += law.spec().inner.len();
        (law, start..end)
    })
}

impl<T: Real> Plant<T> {
    pub(crate) fn new(
        mass: T,
        body: &Body,
        dof: [bool; 3],
        laws: Vec<Law<T>>,
        unnamed: Option<Arc<Unnamed>>,
    ) -> Result<Self, ModelError> {
        let inertia = mass * (body.gyration * body.gyration);
        let com = body.com.map(T::lift);
        let loads = laws.iter().any(|l| l.spec().loads);
        let inner = laws.iter().map(|l| l.spec().inner.len()).sum();
        if inner > INNER {
            return Err(ModelError::Inner { got: inner, most: INNER });
        }
        let late = laws.iter().any(|law| law.delay(Clock::since_contact(0.0)).is_some());
        let lags = laws.iter().filter_map(Law::lags).reduce(Lags::and);
        let mount = laws.iter().find_map(Law::mount).map(Mount::at);
        let mut steady = Action::none();
        laws.iter().filter_map(Law::steady).for_each(|action| steady.add(action));
        let steady = mount.as_ref().map_or(steady, |mount| mount.action(&steady));
        let acts = |l: &Law<T>| l.steady().is_none() && l.spec().acting == Acting::Object;
        let varies =
            inner > 0 || laws.iter().any(acts) || unnamed.as_ref().is_some_and(|unnamed| !unnamed.reads());
        let flat = !varies && mass.is_constant() && steady.drag.iter().all(|d| d.is_constant());
        let resistance = Inertia::new(mass, body, dof, flat);
        Ok(Self {
            mass,
            inertia,
            com,
            laws,
            resistance,
            dof,
            loads,
            inner,
            late,
            lags,
            mount,
            steady,
            varies,
            unnamed,
        })
    }

    /// What moves as one under the reading at a moment: the object, and what instruments add to it. In the frame that
    /// is tracked.
    pub fn rigid(&self, clock: Clock) -> Rigid<T> {
        self.moved(self.object(clock), clock)
    }

    /// The object alone at a moment, in its own frame.
    pub fn object(&self, clock: Clock) -> Rigid<T> {
        let rigid = Rigid { mass: self.mass, com: self.com, inertia: self.inertia };
        if self.loads { self.loaded(rigid, Acting::Object, clock) } else { rigid }
    }

    fn moved(&self, mut rigid: Rigid<T>, clock: Clock) -> Rigid<T> {
        if let Some(mount) = &self.mount {
            rigid.com = mount.place(rigid.com);
        }
        if self.loads { self.loaded(rigid, Acting::Instrument, clock) } else { rigid }
    }

    /// With the loads that laws of one sort put on it.
    fn loaded(&self, mut rigid: Rigid<T>, acting: Acting, clock: Clock) -> Rigid<T> {
        for law in self.laws.iter().filter(|law| law.spec().acting == acting) {
            law.load(clock, &mut rigid);
        }
        rigid
    }

    /// Pose of the tracked frame in the object frame, where a law says that they differ.
    pub fn mount(&self) -> Option<[T; 3]> {
        self.laws.iter().find_map(Law::mount)
    }

    /// By how much the reading of what happens at a moment is late, s; `None` where no law says so.
    #[inline]
    pub fn delay(&self, clock: Clock) -> Option<T> {
        if !self.late {
            return None;
        }
        self.laws.iter().filter_map(|law| law.delay(clock)).reduce(|a, b| a + b)
    }

    /// First-order lags between wrench and reading; `None` where no law says so.
    #[inline]
    pub fn lags(&self) -> Option<Lags<T>> {
        self.lags
    }

    /// Whether a reading depends on those before it, by more than a delay.
    pub fn remembers(&self) -> bool {
        self.lags.is_some() || self.laws.iter().any(Law::follows_trend)
    }

    /// Whether the motion from a place and heading is that from any other, moved and turned.
    pub fn same_everywhere(&self) -> bool {
        self.laws.iter().all(Law::same_everywhere)
            && self.unnamed.as_ref().is_none_or(|unnamed| unnamed.same_everywhere())
    }

    /// Whether it has a wrench without a name.
    pub fn is_unnamed(&self) -> bool {
        self.unnamed.is_some()
    }

    /// Number of the laws' own states.
    pub fn inner(&self) -> usize {
        self.inner
    }

    /// What all laws do at a state, object axes about the object origin.
    pub fn action(&self, state: &State<T>, clock: Clock) -> Action<T> {
        let heading = Heading::of(state.pose[2]);
        let object = self.object(clock);
        let twist = heading.to_body(state.twist);
        let at = self.situation(state.pose, heading, twist, &object, clock, &state.inner);
        let mut sum = self.steady;
        self.act(&at, &mut sum);
        sum
    }

    /// The laws' own states `dt` seconds later where the object moves as `state` says, whatever acts on it.
    pub fn carried_on(&self, state: &State<T>, clock: Clock, dt: f64) -> [T; INNER] {
        let mut inner = state.inner;
        if self.inner > 0 {
            let (heading, object) = (Heading::of(state.pose[2]), self.object(clock));
            let twist = heading.to_body(state.twist);
            let at = self.situation(state.pose, heading, twist, &object, clock, &state.inner);
            self.advance(&at, dt, &mut inner);
        }
        inner
    }

    /// A sensor reading, reading axes about its reference point, as the wrench that truly acted.
    #[inline]
    pub fn correct(&self, mut reading: [T; 3], clock: Clock) -> [T; 3] {
        for law in self.laws.iter().filter(|law| law.spec().acting == Acting::Instrument) {
            reading = law.correct(reading, clock);
        }
        self.unnamed.as_ref().map_or(reading, |unnamed| unnamed.correct(reading, clock))
    }

    /// The state after `dt` seconds under `applied`, the mean wrench on the object over the step
    /// in object axes about the object origin (it turns with the object).
    ///
    /// Where the drag changes much within the step, as dry friction does when a body stops or turns
    /// back, the step is halved, again and again if need be.
    #[inline]
    pub fn step(&self, state: &State<T>, applied: [T; 3], clock: Clock, dt: f64) -> State<T> {
        let mut state = *state;
        self.move_on(&mut state, &applied, clock, dt);
        state
    }

    /// As [`Plant::step`], in place: with derivatives a state is too large to be copied about.
    pub fn move_on(&self, state: &mut State<T>, applied: &[T; 3], clock: Clock, dt: f64) {
        self.move_as(Precision::Exact, state, applied, clock, dt);
    }

    /// The same with other precision.
    pub fn move_as(
        &self,
        precision: Precision,
        state: &mut State<T>,
        applied: &[T; 3],
        clock: Clock,
        dt: f64,
    ) {
        let parts = Parts { halvings: HALVINGS, precision };
        let [x, y, torque] = self.steady.push;
        let push = [applied[0] + x, applied[1] + y, applied[2] + torque];
        let steady = Action { push, drag: self.steady.drag };
        let object = self.object(clock);
        if self.loads || self.mount.is_some() {
            let inert = Loaded::new(self.moved(object, clock), self.dof);
            self.halved(&inert, &object, state, &steady, clock, dt, parts);
        } else {
            self.halved(&self.resistance, &object, state, &steady, clock, dt, parts);
        }
    }

    #[allow(clippy::too_many_arguments)]
    fn halved<I: Inert<T>>(
        &self,
        inert: &I,
        rigid: &Rigid<T>,
        state: &mut State<T>,
        steady: &Action<T>,
        clock: Clock,
        dt: f64,
        parts: Parts,
    ) {
        let start = Heading::of(state.pose[2]);
        let mut first = *steady;
        if self.varies {
            let twist = start.to_body(state.twist);
            self.act(&self.situation(state.pose, start, twist, rigid, clock, &state.inner), &mut first);
        }
        let mut ended = None;
        let middle = |near: &[T; 3], heading: Heading<T>| {
            if !self.varies {
                return None;
            }
            let mut inner = state.inner;
            let twist = inert.at_origin(heading.to_body(start.to_world(*near)));
            let [x, y, _] = state.pose;
            let [vx, vy, _] = state.twist;
            let half = dt / 2.0;
            let place = [x + vx * half, y + vy * half, heading.angle()];
            if self.inner > 0 {
                let at = self.situation(place, heading, twist, rigid, clock, &state.inner);
                self.advance(&at, half, &mut inner);
                let mut end = state.inner;
                self.advance(&at, dt, &mut end);
                ended = Some(end);
            }
            let mut action = *steady;
            self.act(&self.situation(place, heading, twist, rigid, clock, &inner), &mut action);
            let speed = twist.iter().map(|v| v.re() * v.re()).sum::<f64>().sqrt();
            Some((action, speed))
        };
        let (pose, twist, close) =
            self.leap(inert, start, state, [&first, steady], middle, dt, parts.precision);
        if parts.halvings == 0 || close {
            (state.pose, state.twist) = (pose, twist);
            if let Some(ended) = ended {
                state.inner = ended;
            }
            return;
        }
        let parts = Parts { halvings: parts.halvings - 1, ..parts };
        for _ in 0..2 {
            self.halved(inert, rigid, state, steady, clock, dt / 2.0, parts);
        }
    }

    /// One undivided step: pose and twist after it, and whether it is exact enough, by how the drag changes in its first
    /// half. `first` acts at the start, and what `middle` says in the middle, with the speed there, given the velocity of
    /// the mass centre in axes of the start, and the heading; `steady` where it says nothing.
    #[inline(always)]
    #[allow(clippy::too_many_arguments)]
    fn leap<I: Inert<T>>(
        &self,
        inert: &I,
        start: Heading<T>,
        state: &State<T>,
        [first, steady]: [&Action<T>; 2],
        middle: impl FnOnce(&[T; 3], Heading<T>) -> Option<(Action<T>, f64)>,
        dt: f64,
        precision: Precision,
    ) -> ([T; 3], [T; 3], bool) {
        let half = dt / 2.0;
        let theta = state.pose[2];
        let from = inert.place(start);
        let before = carried(state.twist, from);
        let begun = inert.at_center(start.to_body(state.twist));
        let (near, drag) = inert.solve_half(begun, first, half);
        let heading = start.turned(theta + (before[2] + near[2]) * (half / 2.0));
        let acting = middle(&near, heading);
        let action = acting.as_ref().map_or(steady, |(action, _)| action);
        let (after, whole) = inert.solve(heading.to_body(before), action, dt);
        let close = acting.as_ref().is_none_or(|(_, speed)| {
            let change = whole.plus(drag.times(-2.0));
            let by_velocity = || inert.slowed(&begun, change).max(inert.slowed(&near, change));
            precision.is_met(change.trace().abs() * speed, by_velocity)
        });
        let after = heading.to_world(after);
        let end = theta + (before[2] + after[2]) * half;
        let to = inert.place(heading.turned(end));
        let along = |k: usize| {
            let start = state.pose[k];
            let parts = [(start, 1.0), (from[k], 1.0), (to[k], -1.0), (before[k], half), (after[k], half)];
            let value = start.re() + (from[k].re() - to[k].re()) + (before[k].re() + after[k].re()) * half;
            T::chained(value, parts)
        };
        ([along(0), along(1), end], carried(after, [-to[0], -to[1]]), close)
    }

    /// What the laws see: the object's own frame.
    #[inline(always)]
    fn situation<'a>(
        &self,
        pose: [T; 3],
        heading: Heading<T>,
        twist: [T; 3],
        rigid: &Rigid<T>,
        clock: Clock,
        inner: &'a [T; INNER],
    ) -> Situation<'a, T> {
        let Some(mount) = &self.mount else {
            return situation(pose, heading, twist, rigid, clock, inner);
        };
        let pose = mount.pose(pose);
        situation(pose, Heading::of(pose[2]), mount.twist(twist), rigid, clock, inner)
    }

    /// Add what all laws do that states change.
    #[inline]
    fn act(&self, at: &Situation<'_, T>, sum: &mut Action<T>) {
        let Some(mount) = &self.mount else {
            return self.add(at, sum);
        };
        let mut own = Action::none();
        self.add(at, &mut own);
        sum.add(&mount.action(&own));
    }

    /// Add what all laws do, in the object's own frame.
    #[inline]
    fn add(&self, at: &Situation<'_, T>, sum: &mut Action<T>) {
        if let Some(unnamed) = &self.unnamed {
            unnamed.act(at, sum);
        }
        if self.inner == 0 {
            for law in self.laws.iter().filter(|law| law.steady().is_none()) {
                law.act(at, sum);
            }
            return;
        }
        for (law, own) in windows(&self.laws).filter(|(law, _)| law.steady().is_none()) {
            law.act(&Situation { inner: &at.inner[own], ..*at }, sum);
        }
    }

    /// Move the laws' own states on.
    fn advance(&self, at: &Situation<'_, T>, dt: f64, inner: &mut [T; INNER]) {
        for (law, own) in windows(&self.laws).filter(|(_, own)| !own.is_empty()) {
            law.advance(&Situation { inner: &at.inner[own.clone()], ..*at }, dt, &mut inner[own]);
        }
    }
}

impl Plant<f64> {
    /// The same step for a given length, solved beforehand; `None` where a state changes what acts or what moves.
    pub fn glide(&self, dt: f64) -> Option<Glide> {
        let plain = !self.varies && !self.loads && self.mount.is_none();
        plain.then(|| Glide::new(&self.resistance, self.com, &self.steady, dt))
    }
}

#[inline(always)]
fn situation<'a, T: Real>(
    [x, y, _]: [T; 3],
    heading: Heading<T>,
    twist: [T; 3],
    rigid: &Rigid<T>,
    clock: Clock,
    inner: &'a [T; INNER],
) -> Situation<'a, T> {
    let heading = heading.sin_cos();
    Situation { position: [x, y], heading, twist, mass: rigid.mass, com: rigid.com, clock, inner }
}

/// The twist of a body, taken at a point that lies `[x, y]` from where it was given.
#[inline(always)]
pub(crate) fn carried<T: Real>([vx, vy, spin]: [T; 3], [x, y]: [T; 2]) -> [T; 3] {
    let (px, py, turn) = (x.re(), y.re(), spin.re());
    [
        T::chained(vx.re() - turn * py, [(vx, 1.0), (spin, -py), (y, -turn)]),
        T::chained(vy.re() + turn * px, [(vy, 1.0), (spin, px), (x, turn)]),
        spin,
    ]
}
