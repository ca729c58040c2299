//! Instructions for a push in words.

use super::push::{Profile, Push};
use super::setup::Setup;

/// Instructions for a push, from placing the object to releasing it.
pub(super) fn instructions(push: &Push, setup: &Setup) -> String {
    let placement = placement(push, setup);
    let [x, y] = push.grasp;
    if setup.on_rail() {
        return format!("{placement}{}.", capitalised(&action(push, "the object")));
    }
    format!("{placement}Grasp the object at ({x:.2}, {y:.2}) m (object frame) and {}.", action(push, "it"))
}

/// Instructions to place the object, if its start pose differs from the recorded ones.
fn placement(push: &Push, setup: &Setup) -> String {
    let ([x, y, heading], [usual_x, usual_y, usual_heading]) = (push.start, setup.start_pose);
    let is_moved = (x - usual_x).hypot(y - usual_y) > 0.05;
    let place = if is_moved { format!("at ({x:.2}, {y:.2}) m (world frame)") } else { String::new() };
    let degrees = heading.to_degrees().rem_euclid(360.0).round() % 360.0;
    let turn = match push.quarter_turns(usual_heading) {
        _ if setup.on_rail() => String::new(),
        Some(0) if setup.has_common_heading => String::new(),
        Some(1) if setup.has_common_heading => "rotate the object by 90° to the left".to_owned(),
        Some(-1) if setup.has_common_heading => "rotate the object by 90° to the right".to_owned(),
        Some(2) if setup.has_common_heading => "rotate the object by 180°".to_owned(),
        _ => format!("rotate the object to a heading of {degrees:.0}° (world frame)"),
    };
    match (turn.is_empty(), place.is_empty()) {
        (true, true) => String::new(),
        (false, true) => format!("First {turn}. "),
        (true, false) => format!("First place the object {place}. "),
        (false, false) => format!("First {turn} and place it {place}. "),
    }
}

/// The motion of the gripper in words; `object` names the object.
fn action(push: &Push, object: &str) -> String {
    let (along, force, torque) =
        (direction_in_words(push.direction), rounded(push.force), rounded(push.torque));
    let seconds = |share: f64| rounded(share * push.duration);
    match push.profile {
        Profile::Steady => {
            format!("push {object} {along} with {force} N for {} s, then release it", seconds(0.55))
        }
        Profile::ThereAndBack => format!(
            "push {object} {along} with {force} N for {} s, backwards for {} s, and forwards for {} s",
            seconds(0.25),
            seconds(0.5),
            seconds(0.25)
        ),
        Profile::Shuttle => format!(
            "push {object} {along} with {force} N for {} s, backwards for {} s, and forwards for {} s, three times in a row",
            seconds(0.25 / 3.0),
            seconds(0.5 / 3.0),
            seconds(0.25 / 3.0)
        ),
        Profile::Pulses => format!(
            "push {object} {along} with {force} N in pulses of {} s with pauses of {} s: forwards, backwards, \
             backwards, forwards",
            seconds(0.1),
            seconds(0.15)
        ),
        Profile::TwoFrequencies => format!(
            "push {object} back and forth {along} with up to {force} N, at {} Hz and {} Hz at once, for {} s",
            rounded(1.0 / push.duration),
            rounded(9.0 / push.duration),
            seconds(1.0)
        ),
        Profile::Turn => format!(
            "rotate {object} about the grasp to the left with {torque} N·m for {} s, to the right for {} s, and to the \
             left for {} s",
            seconds(0.25),
            seconds(0.5),
            seconds(0.25)
        ),
        Profile::Weave => format!(
            "push {object} back and forth {along} with {force} N at {} Hz while rotating it with {torque} N·m at {} Hz, \
             for {} s",
            rounded(2.0 / push.duration),
            rounded(4.0 / push.duration),
            seconds(1.0)
        ),
    }
}

/// A direction in the axes of the object.
fn direction_in_words(direction: f64) -> String {
    let degrees = direction.to_degrees().round() as i32;
    match degrees.rem_euclid(360) {
        0 => "along its x axis".to_owned(),
        90 => "along its y axis".to_owned(),
        180 => "against its x axis".to_owned(),
        270 => "against its y axis".to_owned(),
        left @ 1..=179 => format!("{left}° to the left of its x axis"),
        right => format!("{}° to the right of its x axis", 360 - right),
    }
}

/// A number with two significant digits, without trailing zeros.
pub(super) fn rounded(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return "0".to_owned();
    }
    let digits = (1.0 - value.abs().log10().floor()).clamp(0.0, 6.0) as usize;
    let text = format!("{value:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::setup::Limits;
    use trundle_model::Body;
    use trundle_record::Noise;

    const NOISE: Noise = Noise { pose: [5e-4; 3], force: 0.4, torque: 0.05, time: 0.0, stated: true };

    #[test]
    fn instructions_describe_a_push() {
        let corners = [[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]];
        let body = Body::from_footprint(&corners, 22.0).unwrap();
        let setup = Setup {
            has_common_heading: true,
            ..Setup::without_recording(body, [true; 3], Limits::default(), NOISE)
        };
        let push = Push {
            grasp: [-0.6, 0.3],
            direction: 0.0,
            start: [0.0, 0.0, std::f64::consts::FRAC_PI_2],
            profile: Profile::ThereAndBack,
            force: 20.0,
            torque: 0.0,
            duration: 6.0,
        };
        let text = "First rotate the object by 90° to the left. Grasp the object at (-0.60, 0.30) m (object frame) and push \
                    it along its x axis with 20 N for 1.5 s, backwards for 3 s, and forwards for 1.5 s.";
        assert_eq!(instructions(&push, &setup), text);
        let rail = Setup { dof: [true, false, false], ..setup };
        assert!(
            instructions(&Push { start: [0.0; 3], ..push }, &rail)
                .starts_with("Push the object along its x axis with 20 N")
        );
    }

    #[test]
    fn directions_are_axes_or_angles() {
        let named = [0.0, 90.0, 180.0, -90.0, 45.0, -30.0].map(|d: f64| direction_in_words(d.to_radians()));
        let words = ["along its x axis", "along its y axis", "against its x axis", "against its y axis"];
        assert_eq!(named[..4], words);
        assert_eq!(named[4..], ["45° to the left of its x axis", "30° to the right of its x axis"]);
    }
}
