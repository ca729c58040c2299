//! A point mass on a body.

use super::law::{Applies, Scale, Spec, positive, signed};
use crate::units::Unit;

/// Its entry in the catalogue; `crate::common` has the formula, `crate::model` the starting values.
pub(crate) const SPEC: Spec = Spec {
    effect: "payload",
    summary: "a point mass on a body",
    source: "Atkeson, An and Hollerbach, Int. J. Robotics Research 1986",
    applies: Applies::Always,
    params: &[
        positive("mass", Unit::Mass, Scale::One),
        signed("com_x", Unit::Length, Scale::One),
        signed("com_y", Unit::Length, Scale::One),
        signed("com_z", Unit::Length, Scale::One),
    ],
    sentence: "A load of {mass} is attached to body {body} at ({com_x}, {com_y}, {com_z})",
    experiment: "hold the mechanism in several poses, then repeat them with a known load",
    starts: |_| vec![],
};
