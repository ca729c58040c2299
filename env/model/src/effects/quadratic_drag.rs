//! Resistance that grows with the square of the speed: air, water, a churning lubricant.
//!
//! ```text
//! F = −c √(|v|² + ε²) v,   at the middle of the body
//! ```

use super::positive;
use crate::Real;
use crate::law::{Act, Acting, Action, Site, Situation, Spec, take};

pub(crate) static SPEC: Spec = Spec {
    kind: "quadratic_drag",
    effect: "quadratic_drag",
    summary: "resistance that grows with the square of the speed, in the middle of the body",
    source: "Rayleigh's drag equation, F = ½ ρ A c_w v²",
    acting: Acting::Object,
    dissipative: true,
    loads: false,
    inner: &[],
    params: &[positive("drag", "N·s²/m²", 1e6, (30.0, 1.5), "force over the square of the speed")],
    neutral: &[("drag", 0.0)],
    sentence: "Resistance grows with the square of the speed: {drag}.",
    probe: "push the same way at constant speed, three times, each twice as fast: dry friction stays, viscous friction \
            doubles, this becomes four times as large",
};

/// Speed below which it is viscous, m/s: there is no corner at rest.
const ROUND: f64 = 1e-3;

/// The law in place.
#[derive(Clone, Debug)]
pub struct QuadraticDrag<T> {
    center: [T; 2],
    drag: T,
}

impl<T: Real> Act<T> for QuadraticDrag<T> {
    const SAME_EVERYWHERE: bool = true;

    fn new(values: &[T], site: &Site<'_, T>) -> Self {
        let [drag] = take(values);
        Self { center: site.body.com.map(T::lift), drag }
    }

    #[inline]
    fn act(&self, at: &Situation<'_, T>, sum: &mut Action<T>) {
        let [vx, vy] = at.velocity(self.center);
        let speed = (vx.squared() + vy.squared() + ROUND * ROUND).sqrt();
        sum.brake_at(self.center, self.drag * speed);
    }
}
