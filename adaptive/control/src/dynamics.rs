//! Dynamics of the object in rollouts.

use std::f64::consts::SQRT_2;

use trundle_model::{Clock, LinearPropagator, Plant, Precision, SlidingPropagator, State};

/// Speed along each axis at which the resistance is linearised to find the anchor, m/s.
const ANCHOR_SPEED_M_PER_S: f64 = 0.15;
/// Smallest grip of an anchor, N.
const MIN_ANCHOR_GRIP_N: f64 = 1.0;

/// Point of an object at which dry friction acts, such as a foot on the floor. Object frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Anchor {
    /// Position, m.
    pub at: [f64; 2],
    /// Breakaway force, N.
    pub grip: f64,
}

/// Dynamics of the object under a wrench: a physical model or a learnt one.
pub trait Dynamics: Sync {
    /// Advance a state by `dt`, s, under the constant wrench `applied`, `[N, N, N·m]`, object axes about the object origin.
    fn step(&self, state: &mut State<f64>, applied: &[f64; 3], clock: Clock, dt: f64);

    /// Anchor of dry friction. The default has no grip.
    fn anchor(&self) -> Anchor {
        Anchor::default()
    }

    /// Precomputed [`Dynamics::step`] of length `dt`, s, if there is one.
    fn fast_step(&self, _dt: f64) -> Option<FastStep> {
        None
    }
}

/// A precomputed step.
#[derive(Clone, Debug)]
pub enum FastStep {
    /// Viscous damping.
    Linear(LinearPropagator),
    /// Viscous damping and dry friction.
    Sliding(SlidingPropagator),
}

impl FastStep {
    /// Advance a state as [`Dynamics::step`] does.
    #[inline]
    pub fn step_in_place(&self, state: &mut State<f64>, applied: &[f64; 3]) {
        match self {
            Self::Linear(propagator) => propagator.step_in_place(state, applied),
            Self::Sliding(propagator) => propagator.step_in_place(state, applied),
        }
    }
}

impl Dynamics for Plant<f64> {
    #[inline]
    fn step(&self, state: &mut State<f64>, applied: &[f64; 3], clock: Clock, dt: f64) {
        self.step_with_precision(Precision::Rough, state, applied, clock, dt);
    }

    fn anchor(&self) -> Anchor {
        let drag = |speed: f64| {
            let slowly = State { twist: [speed, speed, 0.0], ..State::at_rest([0.0; 3]) };
            self.generalised_force(&slowly, Clock::since_contact(0.0)).damping
        };
        let force = |[xx, _, yy, ..]: [f64; 6], speed: f64| (xx + yy) / 2.0 * speed * SQRT_2;
        let slow @ [xx, xy, yy, tx, ty, _] = drag(ANCHOR_SPEED_M_PER_S);
        // Extrapolate the resistance from two speeds to zero speed.
        let grip = 2.0 * force(slow, ANCHOR_SPEED_M_PER_S)
            - force(drag(2.0 * ANCHOR_SPEED_M_PER_S), 2.0 * ANCHOR_SPEED_M_PER_S);
        let det = xx * yy - xy * xy;
        if grip < MIN_ANCHOR_GRIP_N || det <= 0.0 {
            return Anchor::default();
        }
        // A damper A at r resists a unit turn about the origin with the force A (−r_y, r_x).
        Anchor { at: [(xx * ty - xy * tx) / det, (xy * ty - yy * tx) / det], grip }
    }

    fn fast_step(&self, dt: f64) -> Option<FastStep> {
        let linear = self.linear_propagator(dt).map(FastStep::Linear);
        linear.or_else(|| self.sliding_propagator(dt).map(FastStep::Sliding))
    }
}

impl<D: Dynamics + ?Sized> Dynamics for &D {
    #[inline]
    fn step(&self, state: &mut State<f64>, applied: &[f64; 3], clock: Clock, dt: f64) {
        (**self).step(state, applied, clock, dt);
    }

    fn anchor(&self) -> Anchor {
        (**self).anchor()
    }

    fn fast_step(&self, dt: f64) -> Option<FastStep> {
        (**self).fast_step(dt)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use trundle_model::{Body, Effect, Kind, Model};

    fn table(effects: Vec<Effect>) -> Plant<f64> {
        let corners = [[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]];
        let mut model = Model::nominal(Body::from_footprint(&corners, 22.0).unwrap(), Some(22.0), [true; 3]);
        model.effects = effects;
        model.resolved().unwrap()
    }

    fn wheel() -> Effect {
        Effect { kind: Kind::ViscousWheel, values: [-0.5, 0.3, 0.4, 200.0, 60.0].map(Some).to_vec() }
    }

    fn foot(force: f64) -> Effect {
        let values = [("x", 0.5), ("y", -0.3), ("force", force)];
        values.iter().fold(Effect::free(Kind::CoulombFriction), |e, (k, v)| e.with(k, Some(*v)))
    }

    #[test]
    fn the_anchor_is_at_the_foot_with_dry_friction() {
        let Anchor { at: [x, y], grip } = table(vec![foot(40.0)]).anchor();
        assert!((x - 0.5).abs() < 1e-9 && (y + 0.3).abs() < 1e-9, "{x} {y}");
        assert!((grip - 40.0).abs() < 0.5, "{grip}");
    }

    #[test]
    fn viscous_friction_has_no_anchor() {
        assert_eq!(table(vec![]).anchor(), Anchor::default());
        assert_eq!(table(vec![wheel()]).anchor(), Anchor::default());
    }

    #[test]
    fn an_additional_wheel_shifts_the_anchor_towards_it() {
        let Anchor { at: [x, y], grip } = table(vec![wheel(), foot(40.0)]).anchor();
        assert!((-0.5..0.5).contains(&x) && (-0.3..0.3).contains(&y), "{x} {y}");
        assert!((grip - 40.0).abs() < 4.0, "{grip}");
    }
}
