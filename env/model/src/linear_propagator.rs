//! Free motion under constant viscous damping: the linear system of a step is solved once and applied to every step.

use crate::frames::twist_at;
use crate::heading::Heading;
use crate::implicit::MassMatrix;
use crate::{GeneralisedForce, State};

/// Precomputed step of a fixed length for a plant whose forces do not depend on the state.
///
/// It gives the result of [`crate::Plant::step_in_place`]: velocities after half a step and a full step are linear in
/// the initial velocity and the force.
#[derive(Clone, Copy, Debug)]
pub struct LinearPropagator {
    dt: f64,
    center: [f64; 2],
    /// Constant force in addition to the applied wrench, object axes.
    force: [f64; 3],
    half: LinearMap,
    full: LinearMap,
}

/// Linear map from the velocity of the mass centre and the force to the velocity after a time; columns.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LinearMap {
    velocity: [[f64; 3]; 3],
    force: [[f64; 3]; 3],
}

impl LinearMap {
    fn new(solve: impl Fn([f64; 3], &GeneralisedForce<f64>) -> [f64; 3], damping: [f64; 6]) -> Self {
        let unit = |k: usize| [0, 1, 2].map(|j| f64::from(u8::from(j == k)));
        let no_force = GeneralisedForce { force: [0.0; 3], damping };
        Self {
            velocity: [0, 1, 2].map(|k| solve(unit(k), &no_force)),
            force: [0, 1, 2].map(|k| solve([0.0; 3], &GeneralisedForce { force: unit(k), damping })),
        }
    }

    #[inline(always)]
    pub fn apply(&self, v: [f64; 3], w: [f64; 3]) -> [f64; 3] {
        let (a, b) = (&self.velocity, &self.force);
        [0, 1, 2].map(|k| {
            (a[0][k] * v[0] + a[1][k] * v[1] + a[2][k] * v[2])
                + (b[0][k] * w[0] + b[1][k] * w[1] + b[2][k] * w[2])
        })
    }
}

impl LinearPropagator {
    pub(crate) fn new(
        mass_matrix: &impl MassMatrix<f64>,
        center: [f64; 2],
        constant: &GeneralisedForce<f64>,
        dt: f64,
    ) -> Self {
        let half =
            LinearMap::new(|v, action| mass_matrix.solve_euler(v, action, dt / 2.0).0, constant.damping);
        let full = LinearMap::new(|v, action| mass_matrix.solve_pade(v, action, dt).0, constant.damping);
        Self { dt, center, force: constant.force, half, full }
    }

    /// Advance a state by one step under `applied`, as [`crate::Plant::step`] does.
    #[inline]
    pub fn step_in_place(&self, state: &mut State<f64>, applied: &[f64; 3]) {
        self.step_with(state, applied, |velocity, map, force| map.apply(velocity, force));
    }

    /// The same. `advance` returns the velocity of the mass centre after the step, object axes, from that before it, the linear
    /// map of a step, and the force.
    #[inline(always)]
    pub(crate) fn step_with(
        &self,
        state: &mut State<f64>,
        applied: &[f64; 3],
        advance: impl FnOnce([f64; 3], &LinearMap, [f64; 3]) -> [f64; 3],
    ) {
        let half = self.dt / 2.0;
        let [x, y, theta] = state.pose;
        let force = [0, 1, 2].map(|k| applied[k] + self.force[k]);
        let start = Heading::of(theta);
        let from = start.rotate_point(self.center);
        let before = twist_at(state.twist, from);
        let near = self.half.apply(start.to_body(before), force);
        let heading = start.rotated_to(theta + (before[2] + near[2]) * (half / 2.0));
        let after = heading.to_world(advance(heading.to_body(before), &self.full, force));
        let end = theta + (before[2] + after[2]) * half;
        let to = heading.rotated_to(end).rotate_point(self.center);
        state.pose = [
            x + (from[0] - to[0]) + (before[0] + after[0]) * half,
            y + (from[1] - to[1]) + (before[1] + after[1]) * half,
            end,
        ];
        state.twist = twist_at(after, [-to[0], -to[1]]);
    }
}

#[cfg(test)]
mod tests {
    use crate::{Body, Clock, Effect, Kind, Model, State};

    const DT: f64 = 2e-3;

    fn table(effects: Vec<Effect>) -> Model {
        let body = Body::from_footprint(&[[-0.6, -0.4], [0.7, -0.4], [0.6, 0.4], [-0.6, 0.3]], 22.0).unwrap();
        let mut model = Model::nominal(body, Some(22.0), [true; 3]);
        model.effects = effects;
        model
    }

    fn wheel(values: [f64; 5]) -> Effect {
        Effect { kind: Kind::ViscousWheel, values: values.map(Some).to_vec() }
    }

    #[test]
    fn the_propagator_agrees_with_the_plant() {
        let stiff = wheel([-0.5, 0.3, 0.3, 180.0, 1e5]);
        let plant = table(vec![stiff, wheel([0.5, -0.3, 1.0, 8.0, 3.0])]).resolved().unwrap();
        let propagator = plant.linear_propagator(DT).unwrap();
        let mut state = State::moving([0.1, -0.2, 3.0], [0.4, 0.1, 2.0]);
        let mut other = state;
        for tick in 0..1000 {
            let t = f64::from(tick) * DT;
            let applied = [60.0 * (3.0 * t).sin(), 40.0 * (5.0 * t).cos(), 20.0 * (2.0 * t).sin()];
            plant.step_in_place(&mut state, &applied, Clock::since_contact(t), DT);
            propagator.step_in_place(&mut other, &applied);
        }
        let off = state.pose.iter().chain(&state.twist).zip(other.pose.iter().chain(&other.twist));
        let gap = off.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(gap < 1e-12 && state.pose[0].hypot(state.pose[1]) > 0.1, "{gap} {state:?}");
    }

    #[test]
    fn state_dependent_plants_have_no_propagator() {
        for kind in [Kind::CoulombFriction, Kind::CasterSwivel, Kind::MassChange, Kind::TrackerOffset] {
            let spec = kind.spec();
            let given = spec.params.iter().map(|p| Some(0.1f64.clamp(p.lower, p.upper))).collect();
            let plant = table(vec![Effect { kind, values: given }]).resolved().unwrap();
            assert!(plant.linear_propagator(DT).is_none(), "{kind:?}");
        }
    }
}
