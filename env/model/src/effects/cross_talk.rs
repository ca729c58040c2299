//! Crosstalk between the axes of a force-torque sensor: a wrong calibration matrix, or a sensor that is mounted at an
//! angle or away from its torque reference point.
//!
//! ```text
//! reading = (I + L) truth,   L: zero diagonal,   sensor axes
//! ```
//! A sensor rotated by a small angle `a` has `L_xy = −L_yx = a`. A sensor whose torque is about a point `p` instead of
//! its reference point has `L_tx = −p_y`, `L_ty = p_x`.

use super::signed;
use crate::Real;
use crate::law::{Clock, EffectLaw, EffectTarget, LawSetup, Param, Spec, take};

/// Crosstalk from one force axis to the other.
const fn of_force(name: &'static str, help: &'static str) -> Param {
    signed(name, "1", 2.0, 0.15, help).planar()
}

/// Crosstalk from the torque to a force axis.
const fn of_torque(name: &'static str, help: &'static str) -> Param {
    signed(name, "1/m", 20.0, 0.5, help).planar()
}

/// Crosstalk from a force axis to the torque.
const fn torque_of(name: &'static str, help: &'static str) -> Param {
    signed(name, "m", 2.0, 0.1, help).planar()
}

pub(crate) static SPEC: Spec = Spec {
    kind: "cross_talk",
    effect: "cross_talk",
    summary: "crosstalk between the axes of the force-torque sensor",
    source: "calibration matrix of a multi-axis sensor: Bicchi 1992, off-diagonal terms",
    target: EffectTarget::Instrument,
    is_dissipative: false,
    changes_mass: false,
    inner_states: &[],
    params: &[
        of_force("x_from_y", "share of force_y in the reading of force_x"),
        of_torque("x_from_torque", "share of torque_z in the reading of force_x"),
        of_force("y_from_x", "share of force_x in the reading of force_y"),
        of_torque("y_from_torque", "share of torque_z in the reading of force_y"),
        torque_of("torque_from_x", "share of force_x in the reading of torque_z"),
        torque_of("torque_from_y", "share of force_y in the reading of torque_z"),
    ],
    neutral: &[
        ("x_from_y", 0.0),
        ("x_from_torque", 0.0),
        ("y_from_x", 0.0),
        ("y_from_torque", 0.0),
        ("torque_from_x", 0.0),
        ("torque_from_y", 0.0),
    ],
    sentence: "The axes of the force sensor have crosstalk: force_x contains {x_from_y} of force_y and {x_from_torque} \
        of torque_z, force_y contains {y_from_x} of force_x and {y_from_torque} of torque_z, and torque_z contains \
        {torque_from_x} of force_x and {torque_from_y} of force_y.",
    suggested_push: "push along one axis of the sensor at a time, through the mass centre of the object: the other \
        axes should read zero",
};

/// Law with its parameters.
#[derive(Clone, Debug)]
pub struct CrossTalk<T> {
    /// The inverse of `I + L`.
    inverse: [[T; 3]; 3],
}

impl<T: Real> EffectLaw<T> for CrossTalk<T> {
    const IS_POSE_INVARIANT: bool = true;

    fn new(values: &[T], _site: &LawSetup<'_, T>) -> Self {
        let [xy, xt, yx, yt, tx, ty] = take(values);
        let one = T::lift(1.0);
        let adjugate = [
            [one - yt * ty, xt * ty - xy, xy * yt - xt],
            [yt * tx - yx, one - xt * tx, xt * yx - yt],
            [yx * ty - tx, xy * tx - ty, one - xy * yx],
        ];
        let determinant = adjugate[0][0] + xy * adjugate[1][0] + xt * adjugate[2][0];
        let over = determinant.recip();
        Self { inverse: adjugate.map(|row| row.map(|entry| entry * over)) }
    }

    #[inline]
    fn correct(&self, [x, y, torque]: [T; 3], _clock: Clock) -> [T; 3] {
        self.inverse.map(|[a, b, c]| a * x + b * y + c * torque)
    }
}
