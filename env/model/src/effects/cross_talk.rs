//! A force-torque sensor whose axes read some of one another: a wrong calibration matrix, a sensor mounted at an angle
//! or beside the point that it reports its torque about.
//!
//! ```text
//! reading = (I + L) truth,   L: zero diagonal,   sensor axes
//! ```
//! A sensor turned by a small angle `a` has `L_xy = −L_yx = a`; one whose torque is about a point `p` beside its
//! reference has `L_tx = −p_y`, `L_ty = p_x`.

use super::signed;
use crate::Real;
use crate::law::{Clock, EffectLaw, EffectTarget, LawSetup, Param, Spec, take};

/// What one force axis reads of the other.
const fn of_force(name: &'static str, help: &'static str) -> Param {
    signed(name, "1", 2.0, 0.15, help).planar()
}

/// What a force axis reads of the torque.
const fn of_torque(name: &'static str, help: &'static str) -> Param {
    signed(name, "1/m", 20.0, 0.5, help).planar()
}

/// What the torque axis reads of a force.
const fn torque_of(name: &'static str, help: &'static str) -> Param {
    signed(name, "m", 2.0, 0.1, help).planar()
}

pub(crate) static SPEC: Spec = Spec {
    kind: "cross_talk",
    effect: "cross_talk",
    summary: "each axis of the force-torque sensor reads some of the others",
    source: "calibration matrix of a multi-axis sensor: Bicchi 1992, off-diagonal terms",
    target: EffectTarget::Instrument,
    is_dissipative: false,
    changes_mass: false,
    inner_states: &[],
    params: &[
        of_force("x_from_y", "of force_y in the reading of force_x"),
        of_torque("x_from_torque", "of torque_z in the reading of force_x"),
        of_force("y_from_x", "of force_x in the reading of force_y"),
        of_torque("y_from_torque", "of torque_z in the reading of force_y"),
        torque_of("torque_from_x", "of force_x in the reading of torque_z"),
        torque_of("torque_from_y", "of force_y in the reading of torque_z"),
    ],
    neutral: &[
        ("x_from_y", 0.0),
        ("x_from_torque", 0.0),
        ("y_from_x", 0.0),
        ("y_from_torque", 0.0),
        ("torque_from_x", 0.0),
        ("torque_from_y", 0.0),
    ],
    sentence: "The force sensor's axes are mixed: force_x reads {x_from_y} of force_y and {x_from_torque} of torque_z, \
               force_y {y_from_x} of force_x and {y_from_torque} of torque_z, torque_z {torque_from_x} of force_x and \
               {torque_from_y} of force_y.",
    suggested_push: "push along one axis of the sensor at a time, through the object's mass centre: the other axes should read \
            nothing",
};

/// The law in place.
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
