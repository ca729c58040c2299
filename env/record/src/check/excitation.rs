//! Whether there is enough force, motion and variety to learn from.

use super::clocks::inertial_share;
use super::subject::{Look, Subject};
use super::{Finding, Severity};

/// Travel in standard deviations of the pose noise below which nothing moved.
const STILL: f64 = 10.0;
/// Headings that vary by less, rad, leave slope and force bias tied.
const ONE_HEADING: f64 = 0.3;
/// Share of the force that acceleration must explain beside velocity and its direction.
const QUASI_STATIC: f64 = 0.01;

/// Force, motion, headings, accelerations.
pub(crate) fn enough(subject: &Subject) -> Vec<Finding> {
    if let Some(nothing) = no_force(subject).or_else(|| no_motion(subject)) {
        return vec![nothing];
    }
    [one_heading(subject), quasi_static(subject), end_poses(subject)].into_iter().flatten().collect()
}

fn no_force(subject: &Subject) -> Option<Finding> {
    let peak = subject.peak_force();
    (peak <= 5.0 * subject.dataset.noise.force).then(|| {
        Finding::new(
            "force",
            Severity::Error,
            format!(
                "no force stands out: the largest is {peak:.3} N, its noise {:.3} N",
                subject.dataset.noise.force
            ),
            "record a push that the sensor can feel, and check the unit of the force",
        )
    })
}

/// Largest distance from the first pose, in standard deviations of the noise.
fn travel(look: &Look, sd: &[f64; 3]) -> f64 {
    let Some(first) = look.prepared.pose.first() else { return 0.0 };
    let off =
        |p: &[f64; 3]| (0..3).map(|k| (p[k] - first.pose[k]).abs() / sd[k].max(1e-9)).fold(0.0, f64::max);
    look.prepared.pose.iter().map(|p| off(&p.pose)).fold(0.0, f64::max)
}

fn no_motion(subject: &Subject) -> Option<Finding> {
    let sd = &subject.dataset.noise.pose;
    let most = subject.episodes.iter().map(|look| travel(look, sd)).fold(0.0, f64::max);
    (most < STILL).then(|| {
        Finding::new(
            "motion",
            Severity::Error,
            format!("the object hardly moves: at most {most:.1} standard deviations of its tracker's noise"),
            "push further, or harder: an object at rest shows only that friction holds it",
        )
    })
}

fn one_heading(subject: &Subject) -> Option<Finding> {
    if subject.meta.on_rail() {
        return None; // there it cannot vary
    }
    let headings = subject.episodes.iter().flat_map(|look| &look.prepared.pose).map(|p| p.pose[2]);
    let (low, high) = headings.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    (high - low < ONE_HEADING).then(|| {
        Finding::new(
            "headings",
            Severity::Note,
            format!(
                "the object's heading varies by {:.2} rad only: a floor slope and a force bias look alike",
                high - low
            ),
            "record a push with the object turned by a quarter or more",
        )
    })
}

fn quasi_static(subject: &Subject) -> Option<Finding> {
    let share = inertial_share(subject)?;
    (share < QUASI_STATIC).then(|| {
        Finding::new(
            "mass",
            Severity::Note,
            format!(
                "acceleration explains {:.2} % of the force: the pushes are quasi-static and hardly hold the mass",
                100.0 * share.max(0.0)
            ),
            "if the mass matters, weigh the object or push it faster",
        )
    })
}

fn end_poses(subject: &Subject) -> Option<Finding> {
    let few = subject.episodes.iter().filter(|look| look.motion.is_empty()).count();
    (few > 0).then(|| {
        Finding::new(
            "poses",
            Severity::Note,
            format!(
                "{few} of {} episodes hold fewer than five poses: no velocity is estimated there",
                subject.episodes.len()
            ),
            "track the object during the push where you can",
        )
    })
}
