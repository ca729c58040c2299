//! Axes, signs, frames and handedness: mistakes that, undone, let a passive body explain the wrench.

use std::f64::consts::FRAC_PI_2;

use crate::metadata::{Contact, Frame, Reference, Sign};
use crate::prepare::wrapped;

use super::direction;
use super::dynamics::fit;
use super::explain::{Explained, Mistake, SLIGHT, minimum};
use super::subject::Subject;
use super::{Finding, Severity};

/// Unexplained share below which a passive body explains the wrench.
pub(crate) const EXPLAINS: f64 = 0.3;
/// Least angle of the gripper, rad, and its least number of standard deviations.
const TURNED: (f64, f64) = (0.09, 4.0);
/// An angle so near to a multiple of a right angle is one, rad.
const RIGHT: f64 = 0.14;

/// Sign of the wrench, orientation and handedness of its axes.
pub(crate) fn axes(subject: &Subject) -> Vec<Finding> {
    let Some(explained) = &subject.explained else { return direction::sign_and_axes(subject) };
    if explained.best.fit.share > EXPLAINS {
        return direction::sign_and_axes(subject);
    }
    let finding = match explained.best.mistake {
        Mistake::Turned { angle, mirrored: false, reversed: false } if wrapped(angle).abs() < SLIGHT => {
            turned_a_little(explained, wrapped(angle))
        }
        Mistake::Turned { angle, mirrored, reversed } => {
            turned(subject, explained, wrapped(angle), mirrored, reversed)
        }
        Mistake::Frame { frame, reference, negative } => Some(framed(explained, frame, reference, negative)),
        Mistake::Clockwise { mirrored } => Some(clockwise(explained, mirrored)),
        _ => None,
    };
    finding.into_iter().collect()
}

/// What is unexplained before and after, in words.
pub(crate) fn evidence(explained: &Explained) -> String {
    format!(
        "{:.1} % of the load fits no passive body, {:.1} % once this is undone",
        100.0 * explained.stated.fit.share,
        100.0 * explained.best.fit.share
    )
}

fn finding(kind: &'static str, explained: &Explained, words: &str, remedy: &str) -> Finding {
    Finding::new(kind, Severity::Error, format!("{words}: {}", evidence(explained)), remedy)
}

/// A gripper that is mounted, or recorded, at a wrong angle.
fn turned_a_little(explained: &Explained, angle: f64) -> Option<Finding> {
    if angle.abs() < TURNED.0 {
        return None;
    }
    let share = |moments: &_, angle: f64| {
        let change = Mistake::Turned { angle, mirrored: false, reversed: false }.change();
        fit(moments, &change, &explained.best.fit.terms).share
    };
    let (angle, sd) =
        explained.jackknife(|moments| minimum(|a| share(moments, a), angle - 0.35, angle + 0.35));
    (angle.abs() > TURNED.1 * sd).then(|| {
        let words = format!(
            "the force's axes seem turned by {:.1} ± {:.1}°",
            -angle.to_degrees(),
            sd.to_degrees()
        );
        let remedy = format!(
            "turn the axes of the reading by {:.1}°: add {angle:.3} rad to gripper_theta (or turn the quaternion \
             about the vertical) if the reading is in sensor axes",
            angle.to_degrees()
        );
        Finding::new("axes", Severity::Warning, format!("{words}: {}", evidence(explained)), &remedy)
    })
}

fn turned(
    subject: &Subject,
    explained: &Explained,
    angle: f64,
    mirrored: bool,
    reversed: bool,
) -> Option<Finding> {
    let quarter = (angle / FRAC_PI_2).round();
    let right = (angle - quarter * FRAC_PI_2).abs() < RIGHT;
    let quarter = quarter.rem_euclid(4.0) as i32;
    Some(match (mirrored, reversed, right, quarter) {
        (false, true, true, 2) => wrong_sign(subject, explained),
        (false, false, true, 2) if subject.meta.wrench.contact == Contact::Point => {
            wrong_sign(subject, explained)
        }
        (false, true, true, 0) => finding(
            "sign",
            explained,
            "torque_z seems to have the wrong sign",
            "negate torque_z, or object_theta and gripper_theta if these count clockwise",
        ),
        (true, false, true, 0) => axis_reversed(explained, "force_y"),
        (true, false, true, 2) => axis_reversed(explained, "force_x"),
        (true, false, true, _) => finding(
            "axes",
            explained,
            "force_x and force_y seem exchanged",
            "exchange force_x and force_y, and check the axes of the sensor's frame",
        ),
        (true, true, _, _) => left_handed(explained, angle, right),
        (true, false, ..) | (false, true, ..) => finding(
            "axes",
            explained,
            &format!("the force's axes seem mirrored or turned by {:.0}°", -angle.to_degrees()),
            "check each axis of the sensor's frame, and the sign of torque_z",
        ),
        (false, false, ..) => {
            let words = format!("the force's axes seem turned by {:.0}°", -angle.to_degrees());
            let remedy = format!(
                "check the sensor frame against the gripper's pose: add {angle:.3} rad to gripper_theta, or turn \
                 the quaternion about the vertical"
            );
            finding("axes", explained, &words, &remedy)
        }
    })
}

fn axis_reversed(explained: &Explained, axis: &str) -> Finding {
    let words = format!("{axis} alone seems to have the wrong sign (axes of the other handedness)");
    let remedy = format!("negate {axis}: the frames of the format are right-handed with z up");
    finding("axes", explained, &words, &remedy)
}

fn left_handed(explained: &Explained, angle: f64, right: bool) -> Finding {
    let words = if right {
        "wrench and poses seem to differ in handedness: one of them is left-handed, or its z axis points down"
            .into()
    } else {
        format!(
            "wrench and poses seem to differ in handedness, with axes turned by {:.0}°",
            -angle.to_degrees()
        )
    };
    let remedy = "if the poses are left-handed, negate y and theta of object, gripper and footprint; if the sensor \
                  hangs with its z down, negate force_y and torque_z (or force_x and torque_z)";
    finding("axes", explained, &words, remedy)
}

fn wrong_sign(subject: &Subject, explained: &Explained) -> Finding {
    let (given, other) = match subject.meta.wrench.sign {
        Sign::OnObject => ("on_object", "on_sensor"),
        Sign::OnSensor => ("on_sensor", "on_object"),
    };
    let remedy = format!(
        "set wrench.sign = \"{other}\" instead of \"{given}\", or turn the sensor frame by 180° if it hangs the other way"
    );
    finding("sign", explained, "the force seems to act in the wrong direction", &remedy)
}

fn framed(explained: &Explained, frame: Frame, reference: Reference, negative: bool) -> Finding {
    let frame = match frame {
        Frame::Sensor => "sensor",
        Frame::Object => "object",
        Frame::World => "world",
    };
    let reference = match reference {
        Reference::Sensor => "sensor",
        Reference::Object => "object",
    };
    let words = format!("the reading seems to be in {frame} axes about the origin of the {reference} frame");
    let sign = if negative { ", and the other wrench.sign" } else { "" };
    let remedy = format!("set wrench.frame = \"{frame}\" and wrench.reference = \"{reference}\"{sign}");
    // Surely wrong only where no passive body explains the reading as stated.
    let sure = explained.stated.fit.share > EXPLAINS;
    let severity = if sure { Severity::Error } else { Severity::Warning };
    Finding::new("axes", severity, format!("{words}: {}", evidence(explained)), &remedy)
}

fn clockwise(explained: &Explained, mirrored: bool) -> Finding {
    let (words, remedy) = if mirrored {
        (
            "the poses seem left-handed: one of x and y is reversed while theta is not",
            "negate object_y and gripper_y (or both x) so that frames are right-handed with z up",
        )
    } else {
        (
            "the angles seem to count clockwise",
            "negate object_theta and gripper_theta: angles count counter-clockwise seen from above",
        )
    };
    finding("axes", explained, words, remedy)
}
