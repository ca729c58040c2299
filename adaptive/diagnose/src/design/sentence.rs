//! A push as one would ask a person for it.

use super::bench::Bench;
use super::push::{Profile, Push};

/// The push in words, from standing the object up to letting it go.
pub(super) fn spoken(push: &Push, bench: &Bench) -> String {
    let standing = standing(push, bench);
    let [x, y] = push.grasp;
    let hold = if bench.on_rail() { String::new() } else { format!("Hold it at ({x:.2}, {y:.2}) m and ") };
    let action = action(push);
    let action = if hold.is_empty() { capital(&action) } else { format!("{hold}{action}") };
    format!("{standing}{action}.")
}

/// Where the object is to stand, where that is not where it stood.
fn standing(push: &Push, bench: &Bench) -> String {
    let ([x, y, heading], [was_x, was_y, was]) = (push.start, bench.stands);
    let moved = (x - was_x).hypot(y - was_y) > 0.05;
    let place =
        if moved { format!("stand it at ({x:.2}, {y:.2}) m, where it was before") } else { String::new() };
    let degrees = heading.to_degrees().rem_euclid(360.0).round() % 360.0;
    let turn = match push.quarters(was) {
        _ if bench.on_rail() => String::new(),
        Some(0) if bench.alike => String::new(),
        Some(1) if bench.alike => "turn it by a quarter to the left".to_owned(),
        Some(-1) if bench.alike => "turn it by a quarter to the right".to_owned(),
        Some(2) if bench.alike => "turn it round".to_owned(),
        _ => format!("turn it to a heading of {degrees:.0}° in the room"),
    };
    match (turn.is_empty(), place.is_empty()) {
        (true, true) => String::new(),
        (false, true) => format!("First {turn}. "),
        (true, false) => format!("First {place}. "),
        (false, false) => format!("First {turn} and {place}. "),
    }
}

fn action(push: &Push) -> String {
    let (along, force, torque) = (along(push.direction), rounded(push.force), rounded(push.torque));
    let seconds = |share: f64| rounded(share * push.duration);
    match push.profile {
        Profile::Steady => format!("push {along} with {force} N for {} s, then let go", seconds(0.55)),
        Profile::ThereAndBack => format!(
            "push {along} with {force} N for {} s, back for {} s, and forth again for {} s",
            seconds(0.25),
            seconds(0.5),
            seconds(0.25)
        ),
        Profile::Shuttle => format!(
            "push {along} with {force} N for {} s, back for {} s, and forth again for {} s, three times over",
            seconds(0.25 / 3.0),
            seconds(0.5 / 3.0),
            seconds(0.25 / 3.0)
        ),
        Profile::Pulses => format!(
            "push {along} with {force} N in pulses of {} s with rests of {} s: forth, back, back, forth",
            seconds(0.1),
            seconds(0.15)
        ),
        Profile::TwoFrequencies => format!(
            "push to and fro {along} with up to {force} N, at {} Hz and {} Hz at once, for {} s",
            rounded(1.0 / push.duration),
            rounded(9.0 / push.duration),
            seconds(1.0)
        ),
        Profile::Turn => format!(
            "turn it about there to the left with {torque} N·m for {} s, back for {} s, and to the left again for {} s",
            seconds(0.25),
            seconds(0.5),
            seconds(0.25)
        ),
        Profile::Weave => format!(
            "push to and fro {along} with {force} N at {} Hz while turning it with {torque} N·m at {} Hz, for {} s",
            rounded(2.0 / push.duration),
            rounded(4.0 / push.duration),
            seconds(1.0)
        ),
    }
}

/// A direction in the object's own axes.
fn along(direction: f64) -> String {
    let degrees = direction.to_degrees().round() as i32;
    match degrees.rem_euclid(360) {
        0 => "along its x".to_owned(),
        90 => "along its y".to_owned(),
        180 => "against its x".to_owned(),
        270 => "against its y".to_owned(),
        left @ 1..=179 => format!("{left}° to the left of its x"),
        right => format!("{}° to the right of its x", 360 - right),
    }
}

/// Two digits, without zeros behind.
pub(super) fn rounded(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return "0".to_owned();
    }
    let digits = (1.0 - value.abs().log10().floor()).clamp(0.0, 6.0) as usize;
    let text = format!("{value:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::bench::Limits;
    use trundle_model::Body;
    use trundle_record::Noise;

    const NOISE: Noise = Noise { pose: [5e-4; 3], force: 0.4, torque: 0.05, time: 0.0, stated: true };

    #[test]
    fn a_push_is_said_in_words() {
        let corners = [[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]];
        let body = Body::from_footprint(&corners, 22.0).unwrap();
        let bench = Bench { alike: true, ..Bench::bare(body, [true; 3], Limits::default(), NOISE) };
        let push = Push {
            grasp: [-0.6, 0.3],
            direction: 0.0,
            start: [0.0, 0.0, std::f64::consts::FRAC_PI_2],
            profile: Profile::ThereAndBack,
            force: 20.0,
            torque: 0.0,
            duration: 6.0,
        };
        let text = "First turn it by a quarter to the left. Hold it at (-0.60, 0.30) m and push along its x with 20 N \
                    for 1.5 s, back for 3 s, and forth again for 1.5 s.";
        assert_eq!(spoken(&push, &bench), text);
        let rail = Bench { dof: [true, false, false], ..bench };
        assert!(spoken(&Push { start: [0.0; 3], ..push }, &rail).starts_with("Push along its x with 20 N"));
    }

    #[test]
    fn directions_are_named_or_measured() {
        let named = [0.0, 90.0, 180.0, -90.0, 45.0, -30.0].map(|d: f64| along(d.to_radians()));
        let words = ["along its x", "along its y", "against its x", "against its y"];
        assert_eq!(named[..4], words);
        assert_eq!(named[4..], ["45° to the left of its x", "30° to the right of its x"]);
    }
}
