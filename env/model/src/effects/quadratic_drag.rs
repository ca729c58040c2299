//! Drag that grows with the square of the speed: air, water, a churned lubricant.
//!
//! ```text
//! F = −c √(|v|² + ε²) v,   at the mass centre
//! ```

use super::positive;
use crate::Real;
use crate::generalised_force::GeneralisedForce;
use crate::law::{EffectLaw, EffectTarget, LawContext, LawSetup, Spec, take};

pub(crate) static SPEC: Spec = Spec {
    kind: "quadratic_drag",
    effect: "quadratic_drag",
    summary: "drag that grows with the square of the speed, at the mass centre",
    source: "Rayleigh's drag equation, F = ½ ρ A c_w v²",
    target: EffectTarget::Object,
    is_dissipative: true,
    changes_mass: false,
    inner_states: &[],
    params: &[positive("drag", "N·s²/m²", 1e6, (30.0, 1.5), "drag force divided by the square of the speed")],
    neutral: &[("drag", 0.0)],
    sentence: "Drag grows with the square of the speed, with the coefficient {drag}.",
    suggested_push: "push at three constant speeds, each twice the last: dry friction is constant, viscous friction \
        doubles, quadratic drag quadruples",
};

/// Speed below which the drag is viscous, m/s, so that it is smooth at rest.
const SMOOTHING_SPEED_M_PER_S: f64 = 1e-3;

/// Law with its parameters.
#[derive(Clone, Debug)]
pub struct QuadraticDrag<T> {
    drag: T,
}

impl<T: Real> EffectLaw<T> for QuadraticDrag<T> {
    const IS_POSE_INVARIANT: bool = true;

    fn new(values: &[T], _site: &LawSetup<'_, T>) -> Self {
        let [drag] = take(values);
        Self { drag }
    }

    #[inline]
    fn add_force(&self, at: &LawContext<'_, T>, sum: &mut GeneralisedForce<T>) {
        let [vx, vy] = at.point_velocity(at.com);
        let speed = (vx.squared() + vy.squared() + SMOOTHING_SPEED_M_PER_S * SMOOTHING_SPEED_M_PER_S).sqrt();
        sum.add_isotropic_damping_at(at.com, self.drag * speed);
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use crate::{Body, Clock, Effect, Kind, Model, State};

    #[test]
    fn it_acts_at_the_mass_centre_that_another_effect_moves() {
        let corners = [[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]];
        let mut model = Model::nominal(Body::from_footprint(&corners, 22.0).unwrap(), Some(22.0), [true; 3]);
        let offset = Effect::free(Kind::ComOffset).with("com_x", Some(0.2)).with("com_y", Some(-0.1));
        model.effects = vec![offset, Effect::free(Kind::QuadraticDrag).with("drag", Some(25.0))];
        let plant = model.resolved().unwrap();
        let mut state = State::moving([0.0; 3], [0.8, 0.3, 0.0]);
        for _ in 0..100 {
            state = plant.step(&state, [0.0; 3], Clock::since_contact(1.0), 0.01);
        }
        // A force through the mass centre does not turn the object.
        assert!(state.twist[0] < 0.6 && state.twist[2].abs() < 1e-9, "{:?}", state.twist);
    }
}
