//! Dry friction under the whole body: the sum over its support points, each loaded by its share
//! of the weight (Zhou et al. 2016, eq. 2, for known points of support). Under a flat face nobody knows the
//! pressure: its points are drawn together or apart by a factor that is estimated.

use super::dry::{Dry, creep, static_force, stribeck_velocity};
use super::{positive, spread, spread_out};
use crate::Real;
use crate::law::{Act, Acting, Action, Site, Situation, Spec, take};

pub(crate) static SPEC: Spec = Spec {
    kind: "support_friction",
    effect: "coulomb_friction",
    summary: "dry friction under the whole body, shared by its support points",
    source: "Zhou, Paolini, Bagnell, Mason 2016; Goyal, Ruina, Papadopoulos 1991",
    acting: Acting::Object,
    dissipative: true,
    loads: false,
    inner: &[],
    params: &[
        positive("force", "N", 1e5, (10.0, 1.5), "sliding friction of the whole body"),
        spread(),
        static_force(),
        stribeck_velocity(),
        creep(),
    ],
    neutral: &[("force", 0.0)],
    sentence: "Dry friction of {force} acts under the whole body.",
    probe: "repeat one push slowly and fast: dry friction keeps its size, viscous friction grows with speed",
};

/// The law in place.
#[derive(Clone, Debug)]
pub struct SupportFriction<T> {
    /// Points, object frame, m, and their shares of the weight.
    support: Vec<([T; 2], f64)>,
    dry: Dry<T>,
}

impl<T: Real> Act<T> for SupportFriction<T> {
    const SAME_EVERYWHERE: bool = true;

    fn new(values: &[T], site: &Site<'_, T>) -> Self {
        let [force, spread, static_force, stribeck, creep] = take(values);
        Self { support: spread_out(site.body, spread), dry: Dry { force, static_force, stribeck, creep } }
    }

    #[inline]
    fn act(&self, at: &Situation<'_, T>, sum: &mut Action<T>) {
        for &(point, share) in &self.support {
            let c = self.dry.coefficient(at.velocity(point)) * share;
            sum.brake_at(point, c);
        }
    }
}
