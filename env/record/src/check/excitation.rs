//! Checks of the excitation: force, motion, headings and accelerations.

use super::clocks::inertial_share;
use super::data::EpisodeData;
use super::finding::{Finding, Severity};
use super::input::CheckInput;
use crate::inertia::MAX_QUASI_STATIC_SHARE;

/// Minimum travel in standard deviations of the pose noise.
const MIN_TRAVEL_SD: f64 = 10.0;
/// Minimum range of headings that distinguishes a slope from a force bias, rad.
const MIN_HEADING_RANGE_RAD: f64 = 0.3;

/// Checks that force, motion, headings and accelerations suffice for a diagnosis.
pub(crate) fn excitation(input: &CheckInput) -> Vec<Finding> {
    if let Some(nothing) = no_force(input).or_else(|| no_motion(input)) {
        return vec![nothing];
    }
    [one_heading(input), quasi_static(input), end_poses(input)].into_iter().flatten().collect()
}

fn no_force(input: &CheckInput) -> Option<Finding> {
    let peak = input.data.peak_force();
    (peak <= 5.0 * input.data.dataset.noise.force).then(|| {
        Finding::new(
            "force",
            Severity::Error,
            format!(
                "no force exceeds the noise: the largest is {peak:.3} N, the noise {:.3} N",
                input.data.dataset.noise.force
            ),
            "record a push that exceeds the sensor noise, and check the unit of the force",
        )
    })
}

/// Largest distance from the first pose, in standard deviations of the noise.
fn travel(episode: &EpisodeData, sd: &[f64; 3]) -> f64 {
    let Some(first) = episode.prepared.pose.first() else { return 0.0 };
    let distance =
        |p: &[f64; 3]| (0..3).map(|k| (p[k] - first.pose[k]).abs() / sd[k].max(1e-9)).fold(0.0, f64::max);
    episode.prepared.pose.iter().map(|p| distance(&p.pose)).fold(0.0, f64::max)
}

fn no_motion(input: &CheckInput) -> Option<Finding> {
    let sd = &input.data.dataset.noise.pose;
    let most = input.data.episodes.iter().map(|episode| travel(episode, sd)).fold(0.0, f64::max);
    (most < MIN_TRAVEL_SD).then(|| {
        Finding::new(
            "motion",
            Severity::Error,
            format!("the object hardly moves: at most {most:.1} standard deviations of the tracker noise"),
            "push farther or harder: an object at rest only shows that friction exceeds the force",
        )
    })
}

fn one_heading(input: &CheckInput) -> Option<Finding> {
    if input.data.meta.on_rail() {
        return None; // the heading cannot vary
    }
    let headings = input.data.episodes.iter().flat_map(|episode| &episode.prepared.pose).map(|p| p.pose[2]);
    let (low, high) = headings.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    (high - low < MIN_HEADING_RANGE_RAD).then(|| {
        Finding::new(
            "headings",
            Severity::Note,
            format!(
                "the object's heading varies by only {:.2} rad: a floor slope and a force bias are not distinguishable",
                high - low
            ),
            "also record a push with the object rotated by 90° or more",
        )
    })
}

fn quasi_static(input: &CheckInput) -> Option<Finding> {
    let share = inertial_share(input)?;
    (share < MAX_QUASI_STATIC_SHARE).then(|| {
        Finding::new(
            "mass",
            Severity::Note,
            format!(
                "acceleration explains {:.2} % of the force: the pushes are quasi-static and hardly determine the mass",
                100.0 * share.max(0.0)
            ),
            "if the mass matters, weigh the object or push it faster",
        )
    })
}

fn end_poses(input: &CheckInput) -> Option<Finding> {
    let few = input.data.episodes.iter().filter(|episode| episode.motion.is_empty()).count();
    (few > 0).then(|| {
        Finding::new(
            "poses",
            Severity::Note,
            format!(
                "{few} of {} episodes have fewer than five poses: their velocity is not estimated",
                input.data.episodes.len()
            ),
            "track the object during the push if possible",
        )
    })
}
