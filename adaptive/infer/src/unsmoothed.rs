//! Missing wrench at each pose, without smoothing.
//!
//! A smoother suppresses oscillations above the bandwidth of the poses together with their noise. A search
//! for oscillations requires both: a spectral line is compared with the noise at its own frequency.

use crate::curve::Curve;
use crate::score::{InnerStates, inertial_wrench, sample_at};
use crate::{InferError, Residual};
use nalgebra::Matrix3;
use trundle_model::{Model, Plant, State, to_body};
use trundle_record::{Motion, Noise, PoseSample, Prepared, wrapped};

/// Missing wrench of an episode at every pose from contact on, object axes about the object origin.
/// Accelerations are second differences of the recorded poses. Poses and twists are smoothed, and the
/// covariances are zero.
///
/// # Errors
/// When `values` has the wrong length.
pub fn unsmoothed(
    model: &Model,
    values: &[f64],
    episode: &Prepared,
    noise: &Noise,
) -> Result<Vec<Residual>, InferError> {
    let plant = model.plant(values)?;
    let curve = Curve::new(episode);
    let mut inner_states = InnerStates::new(&plant, episode, &curve);
    let motion = episode.motion(noise);
    let at = motion.iter().skip(1).zip(episode.pose.windows(3)).filter(|(m, _)| m.t >= episode.contact);
    let one = |(motion, poses)| missing(&plant, (episode, &curve), motion, poses, &mut inner_states);
    Ok(at.filter_map(one).collect())
}

/// Missing wrench at the middle one of three poses.
fn missing(
    plant: &Plant<f64>,
    read: (&Prepared, &Curve),
    motion: &Motion,
    poses: &[PoseSample],
    inner_states: &mut InnerStates,
) -> Option<Residual> {
    let [before, at, after] = poses else { return None };
    // The interval extends half of the way to each of the neighbouring poses.
    let sample = sample_at(motion, read, plant, 0.25 * (after.t - before.t))?;
    let inner = inner_states.until(plant, &sample);
    let state = State::moving(sample.pose, sample.twist).with_inner(inner);
    let laws = plant.generalised_force(&state, sample.clock).wrench(to_body(sample.twist, sample.pose[2]));
    let inertia = inertial_wrench(plant, &sample, acceleration(before, at, after));
    let recorded = sample.recorded(plant);
    let wrench = [0, 1, 2].map(|k| inertia[k] - laws[k] - recorded[k]);
    let (t, pose, twist) = (sample.t, sample.pose, sample.twist);
    Some(Residual { t, pose, twist, wrench, covariance: Matrix3::zeros() })
}

/// Second divided difference of three poses, world axes.
fn acceleration(before: &PoseSample, at: &PoseSample, after: &PoseSample) -> [f64; 3] {
    let rate = |a: &PoseSample, b: &PoseSample| {
        let [dx, dy, turn] = [0, 1, 2].map(|k| b.pose[k] - a.pose[k]);
        [dx, dy, wrapped(turn)].map(|change| change / (b.t - a.t))
    };
    let (first, second) = (rate(before, at), rate(at, after));
    [0, 1, 2].map(|k| 2.0 * (second[k] - first[k]) / (after.t - before.t))
}

#[cfg(test)]
mod tests {
    use super::acceleration;
    use trundle_record::PoseSample;

    #[test]
    fn second_differences_of_uneven_poses_are_exact_on_parabolas() {
        let at = |t: f64| PoseSample { t, pose: [0.3 * t * t - t, 2.0, 3.0 + 0.5 * t * t] };
        let around =
            |t: f64| PoseSample { pose: [0.0, 0.0, 3.0 + 0.5 * t * t - std::f64::consts::TAU], ..at(t) };
        let found = acceleration(&at(0.1), &at(0.13), &at(0.2));
        for (value, expected) in found.iter().zip([0.6, 0.0, 1.0]) {
            assert!((value - expected).abs() < 1e-9, "{found:?}");
        }
        let turned = acceleration(&at(0.1), &at(0.13), &around(0.2));
        assert!((turned[2] - 1.0).abs() < 1e-9, "{turned:?}");
    }
}
