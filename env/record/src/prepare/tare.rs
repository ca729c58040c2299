//! Tare of raw readings. A raw reading contains the sensor's offset, which is constant in the sensor frame, and the
//! gripper's weight, which is constant in the world frame.

use nalgebra::{Rotation3, Vector3};

use super::transform::{GripperPose, Wrench6, force_moment_transform, join, split};

/// Method of taring raw readings.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum TareMethod {
    /// Subtract the offset in the sensor frame and the weight in the world frame.
    #[default]
    Separated,
    /// Equation 12 of the paper: transform the whole first reading with the gripper. Exact only if the offset is zero.
    Equation12,
}

/// Weight of the gripper, in the sensor frame.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Weight {
    /// Weight force: mass times gravity, N.
    pub force: f64,
    /// Weight force times the centre of mass, N m.
    pub moment: Vector3<f64>,
}

impl Weight {
    /// The wrench of the weight in the axes of a sensor at `pose`.
    pub fn wrench(&self, pose: &GripperPose) -> Wrench6 {
        let down = pose.down();
        join(&(down * self.force), &self.moment.cross(&down))
    }
}

/// A reading before contact, with the sign of the wrench on the object.
#[derive(Debug, Clone)]
pub(crate) struct UnloadedReading {
    pub wrench: Wrench6,
    pub pose: GripperPose,
}

/// Tare of an episode.
#[derive(Debug, Clone)]
pub(crate) enum Tare {
    /// Offset in the sensor frame, and the weight if it is known.
    Separated { offset: Wrench6, weight: Option<Weight> },
    /// Mean reading before contact, and the pose of the gripper then.
    Equation12 { first: Wrench6, pose: GripperPose },
}

impl Tare {
    /// The tare from the readings `unloaded` before contact; `None` if there are none.
    pub fn new(method: TareMethod, unloaded: &[UnloadedReading], weight: Option<&Weight>) -> Option<Self> {
        let pose = unloaded.first()?.pose.clone();
        Some(match method {
            TareMethod::Equation12 => {
                Self::Equation12 { first: mean(unloaded.iter().map(|r| r.wrench)), pose }
            }
            TareMethod::Separated => {
                let offset = mean(unloaded.iter().map(|r| unweighted(&r.wrench, &r.pose, weight)));
                Self::Separated { offset, weight: weight.cloned() }
            }
        })
    }

    /// The wrench on the object in sensor axes from `reading` at `pose`, with the sign of the wrench on the object.
    pub fn apply(&self, reading: &Wrench6, pose: &GripperPose) -> Wrench6 {
        match self {
            Self::Separated { offset, weight } => minus(&unweighted(reading, pose, weight.as_ref()), offset),
            Self::Equation12 { first, pose: start } => minus(reading, &transformed(first, start, pose)),
        }
    }
}

/// Equation 11 from the first gripper frame to the current one. Ignores the height difference of the two origins, which
/// does not affect the planar components of a weight.
fn transformed(first: &Wrench6, start: &GripperPose, now: &GripperPose) -> Wrench6 {
    let rotation: Rotation3<f64> = (now.attitude.inverse() * start.attitude).to_rotation_matrix();
    let [dx, dy] = [0, 1].map(|k| start.position[k] - now.position[k]);
    let position = now.attitude.inverse_transform_vector(&Vector3::new(dx, dy, 0.0));
    force_moment_transform(&rotation, &position, first)
}

/// The reading without the weight. In a reading with the sign of the wrench on the object, the weight is negative, because
/// it loads the sensor.
fn unweighted(reading: &Wrench6, pose: &GripperPose, weight: Option<&Weight>) -> Wrench6 {
    weight.map_or(*reading, |w| plus(reading, &w.wrench(pose)))
}

fn plus(a: &Wrench6, b: &Wrench6) -> Wrench6 {
    [0, 1, 2, 3, 4, 5].map(|k| a[k] + b[k])
}

fn minus(a: &Wrench6, b: &Wrench6) -> Wrench6 {
    [0, 1, 2, 3, 4, 5].map(|k| a[k] - b[k])
}

fn mean(wrenches: impl Iterator<Item = Wrench6>) -> Wrench6 {
    let (sum, n) = wrenches.fold(([0.0; 6], 0.0), |(sum, n), w| (plus(&sum, &w), n + 1.0));
    sum.map(|s| s / f64::max(n, 1.0))
}

/// Standard deviation of the mean of `values`, which may be autocorrelated; `None` for fewer than two. The autocovariance is
/// summed until it first falls below its own noise.
pub(crate) fn sd_of_mean(values: &[f64]) -> Option<f64> {
    let n = values.len();
    if n < 2 {
        return None;
    }
    let mean = values.iter().sum::<f64>() / n as f64;
    let deviations: Vec<f64> = values.iter().map(|v| v - mean).collect();
    let covariance =
        |lag: usize| deviations.iter().zip(&deviations[lag..]).map(|(a, b)| a * b).sum::<f64>() / n as f64;
    let variance = covariance(0);
    let noise = 2.0 * variance / (n as f64).sqrt();
    let correlated: f64 = (1..n / 3).map(covariance).take_while(|&c| c > noise).sum();
    Some(((variance + 2.0 * correlated) / (n - 1) as f64).sqrt())
}

/// Weight of the gripper from readings at several attitudes, one list per episode; `None` if the attitudes differ too
/// little. Each episode has its own offset if it has several attitudes; otherwise all episodes share one.
pub(crate) fn weigh(episodes: &[Vec<UnloadedReading>]) -> Option<Weight> {
    let pooled: Vec<UnloadedReading> = episodes.iter().flatten().cloned().collect();
    regress(episodes).or_else(|| regress(&[pooled]))
}

/// Minimum RMS angle between the attitudes and their mean for an estimate of the weight, rad.
const MIN_TILT_RMS_RAD: f64 = 0.05;

fn regress(groups: &[Vec<UnloadedReading>]) -> Option<Weight> {
    let (mut force, mut spread, mut n) = (0.0, 0.0, 0.0);
    let mut normal = nalgebra::Matrix3::zeros();
    let mut right = Vector3::zeros();
    for group in groups.iter().filter(|group| !group.is_empty()) {
        let center = mean(group.iter().map(|r| r.wrench));
        let down: Vector3<f64> =
            group.iter().map(|r| r.pose.down()).sum::<Vector3<f64>>() / group.len() as f64;
        for reading in group {
            let (f, torque) = split(&minus(&reading.wrench, &center));
            let change = reading.pose.down() - down;
            force -= f.dot(&change);
            spread += change.norm_squared();
            n += 1.0;
            let cross = change.cross_matrix(); // torque = -(m g c) × down = down × (m g c)
            normal += cross.transpose() * cross;
            right += cross.transpose() * torque;
        }
    }
    if n < 2.0 || (spread / n).sqrt() < MIN_TILT_RMS_RAD {
        return None;
    }
    // Rotation about a single axis leaves one component of the moment undetermined; take the minimum-norm solution.
    let inverse = normal.pseudo_inverse(1e-6 * normal.norm()).ok()?;
    Some(Weight { force: force / spread, moment: inverse * right })
}

#[cfg(test)]
mod tests;
