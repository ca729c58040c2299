//! Offset of an encoder: measured = true + offset.

use super::law::{Applies, Scale, Spec, signed};
use crate::units::Unit;

/// Its entry in the catalogue; `crate::common` has the formula, `crate::model` the starting values.
pub(crate) const SPEC: Spec = Spec {
    effect: "encoder_offset",
    summary: "offset of an encoder",
    source: "Hollerbach and Wampler, Int. J. Robotics Research 1996",
    applies: Applies::Always,
    params: &[signed("offset", Unit::Position, Scale::Position)],
    sentence: "The encoder of joint {joint} is off by {offset}",
    experiment: "move the joint to its mechanical reference, or hold it in several poses under gravity",
    starts: |_| vec![],
};
