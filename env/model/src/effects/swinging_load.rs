//! A part of the mass that moves in the plane on a spring: a crate between elastic stops, a drawer, the first sloshing
//! mode of a liquid, a hanging bag.
//!
//! ```text
//! m q̈ = −m ω² (q − p) − 2 ζ m ω (q̇ − v(q)),   the reaction acts on the body;   ω = 2π · frequency
//! ```
//! `q` is the position of the load, `p` that of its anchor, and `v(q)` the velocity of the body at the load. The inner
//! states are the displacement `q − p` and the velocity `q̇`, in world axes; the acceleration of the body is then not
//! needed. The rigid part keeps its mass centre, and its mass is smaller by `m`.

use super::{on_body, positive};
use crate::Real;
use crate::generalised_force::GeneralisedForce;
use crate::law::{Clock, EffectLaw, EffectTarget, InnerState, LawContext, LawSetup, Rigid, Role, Spec, take};
use std::f64::consts::TAU;

pub(crate) static SPEC: Spec = Spec {
    kind: "swinging_load",
    effect: "swinging_load",
    summary: "part of the mass moves in the plane on a spring",
    source: "mechanical analogue of a sloshing or hanging load: Dodge 2000, ch. 3",
    target: EffectTarget::Object,
    is_dissipative: false,
    changes_mass: true,
    inner_states: &[
        InnerState { name: "displacement_x", unit: "m", sd: 1e-3, starts: &[0.0] },
        InnerState { name: "displacement_y", unit: "m", sd: 1e-3, starts: &[0.0] },
        InnerState { name: "velocity_x", unit: "m/s", sd: 5e-3, starts: &[0.0] },
        InnerState { name: "velocity_y", unit: "m/s", sd: 5e-3, starts: &[0.0] },
    ],
    params: &[
        on_body("x", 0, "anchor of the spring, object frame"),
        on_body("y", 1, "anchor of the spring, object frame"),
        positive("mass", "kg", 1e3, (3.0, 0.8), "mass of the load, included in the total mass"),
        positive("frequency", "Hz", 20.0, (1.5, 0.6), "natural frequency while the body is held")
            .role(Role::Shape)
            .at_least(0.05),
        positive("damping_ratio", "1", 2.0, (0.03, 1.0), "damping ratio of the spring")
            .role(Role::Shape)
            .at_least(1e-3)
            .refinement(0.02),
    ],
    neutral: &[("mass", 0.0)],
    sentence: "A load of {mass} oscillates at {frequency} on a spring anchored at ({x}, {y}).",
    suggested_push: "stop abruptly and hold the object: the load continues to oscillate at its natural frequency",
};

/// Smallest fraction of the mass in the rigid part.
const MIN_RIGID_FRACTION: f64 = 0.1;

/// Law with its parameters.
#[derive(Clone, Debug)]
pub struct SwingingLoad<T> {
    anchor: [T; 2],
    mass: T,
    /// `ω²`, 1/s².
    stiffness_per_mass: T,
    /// `2 ζ ω`, 1/s.
    damping_per_mass: T,
}

impl<T: Real> EffectLaw<T> for SwingingLoad<T> {
    fn new(values: &[T], _site: &LawSetup<'_, T>) -> Self {
        let [x, y, mass, frequency, damping] = take(values);
        let omega = frequency * TAU;
        Self {
            anchor: [x, y],
            mass,
            stiffness_per_mass: omega.squared(),
            damping_per_mass: damping * omega * 2.0,
        }
    }

    #[inline]
    fn add_force(&self, at: &LawContext<'_, T>, sum: &mut GeneralisedForce<T>) {
        let &[dx, dy, vx, vy] = at.inner else { return };
        let [dx, dy] = at.object_axes([dx, dy]);
        let (stiffness, damping) = (self.mass * self.stiffness_per_mass, self.mass * self.damping_per_mass);
        sum.add_force_at(self.anchor, [stiffness * dx, stiffness * dy]);
        let place = [self.anchor[0] + dx, self.anchor[1] + dy];
        sum.add_force_at(place, at.object_axes([vx, vy]).map(|v| v * damping));
        sum.add_isotropic_damping_at(place, damping);
    }

    fn change_mass(&self, _clock: Clock, _grasp: [f64; 2], rigid: &mut Rigid<T>) {
        let left = (rigid.mass - self.mass).max(rigid.mass * MIN_RIGID_FRACTION);
        rigid.inertia = rigid.inertia * left / rigid.mass;
        rigid.mass = left;
    }

    /// Implicit midpoint rule at constant anchor velocity `ṗ` and spin `Ω`. With `w = q̇ − ṗ` and `a = dt/2`, `w_m = (w
    /// − a ω² d + a λ Ω × d)/(1 + aλ + a²ω²)` and `d_m = d + a w_m`. The state at the end is twice the midpoint minus
    /// the state at the start.
    fn advance(&self, at: &LawContext<'_, T>, dt: f64, inner: &mut [T]) {
        let &mut [dx, dy, vx, vy] = inner else { return };
        let [px, py] = at.world_axes(at.point_velocity(self.anchor));
        let a = dt / 2.0;
        let (wx, wy, turn) = (vx - px, vy - py, self.damping_per_mass * at.twist[2]);
        let share = (self.damping_per_mass * a + self.stiffness_per_mass * (a * a) + 1.0).recip();
        let dragged = [-(turn * (dy + wy * a)), turn * (dx + wx * a)];
        for (k, (d, w, p)) in [(dx, wx, px), (dy, wy, py)].into_iter().enumerate() {
            let middle = (w + (dragged[k] - self.stiffness_per_mass * d) * a) * share;
            (inner[k], inner[k + 2]) = (d + middle * dt, p + middle * 2.0 - w);
        }
    }
}
