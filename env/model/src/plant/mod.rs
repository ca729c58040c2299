//! A plant: a model with values for all parameters, ready to be stepped.

pub(crate) mod step;

use crate::generalised_force::GeneralisedForce;
use crate::heading::Heading;
use crate::implicit::ConstantMassMatrix;
use crate::law::{Clock, EffectTarget, Lags, LawContext, MAX_INNER_STATES, Rigid};
use crate::mount::Mount;
use crate::{Body, Discrepancy, Law, LinearPropagator, ModelError, Real, SlidingPropagator, State};
use std::sync::Arc;

/// A model with values for all parameters, ready to be stepped.
#[derive(Clone, Debug)]
pub struct Plant<T> {
    /// Mass, kg.
    pub mass: T,
    /// Inertia about the mass centre, kg·m².
    pub inertia: T,
    /// Mass centre, object frame, m.
    pub com: [T; 2],
    /// Laws of the effects.
    pub laws: Vec<Law<T>>,
    /// Mass matrix, used if no law changes the mass.
    mass_matrix: ConstantMassMatrix<T>,
    dof: [bool; 3],
    /// Whether a law changes the mass properties.
    has_varying_mass: bool,
    /// Number of inner states of all laws.
    inner: usize,
    /// Whether a law delays readings.
    has_delay: bool,
    lags: Option<Lags<T>>,
    /// Tracked frame, if it differs from the object frame.
    mount: Option<Mount<T>>,
    /// Sum of the generalised forces that do not depend on any state.
    constant: GeneralisedForce<T>,
    /// Whether further forces on the object depend on the state.
    has_varying_force: bool,
    discrepancy: Option<Arc<Discrepancy>>,
}

/// Each law with the index range of its inner states.
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
        laws.iter().filter_map(Law::constant_force).for_each(|force| constant.add(force));
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

    /// Mass properties that move under the reading at a time: the object and what instruments add to it, in the tracked
    /// frame.
    pub fn rigid(&self, clock: Clock) -> Rigid<T> {
        self.with_instruments(self.object(clock), clock)
    }

    /// Mass properties of the object alone at a time, object frame.
    pub fn object(&self, clock: Clock) -> Rigid<T> {
        let rigid = Rigid { mass: self.mass, com: self.com, inertia: self.inertia };
        if self.has_varying_mass { self.with_loads(rigid, EffectTarget::Object, clock) } else { rigid }
    }

    /// Mass properties in the tracked frame, with the changes of mass by instruments.
    fn with_instruments(&self, mut rigid: Rigid<T>, clock: Clock) -> Rigid<T> {
        if let Some(mount) = &self.mount {
            rigid.com = mount.transform_point(rigid.com);
        }
        if self.has_varying_mass { self.with_loads(rigid, EffectTarget::Instrument, clock) } else { rigid }
    }

    /// Apply the changes of mass by the laws that act on `target`.
    fn with_loads(&self, mut rigid: Rigid<T>, target: EffectTarget, clock: Clock) -> Rigid<T> {
        for law in self.laws.iter().filter(|law| law.spec().target == target) {
            law.change_mass(clock, &mut rigid);
        }
        rigid
    }

    /// Pose of the tracked frame in the object frame; `None` without a law that moves it.
    pub fn mount(&self) -> Option<[T; 3]> {
        self.laws.iter().find_map(Law::mount)
    }

    /// Delay of the reading, s; `None` without a law that delays it.
    #[inline]
    pub fn delay(&self, clock: Clock) -> Option<T> {
        if !self.has_delay {
            return None;
        }
        self.laws.iter().filter_map(|law| law.delay(clock)).reduce(|a, b| a + b)
    }

    /// First-order lags between wrench and reading; `None` without such a law.
    #[inline]
    pub fn lags(&self) -> Option<Lags<T>> {
        self.lags
    }

    /// Whether a reading depends on earlier readings other than through a delay.
    pub fn has_memory(&self) -> bool {
        self.lags.is_some() || self.laws.iter().any(Law::uses_trend)
    }

    /// Whether the motion is invariant to translation and rotation of the initial pose.
    pub fn is_pose_invariant(&self) -> bool {
        self.laws.iter().all(Law::is_pose_invariant)
            && self.discrepancy.as_ref().is_none_or(|discrepancy| discrepancy.is_pose_invariant())
    }

    /// Whether the plant has a model discrepancy.
    pub fn has_discrepancy(&self) -> bool {
        self.discrepancy.is_some()
    }

    /// Number of inner states of all laws.
    pub fn inner(&self) -> usize {
        self.inner
    }

    /// Generalised force of all laws at a state, object axes about the object origin.
    pub fn generalised_force(&self, state: &State<T>, clock: Clock) -> GeneralisedForce<T> {
        let heading = Heading::of(state.pose[2]);
        let object = self.object(clock);
        let twist = heading.to_body(state.twist);
        let at = self.law_context(state.pose, heading, twist, &object, clock, &state.inner);
        let mut sum = self.constant;
        self.add_force(&at, &mut sum);
        sum
    }

    /// Inner states after `dt` seconds in which the object keeps the twist of `state`, regardless of the forces on it.
    pub fn advanced_inner(&self, state: &State<T>, clock: Clock, dt: f64) -> [T; MAX_INNER_STATES] {
        let mut inner = state.inner;
        if self.inner > 0 {
            let (heading, object) = (Heading::of(state.pose[2]), self.object(clock));
            let twist = heading.to_body(state.twist);
            let at = self.law_context(state.pose, heading, twist, &object, clock, &state.inner);
            self.advance(&at, dt, &mut inner);
        }
        inner
    }

    /// Correct a sensor reading to the wrench that acted, reading axes about the reading's reference point.
    #[inline]
    pub fn correct(&self, mut reading: [T; 3], clock: Clock) -> [T; 3] {
        for law in self.laws.iter().filter(|law| law.spec().target == EffectTarget::Instrument) {
            reading = law.correct(reading, clock);
        }
        self.discrepancy.as_ref().map_or(reading, |discrepancy| discrepancy.correct(reading, clock))
    }

    /// State at which the laws are evaluated, in the object frame.
    #[inline(always)]
    fn law_context<'a>(
        &self,
        pose: [T; 3],
        heading: Heading<T>,
        twist: [T; 3],
        rigid: &Rigid<T>,
        clock: Clock,
        inner: &'a [T; MAX_INNER_STATES],
    ) -> LawContext<'a, T> {
        let Some(mount) = &self.mount else {
            return law_context(pose, heading, twist, rigid, clock, inner);
        };
        let pose = mount.pose(pose);
        law_context(pose, Heading::of(pose[2]), mount.twist(twist), rigid, clock, inner)
    }

    /// Add all state-dependent forces, in the tracked frame.
    #[inline]
    fn add_force(&self, at: &LawContext<'_, T>, sum: &mut GeneralisedForce<T>) {
        let Some(mount) = &self.mount else {
            return self.add_object_force(at, sum);
        };
        let mut own = GeneralisedForce::zero();
        self.add_object_force(at, &mut own);
        sum.add(&mount.transform(&own));
    }

    /// Add all state-dependent forces, in the object frame.
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

    /// Advance the inner states of all laws.
    fn advance(&self, at: &LawContext<'_, T>, dt: f64, inner: &mut [T; MAX_INNER_STATES]) {
        for (law, own) in inner_ranges(&self.laws).filter(|(_, own)| !own.is_empty()) {
            law.advance(&LawContext { inner: &at.inner[own.clone()], ..*at }, dt, &mut inner[own]);
        }
    }
}

impl Plant<f64> {
    /// Precomputed step of a fixed length `dt`, s; `None` if forces or mass properties depend on the state.
    pub fn linear_propagator(&self, dt: f64) -> Option<LinearPropagator> {
        (!self.has_varying_force && self.has_constant_mass()).then(|| self.linear_part(dt))
    }

    /// Precomputed rough step of a fixed length `dt`, s; `None` if forces other than dry friction at points, or mass
    /// properties, depend on the state.
    pub fn sliding_propagator(&self, dt: f64) -> Option<SlidingPropagator> {
        if !self.has_constant_mass() || self.dof != [true; 3] || self.discrepancy.is_some() {
            return None;
        }
        let varies =
            |law: &&Law<f64>| law.constant_force().is_none() && law.spec().target == EffectTarget::Object;
        let points: Option<Vec<_>> = self.laws.iter().filter(varies).map(Law::sliding_points).collect();
        let Rigid { mass, com, inertia } = self.rigid(Clock::since_contact(0.0));
        let points = points?.into_iter().flatten();
        SlidingPropagator::new(self.linear_part(dt), points, [mass, inertia], com, dt)
    }

    fn has_constant_mass(&self) -> bool {
        !self.has_varying_mass && self.mount.is_none()
    }

    /// The motion under the forces that do not depend on the state.
    fn linear_part(&self, dt: f64) -> LinearPropagator {
        LinearPropagator::new(&self.mass_matrix, self.com, &self.constant, dt)
    }
}

#[inline(always)]
fn law_context<'a, T: Real>(
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
