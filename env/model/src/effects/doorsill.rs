//! A low, straight ridge across the floor that each support point must climb: a doorsill, a cable cover, a joint
//! between two floors.
//!
//! ```text
//! U = Σ_k w_k m g h B(s_k / b),   B(u) = exp(−u²/2),   s_k: distance of the support point k from the line
//! ```
//! The force on each point is `w_k m g h (s_k/b²) B` along the normal of the line. It opposes the motion uphill and
//! assists it downhill.

use super::geometry::support_points;
use super::{angle, positive, signed};
use crate::generalised_force::GeneralisedForce;
use crate::law::{EffectLaw, EffectTarget, LawContext, LawSetup, Role, Spec, take};
use crate::{Real, STANDARD_GRAVITY_M_PER_S2};
use std::f64::consts::TAU;

pub(crate) static SPEC: Spec = Spec {
    kind: "doorsill",
    effect: "doorsill",
    summary: "a low straight ridge on the floor that each support point must climb",
    source: "potential energy of the climb, m g h; a wheel of radius r smooths the ridge to a width of about √(2rh)",
    target: EffectTarget::Object,
    is_dissipative: false,
    changes_mass: false,
    inner_states: &[],
    params: &[
        angle("angle", TAU, "direction of the normal of the line, world"),
        signed("offset", "m", 100.0, 2.0, "distance of the line from the world origin along the normal")
            .role(Role::Region),
        positive("height", "m", 0.2, (0.004, 0.7), "height of the ridge"),
        positive("width", "m", 0.5, (0.02, 0.5), "standard deviation of the profile of the ridge")
            .role(Role::Region)
            .at_least(2e-3)
            .refinement(0.02),
    ],
    neutral: &[("height", 0.0)],
    sentence: "A ridge of height {height}, such as a doorsill or a cable, crosses the floor at {offset} from the world \
        origin along the direction {angle}.",
    suggested_push: "cross the ridge slowly in both directions: a ridge resists uphill and assists downhill, a floor \
        patch always resists",
};

/// Distance from the line, in widths, beyond which the force is negligible.
const MAX_DISTANCE_WIDTHS: f64 = 8.0;

/// Law with its parameters.
#[derive(Clone, Debug)]
pub struct Doorsill<T> {
    /// Support points, object frame, m, and their shares of the weight.
    feet: Vec<([f64; 2], f64)>,
    normal: [T; 2],
    offset: T,
    height: T,
    width: T,
}

impl<T: Real> EffectLaw<T> for Doorsill<T> {
    fn new(values: &[T], site: &LawSetup<'_, T>) -> Self {
        let [angle, offset, height, width] = take(values);
        let (sin, cos) = angle.sin_cos();
        Self { feet: support_loads(site.body), normal: [cos, sin], offset, height, width }
    }

    #[inline]
    fn add_force(&self, at: &LawContext<'_, T>, sum: &mut GeneralisedForce<T>) {
        if !at.clock.in_contact() {
            return;
        }
        let [nx, ny] = self.normal;
        let normal = at.object_axes(self.normal);
        for &(foot, share) in &self.feet {
            let foot = foot.map(T::lift);
            let [x, y] = at.in_world(foot);
            let along = (x * nx + y * ny - self.offset) / self.width;
            if along.re().abs() < MAX_DISTANCE_WIDTHS {
                let bump = (-(along.squared() * 0.5)).exp() * along / self.width;
                let size = at.mass * self.height * bump * (STANDARD_GRAVITY_M_PER_S2 * share);
                sum.add_force_at(foot, normal.map(|n| n * size));
            }
        }
    }
}

/// Feet with their shares of the weight, or corners with equal shares.
fn support_loads(body: &crate::Body) -> Vec<([f64; 2], f64)> {
    if body.feet.is_some() {
        return body.support.iter().map(|s| (s.point, s.share)).collect();
    }
    let corners = support_points(body);
    let share = 1.0 / corners.len().max(1) as f64;
    corners.into_iter().map(|corner| (corner, share)).collect()
}
