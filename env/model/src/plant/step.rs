//! Free motion: one step of a plant under an applied wrench.
//!
//! The laws give the generalised force `f − D·twist`. Damping is treated implicitly, because a locked wheel makes
//! `μ·dt/m` much larger than one. A half step of implicit Euler predicts the middle of the interval, where damping,
//! force and heading are evaluated. The full step is the (0,2) Padé approximant
//!
//! ```text
//! (I + hA + h²A²/2) u' = u + (h + h²A/2) w,    A = M^-½ D M^-½,  u = M^½ v,  w = M^-½ f
//! ```
//! It is of second order, L-stable, and does not overshoot where dry friction stops a body (`D = f/|v|`).

use super::Plant;
use crate::frames::twist_at;
use crate::generalised_force::GeneralisedForce;
use crate::heading::Heading;
use crate::implicit::MassMatrix;
use crate::law::{Clock, Rigid};
use crate::variable_mass::VariableMassMatrix;
use crate::{Real, State};

/// Largest number of times that a step is halved, so that a part is at least 1/16 of it.
const MAX_HALVINGS: u32 = 4;

/// Largest change of velocity over a step that a change of the damping within its first half may cause, m/s. A step
/// above this limit is halved.
const MAX_EXACT_CHANGE_M_PER_S: f64 = 7e-4;

/// The same limit for [`Precision::Fit`], m/s. With steps of 10 ms, a foot that sticks and slides has an error of 0.14
/// mm after 3 s (`tests/plant.rs`); a limit of 7e-4 m/s gives 1.4 mm.
const MAX_FIT_CHANGE_M_PER_S: f64 = 2e-4;

/// The same limit for [`Precision::Rough`], m/s.
const MAX_ROUGH_CHANGE_M_PER_S: f64 = 0.02;

/// Accuracy of a step in which the damping changes, as dry friction does when a body stops.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Precision {
    /// For simulation: the error estimate uses the total speed. Steps in which one direction sticks while another
    /// slides are then divided to the limit.
    Exact,
    /// For fits to noisy poses: the error estimate uses the velocity that the change of damping acts on.
    Fit,
    /// For planning, where only the start of a plan is executed.
    Rough,
}

impl Precision {
    /// Whether a step is accurate enough. Both arguments estimate the change of velocity, m/s, that the change of the
    /// scaled damping `C` causes: from the total speed and from the velocity vector.
    #[inline]
    fn is_met(self, by_speed: f64, by_velocity: impl FnOnce() -> f64) -> bool {
        match self {
            Self::Exact => by_speed < MAX_EXACT_CHANGE_M_PER_S,
            Self::Fit => by_speed < MAX_FIT_CHANGE_M_PER_S || by_velocity() < MAX_FIT_CHANGE_M_PER_S,
            Self::Rough => by_speed < MAX_ROUGH_CHANGE_M_PER_S,
        }
    }
}

/// Limits of the subdivision of a step.
#[derive(Clone, Copy)]
struct Subdivision {
    halvings: u32,
    precision: Precision,
}

impl<T: Real> Plant<T> {
    /// The state after `dt` seconds under `applied`, the mean wrench on the object over the step in object axes about
    /// the object origin. The wrench turns with the object.
    ///
    /// The step is halved repeatedly while the damping changes much within it, as dry friction does when a body stops
    /// or reverses.
    #[inline]
    pub fn step(&self, state: &State<T>, applied: [T; 3], clock: Clock, dt: f64) -> State<T> {
        let mut state = *state;
        self.step_in_place(&mut state, &applied, clock, dt);
        state
    }

    /// [`Plant::step`] in place, which avoids copies of states with many derivatives.
    pub fn step_in_place(&self, state: &mut State<T>, applied: &[T; 3], clock: Clock, dt: f64) {
        self.step_with_precision(Precision::Exact, state, applied, clock, dt);
    }

    /// [`Plant::step_in_place`] with a chosen precision.
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
            self.add_force(
                &self.law_context(state.pose, start, twist, rigid, clock, &state.inner),
                &mut first,
            );
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
            let pose = [x + vx * half, y + vy * half, heading.angle()];
            if self.inner > 0 {
                let at = self.law_context(pose, heading, twist, rigid, clock, &state.inner);
                self.advance(&at, half, &mut inner);
                let mut end = state.inner;
                self.advance(&at, dt, &mut end);
                inner_after = Some(end);
            }
            let mut force = *constant;
            self.add_force(&self.law_context(pose, heading, twist, rigid, clock, &inner), &mut force);
            let speed = twist.iter().map(|v| v.re() * v.re()).sum::<f64>().sqrt();
            Some((force, speed))
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

    /// One undivided step. Returns pose and twist after it, and whether it meets `precision`, judged by the change of
    /// the damping in its first half.
    ///
    /// `first` is the generalised force at the start. `middle` returns the force and the speed at the middle, given the
    /// velocity of the mass centre in axes of the start and the heading; if it returns `None`, `constant` acts.
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
        let (near, half_damping) = mass_matrix.solve_euler(centre_before, first, half);
        let heading = start.rotated_to(theta + (before[2] + near[2]) * (half / 2.0));
        let at_middle = middle(&near, heading);
        let force = at_middle.as_ref().map_or(constant, |(force, _)| force);
        let (after, damping) = mass_matrix.solve_pade(heading.to_body(before), force, dt);
        let is_met = at_middle.as_ref().is_none_or(|(_, speed)| {
            let change = damping.plus(half_damping.times(-2.0));
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
            let parts = [(start, 1.0), (from[k], 1.0), (to[k], -1.0), (before[k], half), (after[k], half)];
            let value = start.re() + (from[k].re() - to[k].re()) + (before[k].re() + after[k].re()) * half;
            T::chained(value, parts)
        };
        ([along(0), along(1), end], twist_at(after, [-to[0], -to[1]]), is_met)
    }
}
