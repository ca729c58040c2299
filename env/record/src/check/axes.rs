//! Checks of axes, signs, frames and handedness: is there a mistake whose correction lets a passive body explain the wrench?

use std::f64::consts::FRAC_PI_2;

use crate::metadata::{Contact, Frame, Reference, Sign};
use crate::prepare::wrapped;

use super::direction;
use super::dynamics::fit;
use super::finding::{Finding, Severity};
use super::input::CheckInput;
use super::wrench_fit::{MAX_SMALL_ROTATION_RAD, Mistake, WrenchFits, minimum};

/// Unexplained share up to which a passive body explains the wrench.
pub(crate) const MAX_UNEXPLAINED_SHARE: f64 = 0.3;
/// Minimum rotation of the force axes that is reported, rad.
const MIN_ROTATION_RAD: f64 = 0.09;
/// The same in its standard deviations.
const MIN_ROTATION_SD: f64 = 4.0;
/// Tolerance for multiples of a right angle, rad.
const RIGHT_ANGLE_TOLERANCE_RAD: f64 = 0.14;

/// Checks the sign of the wrench, and the orientation and handedness of its axes.
pub(crate) fn axes(input: &CheckInput) -> Vec<Finding> {
    let Some(fits) = &input.wrench_fits else { return direction::sign_and_axes(input) };
    if fits.best.fit.unexplained > MAX_UNEXPLAINED_SHARE {
        return direction::sign_and_axes(input);
    }
    let finding = match fits.best.mistake {
        Mistake::Rotation { angle, mirrored: false, reversed: false }
            if wrapped(angle).abs() < MAX_SMALL_ROTATION_RAD =>
        {
            small_rotation(fits, wrapped(angle))
        }
        Mistake::Rotation { angle, mirrored, reversed } => {
            rotation(input, fits, wrapped(angle), mirrored, reversed)
        }
        Mistake::Frame { frame, reference, negative } => Some(other_frame(fits, frame, reference, negative)),
        Mistake::Clockwise { mirrored } => Some(clockwise(fits, mirrored)),
        _ => None,
    };
    finding.into_iter().collect()
}

/// The unexplained shares before and after the correction, as text.
pub(crate) fn evidence(fits: &WrenchFits) -> String {
    format!(
        "a passive body leaves {:.1} % of the wrench unexplained as stated, and {:.1} % after correction",
        100.0 * fits.stated.fit.unexplained,
        100.0 * fits.best.fit.unexplained
    )
}

fn finding(kind: &'static str, fits: &WrenchFits, words: &str, remedy: &str) -> Finding {
    Finding::new(kind, Severity::Error, format!("{words}: {}", evidence(fits)), remedy)
}

/// A small rotation: the gripper is mounted or recorded at a wrong angle.
fn small_rotation(fits: &WrenchFits, angle: f64) -> Option<Finding> {
    if angle.abs() < MIN_ROTATION_RAD {
        return None;
    }
    let share = |equations: &_, angle: f64| {
        let correction = Mistake::Rotation { angle, mirrored: false, reversed: false }.correction();
        fit(equations, &correction, &fits.best.fit.terms).unexplained
    };
    let (angle, sd) =
        fits.jackknife(|equations| minimum(|a| share(equations, a), angle - 0.35, angle + 0.35));
    (angle.abs() > MIN_ROTATION_SD * sd).then(|| {
        let words = format!(
            "the force axes appear rotated by {:.1} ± {:.1}°",
            -angle.to_degrees(),
            sd.to_degrees()
        );
        let remedy = format!(
            "rotate the axes of the reading by {:.1}°: if it is in sensor axes, add {angle:.3} rad to gripper_theta (or \
             rotate the quaternion about the vertical)",
            angle.to_degrees()
        );
        Finding::new("axes", Severity::Warning, format!("{words}: {}", evidence(fits)), &remedy)
    })
}

fn rotation(
    input: &CheckInput,
    fits: &WrenchFits,
    angle: f64,
    mirrored: bool,
    reversed: bool,
) -> Option<Finding> {
    let quarter = (angle / FRAC_PI_2).round();
    let right = (angle - quarter * FRAC_PI_2).abs() < RIGHT_ANGLE_TOLERANCE_RAD;
    let quarter = quarter.rem_euclid(4.0) as i32;
    Some(match (mirrored, reversed, right, quarter) {
        (false, true, true, 2) => wrong_sign(input, fits),
        (false, false, true, 2) if input.data.meta.wrench.contact == Contact::Point => {
            wrong_sign(input, fits)
        }
        (false, true, true, 0) => finding(
            "sign",
            fits,
            "torque_z appears to have the wrong sign",
            "negate torque_z, or negate object_theta and gripper_theta if these count clockwise",
        ),
        (true, false, true, 0) => axis_reversed(fits, "force_y"),
        (true, false, true, 2) => axis_reversed(fits, "force_x"),
        (true, false, true, _) => finding(
            "axes",
            fits,
            "force_x and force_y appear swapped",
            "swap force_x and force_y, and check the axes of the sensor frame",
        ),
        (true, true, _, _) => left_handed(fits, angle, right),
        (true, false, ..) | (false, true, ..) => finding(
            "axes",
            fits,
            &format!("the force axes appear mirrored or rotated by {:.0}°", -angle.to_degrees()),
            "check each axis of the sensor frame, and the sign of torque_z",
        ),
        (false, false, ..) => {
            let words = format!("the force axes appear rotated by {:.0}°", -angle.to_degrees());
            let remedy = format!(
                "check the orientation of the sensor frame: add {angle:.3} rad to gripper_theta, or rotate the \
                 quaternion about the vertical"
            );
            finding("axes", fits, &words, &remedy)
        }
    })
}

fn axis_reversed(fits: &WrenchFits, axis: &str) -> Finding {
    let words = format!("only {axis} appears to have the wrong sign, which makes the axes left-handed");
    let remedy = format!("negate {axis}: all frames must be right-handed with z up");
    finding("axes", fits, &words, &remedy)
}

fn left_handed(fits: &WrenchFits, angle: f64, right: bool) -> Finding {
    let words = if right {
        "wrench and poses appear to differ in handedness: one of them is left-handed, or its z axis points down"
            .into()
    } else {
        format!(
            "wrench and poses appear to differ in handedness, and the axes appear rotated by {:.0}°",
            -angle.to_degrees()
        )
    };
    let remedy = "if the poses are left-handed, negate y and theta of object, gripper and footprint; if the z axis of \
                  the sensor points down, negate force_y and torque_z (or force_x and torque_z)";
    finding("axes", fits, &words, remedy)
}

fn wrong_sign(input: &CheckInput, fits: &WrenchFits) -> Finding {
    let (stated, other) = match input.data.meta.wrench.sign {
        Sign::OnObject => ("on_object", "on_sensor"),
        Sign::OnSensor => ("on_sensor", "on_object"),
    };
    let remedy = format!(
        "set wrench.sign = \"{other}\" instead of \"{stated}\", or rotate the sensor frame by 180° if it is mounted that way"
    );
    finding("sign", fits, "the force appears to act in the wrong direction", &remedy)
}

fn other_frame(fits: &WrenchFits, frame: Frame, reference: Reference, negative: bool) -> Finding {
    let frame = match frame {
        Frame::Sensor => "sensor",
        Frame::Object => "object",
        Frame::World => "world",
    };
    let reference = match reference {
        Reference::Sensor => "sensor",
        Reference::Object => "object",
    };
    let words = format!("the wrench appears to be in {frame} axes about the origin of the {reference} frame");
    let sign = if negative { ", and change wrench.sign" } else { "" };
    let remedy = format!("set wrench.frame = \"{frame}\" and wrench.reference = \"{reference}\"{sign}");
    // The statement is certainly wrong only if no passive body explains the wrench as stated.
    let is_certain = fits.stated.fit.unexplained > MAX_UNEXPLAINED_SHARE;
    let severity = if is_certain { Severity::Error } else { Severity::Warning };
    Finding::new("axes", severity, format!("{words}: {}", evidence(fits)), &remedy)
}

fn clockwise(fits: &WrenchFits, mirrored: bool) -> Finding {
    let (words, remedy) = if mirrored {
        (
            "the poses appear left-handed: either x or y is reversed, but theta is not",
            "negate object_y and gripper_y (or object_x and gripper_x): all frames must be right-handed with z up",
        )
    } else {
        (
            "the angles appear to count clockwise",
            "negate object_theta and gripper_theta: angles must count counter-clockwise seen from above",
        )
    };
    finding("axes", fits, words, remedy)
}
