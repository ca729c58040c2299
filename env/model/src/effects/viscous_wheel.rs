//! One anisotropic viscous wheel: the paper's `J_w = ⟨w_x, w_y, w_θ, μ_x, μ_y⟩`.
//!
//! ```text
//! F = −R(w_θ) diag(μ_x, μ_y) R(w_θ)ᵀ v(w)            (eq. 1–2)
//! ```
//! The paper's eq. 2 omits the sign and the rotation by `w_θ`; both are meant.

use super::{angle, on_body, positive};
use crate::Real;
use crate::law::{Act, Acting, Action, Site, Spec, take};

pub(crate) static SPEC: Spec = Spec {
    kind: "viscous_wheel",
    effect: "viscous_wheel",
    summary: "a wheel, track or slide: viscous friction along and across its rolling direction",
    source: "Scholz et al., eq. 1-2",
    acting: Acting::Object,
    dissipative: true,
    loads: false,
    inner: &[],
    params: &[
        on_body("x", 0, "wheel position, object frame"),
        on_body("y", 1, "wheel position, object frame"),
        angle("angle", std::f64::consts::PI, "rolling direction, object frame").planar(),
        positive("mu_x", "N·s/m", 1e6, (30.0, 2.0), "viscous friction along the rolling direction"),
        positive("mu_y", "N·s/m", 1e6, (30.0, 2.0), "viscous friction across it").planar(),
    ],
    neutral: &[("mu_x", 0.0), ("mu_y", 0.0)],
    sentence: "A viscous wheel at ({x}, {y}) resists with {mu_x} along and {mu_y} across its rolling direction.",
    probe: "push along and across the wheel's rolling direction at two speeds",
};

/// The drag of a wheel `[x, y, angle, mu_x, mu_y]` on the body.
pub(crate) fn wheel_drag<T: Real>([x, y, angle, mu_x, mu_y]: [T; 5]) -> Action<T> {
    let (sin, cos) = angle.sin_cos();
    let (along, across, mixed) = (cos.squared(), sin.squared(), sin * cos);
    let matrix = [mu_x * along + mu_y * across, (mu_x - mu_y) * mixed, mu_x * across + mu_y * along];
    let mut drag = Action::none();
    drag.drag_at([x, y], matrix);
    drag
}

/// The law in place: its drag on the body, which no state changes.
#[derive(Clone, Debug)]
pub struct ViscousWheel<T> {
    drag: Action<T>,
}

impl<T: Real> Act<T> for ViscousWheel<T> {
    const SAME_EVERYWHERE: bool = true;

    fn new(values: &[T], _site: &Site<'_, T>) -> Self {
        Self { drag: wheel_drag(take(values)) }
    }

    #[inline]
    fn steady(&self) -> Option<&Action<T>> {
        Some(&self.drag)
    }
}
