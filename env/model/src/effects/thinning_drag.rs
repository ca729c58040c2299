//! Drag that thins with speed: a thick grease, a gel, a deep felt under the whole body.
//!
//! ```text
//! F = −Σ_i s_i f (|v_i|/u)ⁿ v_i/|v_i|,   0 < n < 1,   u = 0.1 m/s,   |v|² → |v|² + ε²
//! ```
//! `v_i` is the velocity of a support point and `s_i` its share of the weight. At `n = 0` it is dry friction, at
//! `n = 1` viscous. What drags need not lie where the weight rests: the points are spread and, as a refinement, shifted.

use super::{positive, signed, spread, spread_out};
use crate::Real;
use crate::law::{
    EffectLaw, EffectTarget, GeneralisedForce, LawContext, LawSetup, Param, Prior, Role, Spec, take,
};

/// The exponent of the speed, kept off dry (0) and viscous (1) friction, which are laws of their own.
const fn exponent() -> Param {
    let exponent =
        positive("exponent", "1", 0.95, (0.5, 0.5), "flow index: 0 dry, 1 viscous").role(Role::Shape);
    Param { prior: Prior::Uniform, lower: 0.05, ..exponent }
}

/// Where it acts, as a refinement.
const fn shift(name: &'static str) -> Param {
    signed(name, "m", 2.0, 0.1, "where it acts, from the centre of the support").refinement(0.0).planar()
}

pub(crate) static SPEC: Spec = Spec {
    kind: "thinning_drag",
    effect: "thinning_drag",
    summary: "drag under the whole body that grows with less than the speed (shear thinning)",
    source: "Ostwald and de Waele's power law; Bird, Armstrong, Hassager 1987, ch. 4",
    target: EffectTarget::Object,
    is_dissipative: true,
    changes_mass: false,
    inner_states: &[],
    params: &[
        positive("force", "N", 1e5, (10.0, 1.5), "drag of the whole body at 0.1 m/s"),
        exponent(),
        Param { scales_face_pressure: false, help: "how far out it acts, over the support", ..spread() },
        shift("shift_x"),
        shift("shift_y"),
    ],
    neutral: &[("force", 0.0)],
    sentence: "Drag under the whole body thins with speed: {force} at 0.1 m/s, growing with the speed to the power of \
               {exponent}.",
    suggested_push: "push the same way at constant speed, three times, each four times as fast: dry friction stays, viscous \
            friction grows fourfold, this in between",
};

/// Speed at which the force is stated, m/s.
const REFERENCE_SPEED_M_PER_S: f64 = 0.1;

/// Speed below which it is viscous, m/s: there is no corner at rest.
const SMOOTHING_SPEED_M_PER_S: f64 = 1e-3;

/// The law in place.
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
