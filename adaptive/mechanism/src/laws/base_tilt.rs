//! Gravity turned about the world's axes.

use super::law::{Applies, ParamSpec, Scale, Spec, signed};
use crate::units::Unit;

/// Bounds of the angles, rad: a base is not upside down.
const MAX_ANGLE: [f64; 2] = [-1.5, 1.5];

/// Its entry in the catalogue; `crate::common` has the formula, `crate::model` the starting values.
pub(crate) const SPEC: Spec = Spec {
    effect: "base_tilt",
    summary: "a base that is not level",
    source: "Featherstone, Rigid Body Dynamics Algorithms, 2008",
    applies: Applies::Always,
    params: &[
        ParamSpec { bounds: MAX_ANGLE, ..signed("angle_x", Unit::Angle, Scale::One) },
        ParamSpec { bounds: MAX_ANGLE, ..signed("angle_y", Unit::Angle, Scale::One) },
    ],
    sentence: "The base is tilted by {angle_x} about x and {angle_y} about y",
    experiment: "hold the mechanism in several poses, and measure the base with a level",
    starts: |_| vec![],
};
