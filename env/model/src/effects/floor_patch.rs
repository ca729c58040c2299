//! A patch of the floor with viscous friction: a carpet, a wet spot, a strip of tape.
//!
//! ```text
//! F_k = −μ g(p_k) v_k at each support point k;   g = b(ξ/L) b(η/W), 1 within the rectangle and 0 outside
//! ```
//! `ξ`, `η` are the coordinates of the point in the axes of the rectangle. The edges are smooth, so that position and
//! size of the rectangle have gradients.

use super::geometry::{in_world, support_points};
use super::{angle, positive};
use crate::Real;
use crate::generalised_force::GeneralisedForce;
use crate::law::{EffectLaw, EffectTarget, LawContext, LawSetup, Role, Spec, take};
use std::f64::consts::PI;

pub(crate) static SPEC: Spec = Spec {
    kind: "floor_patch",
    effect: "floor_patch",
    summary: "a region of the floor with viscous friction at each support point inside it",
    source: "viscous friction in a region with logistic edges, 10 to 90 % over 2.2 cm",
    target: EffectTarget::Object,
    is_dissipative: true,
    changes_mass: false,
    inner_states: &[],
    params: &[
        in_world("x", 0, "centre of the region, world"),
        in_world("y", 1, "centre of the region, world").planar(),
        positive("half_length", "m", 50.0, (0.4, 0.8), "half of the length of the region").role(Role::Region),
        positive("half_width", "m", 50.0, (0.4, 0.8), "half of the width of the region")
            .role(Role::Region)
            .planar(),
        angle("angle", PI, "direction of the length, world").planar(),
        positive("mu", "N·s/m", 1e6, (50.0, 1.5), "viscous friction at each support point inside"),
    ],
    neutral: &[("mu", 0.0)],
    sentence: "A patch of the floor around ({x}, {y}) resists with {mu} at each support point inside it.",
    suggested_push: "return to the same place with another heading: a floor patch stays in place, a load moves with \
        the object",
};

/// Length scale of an edge, m: the coverage rises from 10 to 90 % within 4.4 times this length.
const EDGE_WIDTH_M: f64 = 0.005;

/// Distance from an edge beyond which its smoothing is negligible (2e-9), m.
const EDGE_REACH_M: f64 = 0.1;

/// Law with its parameters.
#[derive(Clone, Debug)]
pub struct FloorPatch<T> {
    feet: Vec<[f64; 2]>,
    center: [T; 2],
    half: [T; 2],
    /// Direction of the length, world axes.
    along: [T; 2],
    mu: T,
}

impl<T: Real> EffectLaw<T> for FloorPatch<T> {
    fn new(values: &[T], site: &LawSetup<'_, T>) -> Self {
        let [x, y, length, width, angle, mu] = take(values);
        let (sin, cos) = angle.sin_cos();
        Self { feet: support_points(site.body), center: [x, y], half: [length, width], along: [cos, sin], mu }
    }

    #[inline]
    fn add_force(&self, at: &LawContext<'_, T>, sum: &mut GeneralisedForce<T>) {
        for foot in &self.feet {
            // Far from every edge no derivative is needed.
            let mu = match self.depth(at.in_world_value(*foot)) {
                depth if depth < -EDGE_REACH_M => continue,
                depth if depth > EDGE_REACH_M => self.mu,
                _ => self.mu * self.coverage(at.in_world(foot.map(T::lift))),
            };
            sum.add_isotropic_damping_at(foot.map(T::lift), mu);
        }
    }
}

impl<T: Real> FloorPatch<T> {
    /// Distance of a world point inside the nearest edge, m; negative outside.
    fn depth(&self, [x, y]: [f64; 2]) -> f64 {
        let (dx, dy) = (x - self.center[0].re(), y - self.center[1].re());
        let [ax, ay] = self.along.map(T::re);
        let [length, width] = self.half.map(T::re);
        (length - (dx * ax + dy * ay).abs()).min(width - (dy * ax - dx * ay).abs())
    }

    /// Coverage of a world point, from 0 (outside) to 1 (inside).
    fn coverage(&self, [x, y]: [T; 2]) -> T {
        let (dx, dy) = (x - self.center[0], y - self.center[1]);
        let [ax, ay] = self.along;
        let [length, width] = self.half;
        within(dx * ax + dy * ay, length) * within(dy * ax - dx * ay, width)
    }
}

/// 1 for `|at| < half`, 0 beyond, with a transition of width [`EDGE_WIDTH_M`].
fn within<T: Real>(at: T, half: T) -> T {
    if at.re().abs() - half.re() > EDGE_REACH_M {
        return T::zero();
    }
    logistic(half - at) + logistic(half + at) - T::lift(1.0)
}

/// Logistic step.
fn logistic<T: Real>(at: T) -> T {
    let value = 1.0 / (1.0 + (-at.re() / EDGE_WIDTH_M).exp());
    T::chained(value, [(at, value * (1.0 - value) / EDGE_WIDTH_M)])
}

/// Corners of a `floor_patch` in the world, m, given its parameter values in the order of the catalogue.
pub fn patch_outline(values: &[f64]) -> Vec<[f64; 2]> {
    let [x, y, length, width, angle, _] = take(values);
    let (sin, cos) = f64::sin_cos(angle);
    let corner = |(a, b): (f64, f64)| {
        let (u, v) = (a * length, b * width);
        [x + u * cos - v * sin, y + u * sin + v * cos]
    };
    [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(corner).to_vec()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn patch(angle: f64) -> FloorPatch<f64> {
        let (sin, cos) = angle.sin_cos();
        FloorPatch { feet: vec![], center: [1.0, 2.0], half: [0.5, 0.2], along: [cos, sin], mu: 1.0 }
    }

    #[test]
    fn the_coverage_matches_the_outline() {
        let patch = patch(0.5);
        let corners = patch_outline(&[1.0, 2.0, 0.5, 0.2, 0.5, 1.0]);
        for corner in corners {
            // Along the ray from the centre through the corner.
            let at = |share: f64| [0, 1].map(|k| patch.center[k] + share * (corner[k] - patch.center[k]));
            assert!((patch.coverage(at(0.8)) - 1.0).abs() < 1e-3, "{}", patch.coverage(at(0.8)));
            assert!((patch.coverage(corner) - 0.25).abs() < 1e-6);
            assert!(patch.coverage(at(1.2)) < 1e-3);
        }
    }

    #[test]
    fn distant_points_do_not_overflow() {
        for far in [1e3, -1e3] {
            assert_eq!(patch(0.0).coverage([far, far]), 0.0);
        }
    }

    #[test]
    fn far_from_every_edge_coverage_is_zero_or_one() {
        let patch = FloorPatch { half: [0.7, 0.4], ..patch(0.5) };
        for k in 0..10_000 {
            let place = [f64::from(k % 100), f64::from(k / 100)].map(|n| 0.04 * n);
            let (coverage, depth) = (patch.coverage(place), patch.depth(place));
            if depth > EDGE_REACH_M {
                assert!((coverage - 1.0).abs() < 1e-8, "{place:?} {coverage}");
            } else if depth < -EDGE_REACH_M {
                assert!(coverage < 1e-8, "{place:?} {coverage}");
            }
        }
        assert!(patch.depth([1.0, 2.0]) > EDGE_REACH_M && patch.depth([0.0, 0.0]) < -EDGE_REACH_M);
    }
}
