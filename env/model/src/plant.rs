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
use crate::implicit::{ConstantMassMatrix, MassMatrix};
use crate::law::{Clock, EffectTarget, GeneralisedForce, Lags, LawContext, MAX_INNER_STATES, Rigid};
use crate::mount::Mount;
use crate::variable_mass::VariableMassMatrix;
use crate::{Body, Discrepancy, Law, LinearPropagator, ModelError, Real, State};
use std::sync::Arc;

/// A step is step_subdivided at most so often: to 1/16.
const MAX_HALVINGS: u32 = 4;

/// What a change of the drag within half a step may do to the velocity over a step before it is step_subdivided, m/s.
const MAX_EXACT_CHANGE_M_PER_S: f64 = 7e-4;

/// The same for a fit, taken with the velocity that the change acts on, m/s. In steps of 10 ms a foot that sticks and slides
/// is then 0.14 mm off after 3 s (`tests/plant.rs`); at 7e-4 m/s it is 1.4 mm off.
const MAX_FIT_CHANGE_M_PER_S: f64 = 2e-4;

/// The same for a plan, m/s.
const MAX_ROUGH_CHANGE_M_PER_S: f64 = 0.02;

/// How exactly a step is followed where the drag changes within it, as dry friction does when a body stops.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Precision {
    /// As a simulation must: the change counts with the whole speed, so that a direction which sticks while another
    /// slides is followed in the finest parts.
    Exact,
    /// As a fit to noisy poses needs it: the change counts with the velocity that it acts on.
    Fit,
    /// As a plan needs it, of which only the beginning is twist_at out.
    Rough,
}

impl Precision {
    /// Whether a step is exact enough, by what a change of its `C` does to the velocity, m/s: taken with the whole
    /// speed, and with the velocity itself.
    #[inline]
    fn is_met(self, by_speed: f64, by_velocity: impl FnOnce() -> f64) -> bool {
        match self {
            Self::Exact => by_speed < MAX_EXACT_CHANGE_M_PER_S,
            Self::Fit => by_speed < MAX_FIT_CHANGE_M_PER_S || by_velocity() < MAX_FIT_CHANGE_M_PER_S,
            Self::Rough => by_speed < MAX_ROUGH_CHANGE_M_PER_S,
        }
    }
}

/// How a step is divided: so often at most, and how exactly.
#[derive(Clone, Copy)]
struct Subdivision {
    halvings: u32,
    precision: Precision,
}

/// A model with its parameters in place, ready to be stepped.
#[derive(Clone, Debug)]
pub struct Plant<T> {
    /// Mass, kg.
    pub mass: T,
    /// ConstantMassMatrix about the mass centre, kg·m².
    pub inertia: T,
    /// Mass centre, object frame, m.
    pub com: [T; 2],
    /// The laws.
    pub laws: Vec<Law<T>>,
    /// What resists a change of velocity where no law changes it.
    mass_matrix: ConstantMassMatrix<T>,
    dof: [bool; 3],
    /// Whether a law changes what is moved.
    has_varying_mass: bool,
    /// Number of the laws' own states.
    inner: usize,
    /// Whether a law says that readings are late.
    has_delay: bool,
    lags: Option<Lags<T>>,
    /// The tracked frame, where it is not the object's.
    mount: Option<Mount<T>>,
    /// What the laws do together that no state changes.
    constant: GeneralisedForce<T>,
    /// Whether there are others that act on the object.
    has_varying_force: bool,
    discrepancy: Option<Arc<Discrepancy>>,
}

/// Where each law's own states begin and end.
fn inner_ranges<T: Real>(laws: &[Law<T>]) -> impl Iterator<Item = (&Law<T>, std::ops::Range<usize>)> {
    let mut end = 0;
    laws.iter().map(move |law| {
        let start = end;
        end += law.spec().inner_states.len();
        (law, start..end)
    })
}

impl<T: Real> Plant<T> {
    pub(crate) fn new(
        mass: T,
        body: &Body,
        dof: [bool; 3],
        laws: Vec<Law<T>>,
        discrepancy: Option<Arc<Discrepancy>>,
    ) -> Result<Self, ModelError> {
        let inertia = mass * (body.gyration * body.gyration);
        let com = body.com.map(T::lift);
        let has_varying_mass = laws.iter().any(|l| l.spec().changes_mass);
        let inner = laws.iter().map(|l| l.spec().inner_states.len()).sum();
        if inner > MAX_INNER_STATES {
            return Err(ModelError::TooManyInnerStates { got: inner, max: MAX_INNER_STATES });
        }
        let has_delay = laws.iter().any(|law| law.delay(Clock::since_contact(0.0)).is_some());
        let lags = laws.iter().filter_map(Law::lags).reduce(Lags::in_series);
        let mount = laws.iter().find_map(Law::mount).map(Mount::at);
        let mut constant = GeneralisedForce::zero();
        laws.iter().filter_map(Law::constant_force).for_each(|action| constant.add(action));
        let constant = mount.as_ref().map_or(constant, |mount| mount.transform(&constant));
        let acts = |l: &Law<T>| l.constant_force().is_none() && l.spec().target == EffectTarget::Object;
        let has_varying_force = inner > 0
            || laws.iter().any(acts)
            || discrepancy.as_ref().is_some_and(|discrepancy| !discrepancy.corrects_reading());
        let is_constant =
            !has_varying_force && mass.is_constant() && constant.damping.iter().all(|d| d.is_constant());
        let mass_matrix = ConstantMassMatrix::new(mass, body, dof, is_constant);
        Ok(Self {
            mass,
            inertia,
            com,
            laws,
            mass_matrix,
            dof,
            has_varying_mass,
            inner,
            has_delay,
            lags,
            mount,
            constant,
            has_varying_force,
            discrepancy,
        })
    }

    /// What moves as one under the reading at a moment: the object, and what instruments add to it. In the frame that
    /// is tracked.
    pub fn rigid(&self, clock: Clock) -> Rigid<T> {
        self.with_instruments(self.object(clock), clock)
    }

    /// The object alone at a moment, in its own frame.
    pub fn object(&self, clock: Clock) -> Rigid<T> {
        let rigid = Rigid { mass: self.mass, com: self.com, inertia: self.inertia };
        if self.has_varying_mass { self.with_loads(rigid, EffectTarget::Object, clock) } else { rigid }
    }

    fn with_instruments(&self, mut rigid: Rigid<T>, clock: Clock) -> Rigid<T> {
        if let Some(mount) = &self.mount {
            rigid.com = mount.transform_point(rigid.com);
        }
        if self.has_varying_mass { self.with_loads(rigid, EffectTarget::Instrument, clock) } else { rigid }
    }

    /// With the loads that laws of one sort put on it.
    fn with_loads(&self, mut rigid: Rigid<T>, acting: EffectTarget, clock: Clock) -> Rigid<T> {
        for law in self.laws.iter().filter(|law| law.spec().target == acting) {
            law.change_mass(clock, &mut rigid);
        }
        rigid
    }

    /// Pose of the tracked frame in the object frame, where a law says that they differ.
    pub fn mount(&self) -> Option<[T; 3]> {
        self.laws.iter().find_map(Law::mount)
    }

    /// By how much the reading of what happens at a moment is has_delay, s; `None` where no law says so.
    #[inline]
    pub fn delay(&self, clock: Clock) -> Option<T> {
        if !self.has_delay {
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
    pub fn has_memory(&self) -> bool {
        self.lags.is_some() || self.laws.iter().any(Law::uses_trend)
    }

    /// Whether the motion from a place and heading is that from any other, moved and turned.
    pub fn is_pose_invariant(&self) -> bool {
        self.laws.iter().all(Law::is_pose_invariant)
            && self.discrepancy.as_ref().is_none_or(|discrepancy| discrepancy.is_pose_invariant())
    }

    /// Whether it has a wrench without a name.
    pub fn has_discrepancy(&self) -> bool {
        self.discrepancy.is_some()
    }

    /// Number of the laws' own states.
    pub fn inner(&self) -> usize {
        self.inner
    }

    /// What all laws do at a state, object axes about the object origin.
    pub fn generalised_force(&self, state: &State<T>, clock: Clock) -> GeneralisedForce<T> {
        let heading = Heading::of(state.pose[2]);
        let object = self.object(clock);
        let twist = heading.to_body(state.twist);
        let at = self.situation(state.pose, heading, twist, &object, clock, &state.inner);
        let mut sum = self.constant;
        self.add_force(&at, &mut sum);
        sum
    }

    /// The laws' own states `dt` seconds later where the object moves as `state` says, whatever acts on it.
    pub fn advanced_inner(&self, state: &State<T>, clock: Clock, dt: f64) -> [T; MAX_INNER_STATES] {
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
        for law in self.laws.iter().filter(|law| law.spec().target == EffectTarget::Instrument) {
            reading = law.correct(reading, clock);
        }
        self.discrepancy.as_ref().map_or(reading, |discrepancy| discrepancy.correct(reading, clock))
    }

    /// The state after `dt` seconds under `applied`, the mean wrench on the object over the step
    /// in object axes about the object origin (it turns with the object).
    ///
    /// Where the drag changes much within the step, as dry friction does when a body stops or turns
    /// back, the step is step_subdivided, again and again if need be.
    #[inline]
    pub fn step(&self, state: &State<T>, applied: [T; 3], clock: Clock, dt: f64) -> State<T> {
        let mut state = *state;
        self.step_in_place(&mut state, &applied, clock, dt);
        state
    }

    /// As [`Plant::step`], in place: with derivatives a state is too large to be copied about.
    pub fn step_in_place(&self, state: &mut State<T>, applied: &[T; 3], clock: Clock, dt: f64) {
        self.step_with_precision(Precision::Exact, state, applied, clock, dt);
    }

    /// The same with other precision.
    pub fn step_with_precision(
        &self,
        precision: Precision,
        state: &mut State<T>,
        applied: &[T; 3],
        clock: Clock,
        dt: f64,
    ) {
        let subdivision = Subdivision { halvings: MAX_HALVINGS, precision };
        let [x, y, torque] = self.constant.force;
        let force = [applied[0] + x, applied[1] + y, applied[2] + torque];
        let constant = GeneralisedForce { force, damping: self.constant.damping };
        let object = self.object(clock);
        if self.has_varying_mass || self.mount.is_some() {
            let mass_matrix = VariableMassMatrix::new(self.with_instruments(object, clock), self.dof);
            self.step_subdivided(&mass_matrix, &object, state, &constant, clock, dt, subdivision);
        } else {
            self.step_subdivided(&self.mass_matrix, &object, state, &constant, clock, dt, subdivision);
        }
    }

    #[allow(clippy::too_many_arguments)]
    fn step_subdivided<I: MassMatrix<T>>(
        &self,
        mass_matrix: &I,
        rigid: &Rigid<T>,
        state: &mut State<T>,
        constant: &GeneralisedForce<T>,
        clock: Clock,
        dt: f64,
        subdivision: Subdivision,
    ) {
        let start = Heading::of(state.pose[2]);
        let mut first = *constant;
        if self.has_varying_force {
            let twist = start.to_body(state.twist);
            self.add_force(&self.situation(state.pose, start, twist, rigid, clock, &state.inner), &mut first);
        }
        let mut inner_after = None;
        let middle = |near: &[T; 3], heading: Heading<T>| {
            if !self.has_varying_force {
                return None;
            }
            let mut inner = state.inner;
            let twist = mass_matrix.origin_twist(heading.to_body(start.to_world(*near)));
            let [x, y, _] = state.pose;
            let [vx, vy, _] = state.twist;
            let half = dt / 2.0;
            let place = [x + vx * half, y + vy * half, heading.angle()];
            if self.inner > 0 {
                let at = self.situation(place, heading, twist, rigid, clock, &state.inner);
                self.advance(&at, half, &mut inner);
                let mut end = state.inner;
                self.advance(&at, dt, &mut end);
                inner_after = Some(end);
            }
            let mut action = *constant;
            self.add_force(&self.situation(place, heading, twist, rigid, clock, &inner), &mut action);
            let speed = twist.iter().map(|v| v.re() * v.re()).sum::<f64>().sqrt();
            Some((action, speed))
        };
        let (pose, twist, is_met) =
            self.step_once(mass_matrix, start, state, [&first, constant], middle, dt, subdivision.precision);
        if subdivision.halvings == 0 || is_met {
            (state.pose, state.twist) = (pose, twist);
            if let Some(inner_after) = inner_after {
                state.inner = inner_after;
            }
            return;
        }
        let subdivision = Subdivision { halvings: subdivision.halvings - 1, ..subdivision };
        for _ in 0..2 {
            self.step_subdivided(mass_matrix, rigid, state, constant, clock, dt / 2.0, subdivision);
        }
    }

    /// One undivided step: pose and twist after it, and whether it is exact enough, by how the drag changes in its first
    /// half. `first` acts at the start, and what `middle` says in the middle, with the speed there, given the velocity of
    /// the mass centre in axes of the start, and the heading; `constant` where it says nothing.
    #[inline(always)]
    #[allow(clippy::too_many_arguments)]
    fn step_once<I: MassMatrix<T>>(
        &self,
        mass_matrix: &I,
        start: Heading<T>,
        state: &State<T>,
        [first, constant]: [&GeneralisedForce<T>; 2],
        middle: impl FnOnce(&[T; 3], Heading<T>) -> Option<(GeneralisedForce<T>, f64)>,
        dt: f64,
        precision: Precision,
    ) -> ([T; 3], [T; 3], bool) {
        let half = dt / 2.0;
        let theta = state.pose[2];
        let from = mass_matrix.centre_offset(start);
        let before = twist_at(state.twist, from);
        let centre_before = mass_matrix.centre_twist(start.to_body(state.twist));
        let (near, drag) = mass_matrix.solve_euler(centre_before, first, half);
        let heading = start.rotated_to(theta + (before[2] + near[2]) * (half / 2.0));
        let at_middle = middle(&near, heading);
        let action = at_middle.as_ref().map_or(constant, |(action, _)| action);
        let (after, whole) = mass_matrix.solve_pade(heading.to_body(before), action, dt);
        let is_met = at_middle.as_ref().is_none_or(|(_, speed)| {
            let change = whole.plus(drag.times(-2.0));
            let by_velocity = || {
                mass_matrix
                    .velocity_change(&centre_before, change)
                    .max(mass_matrix.velocity_change(&near, change))
            };
            precision.is_met(change.trace().abs() * speed, by_velocity)
        });
        let after = heading.to_world(after);
        let end = theta + (before[2] + after[2]) * half;
        let to = mass_matrix.centre_offset(heading.rotated_to(end));
        let along = |k: usize| {
            let start = state.pose[k];
            let parts =
                [(start, 1.0), (from[k], 1.0), (to[k], -1.0), (before[k], half), (after[k], half)];
            let value = start.re() + (from[k].re() - to[k].re()) + (before[k].re() + after[k].re()) * half;
            T::chained(value, parts)
        };
        ([along(0), along(1), end], twist_at(after, [-to[0], -to[1]]), is_met)
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
        inner: &'a [T; MAX_INNER_STATES],
    ) -> LawContext<'a, T> {
        let Some(mount) = &self.mount else {
            return situation(pose, heading, twist, rigid, clock, inner);
        };
        let pose = mount.pose(pose);
        situation(pose, Heading::of(pose[2]), mount.twist(twist), rigid, clock, inner)
    }

    /// Add what all laws do that states change.
    #[inline]
    fn add_force(&self, at: &LawContext<'_, T>, sum: &mut GeneralisedForce<T>) {
        let Some(mount) = &self.mount else {
            return self.add_object_force(at, sum);
        };
        let mut own = GeneralisedForce::zero();
        self.add_object_force(at, &mut own);
        sum.add(&mount.transform(&own));
    }

    /// Add what all laws do, in the object's own frame.
    #[inline]
    fn add_object_force(&self, at: &LawContext<'_, T>, sum: &mut GeneralisedForce<T>) {
        if let Some(discrepancy) = &self.discrepancy {
            discrepancy.add_force(at, sum);
        }
        if self.inner == 0 {
            for law in self.laws.iter().filter(|law| law.constant_force().is_none()) {
                law.add_force(at, sum);
            }
            return;
        }
        for (law, own) in inner_ranges(&self.laws).filter(|(law, _)| law.constant_force().is_none()) {
            law.add_force(&LawContext { inner: &at.inner[own], ..*at }, sum);
        }
    }

    /// Move the laws' own states on.
    fn advance(&self, at: &LawContext<'_, T>, dt: f64, inner: &mut [T; MAX_INNER_STATES]) {
        for (law, own) in inner_ranges(&self.laws).filter(|(_, own)| !own.is_empty()) {
            law.advance(&LawContext { inner: &at.inner[own.clone()], ..*at }, dt, &mut inner[own]);
        }
    }
}

impl Plant<f64> {
    /// The same step for a given length, solved beforehand; `None` where a state changes what acts or what moves.
    pub fn linear_propagator(&self, dt: f64) -> Option<LinearPropagator> {
        let plain = !self.has_varying_force && !self.has_varying_mass && self.mount.is_none();
        plain.then(|| LinearPropagator::new(&self.mass_matrix, self.com, &self.constant, dt))
    }
}

#[inline(always)]
fn situation<'a, T: Real>(
    [x, y, _]: [T; 3],
    heading: Heading<T>,
    twist: [T; 3],
    rigid: &Rigid<T>,
    clock: Clock,
    inner: &'a [T; MAX_INNER_STATES],
) -> LawContext<'a, T> {
    let heading = heading.sin_cos();
    LawContext { position: [x, y], heading, twist, mass: rigid.mass, com: rigid.com, clock, inner }
}

/// The twist of a body, taken at a point that lies `[x, y]` from where it was given.
#[inline(always)]
pub(crate) fn twist_at<T: Real>([vx, vy, spin]: [T; 3], [x, y]: [T; 2]) -> [T; 3] {
    let (px, py, turn) = (x.re(), y.re(), spin.re());
    [
        T::chained(vx.re() - turn * py, [(vx, 1.0), (spin, -py), (y, -turn)]),
        T::chained(vy.re() + turn * px, [(vy, 1.0), (spin, px), (x, turn)]),
        spin,
    ]
}
