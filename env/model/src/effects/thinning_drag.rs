//! Shear-thinning drag under the whole body: thick grease, a gel, deep felt.
//!
//! ```text
//! F = −Σ_i s_i f (|v_i|/u)ⁿ v_i/|v_i|,   0 < n < 1,   u = 0.1 m/s,   |v|² → |v|² + ε²
//! ```
//! `v_i` is the velocity of a support point and `s_i` its share of the weight. `n = 0` is dry friction, `n = 1` viscous
//! friction. The drag need not act at the support points: their spread and, as a refinement, a shift are parameters.

use super::{positive, signed, spread, spread_out};
use crate::Real;
use crate::generalised_force::GeneralisedForce;
use crate::law::{EffectLaw, EffectTarget, LawContext, LawSetup, Param, Prior, Role, Spec, take};

/// Exponent of the speed. Its bounds exclude dry (0) and viscous (1) friction, which have their own laws.
const fn exponent() -> Param {
    let exponent =
        positive("exponent", "1", 0.95, (0.5, 0.5), "flow index: 0 dry, 1 viscous").role(Role::Shape);
    Param { prior: Prior::Uniform, lower: 0.05, ..exponent }
}

/// Shift of the points of action, a refinement.
const fn shift(name: &'static str) -> Param {
    signed(name, "m", 2.0, 0.1, "shift of the points of action from the centre of the support")
        .refinement(0.0)
        .planar()
}

pub(crate) static SPEC: Spec = Spec {
    kind: "thinning_drag",
    effect: "thinning_drag",
    summary: "shear-thinning drag under the whole body: it grows less than proportionally with speed",
    source: "power law of Ostwald and de Waele; Bird, Armstrong, Hassager 1987, ch. 4",
    target: EffectTarget::Object,
    is_dissipative: true,
    changes_mass: false,
    inner_states: &[],
    params: &[
        positive("force", "N", 1e5, (10.0, 1.5), "drag of the whole body at 0.1 m/s"),
        exponent(),
        Param {
            scales_face_pressure: false,
            help: "radial spread of the drag relative to the support",
            ..spread()
        },
        shift("shift_x"),
        shift("shift_y"),
    ],
    neutral: &[("force", 0.0)],
    sentence: "Shear-thinning drag acts under the whole body: {force} at 0.1 m/s, proportional to the speed to the \
        power {exponent}.",
    suggested_push: "push at three constant speeds, each four times the last: dry friction is constant, viscous \
        friction grows fourfold, shear-thinning drag lies between",
};

/// Speed at which `force` is defined, m/s.
const REFERENCE_SPEED_M_PER_S: f64 = 0.1;

/// Speed below which the drag is viscous, m/s, so that it is smooth at rest.
const SMOOTHING_SPEED_M_PER_S: f64 = 1e-3;

/// Law with its parameters.
#[derive(Clone, Debug)]
pub struct ThinningDrag<T> {
    /// Points, object frame, m, and their shares of the weight.
    support: Vec<([T; 2], f64)>,
    force: T,
    exponent: T,
}

/// A positive number to a power.
#[inline]
fn power<T: Real>(base: T, exponent: T) -> T {
    let (b, e) = (base.re(), exponent.re());
    let log = b.ln();
    let value = (e * log).exp();
    T::chained(value, [(base, e * value / b), (exponent, value * log)])
}

impl<T: Real> EffectLaw<T> for ThinningDrag<T> {
    const IS_POSE_INVARIANT: bool = true;

    fn new(values: &[T], site: &LawSetup<'_, T>) -> Self {
        let [force, exponent, spread, x, y] = take(values);
        let shifted = |(point, share): ([T; 2], f64)| ([point[0] + x, point[1] + y], share);
        let support = spread_out(site.body, spread).into_iter().map(shifted).collect();
        Self { support, force, exponent }
    }

    #[inline]
    fn add_force(&self, at: &LawContext<'_, T>, sum: &mut GeneralisedForce<T>) {
        let half = (self.exponent - 1.0) / 2.0;
        for &(point, share) in &self.support {
            let [vx, vy] = at.point_velocity(point);
            let square = (vx.squared() + vy.squared() + SMOOTHING_SPEED_M_PER_S * SMOOTHING_SPEED_M_PER_S)
                / (REFERENCE_SPEED_M_PER_S * REFERENCE_SPEED_M_PER_S);
            sum.add_isotropic_damping_at(
                point,
                self.force * power(square, half) * (share / REFERENCE_SPEED_M_PER_S),
            );
        }
    }
}
