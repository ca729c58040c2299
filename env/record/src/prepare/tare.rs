//! What a raw reading holds besides the push: the sensor's offset, constant in the sensor frame, and the
//! gripper's weight, constant in the world.

use nalgebra::{Rotation3, Vector3};

use super::transform::{GripperPose, Wrench6, force_moment_transform, join, split};

/// Acceleration of gravity, m/s².
pub(crate) const GRAVITY: f64 = 9.80665;

/// How a raw reading is tared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum TareMethod {
    /// Offset and weight each where they are constant: in the sensor frame and in the world.
    #[default]
    Separated,
    /// Equation 12 of the paper: the whole first reading turns with the gripper. Right where the offset is zero.
    Equation12,
}

/// What the gripper weighs, in the sensor frame.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Weight {
    /// Mass times gravity, N.
    pub force: f64,
    /// The same times the mass centre, N m.
    pub moment: Vector3<f64>,
}

impl Weight {
    /// The wrench of the weight in the axes of a sensor at `pose`.
    pub fn wrench(&self, pose: &GripperPose) -> Wrench6 {
        let down = pose.down();
        join(&(down * self.force), &self.moment.cross(&down))
    }
}

/// One reading before contact, sign as on the object.
#[derive(Debug, Clone)]
pub(crate) struct FreeReading {
    pub wrench: Wrench6,
    pub pose: GripperPose,
}

/// What is subtracted from an episode's readings.
#[derive(Debug, Clone)]
pub(crate) enum Tare {
    /// Offset in the sensor frame, and the weight where it is known.
    Separated { offset: Wrench6, weight: Option<Weight> },
    /// Mean reading before contact and where the gripper was then.
    Equation12 { first: Wrench6, pose: GripperPose },
}

impl Tare {
    /// The tare from an episode's readings before contact; `None` if there are none.
    pub fn new(method: TareMethod, free: &[FreeReading], weight: Option<&Weight>) -> Option<Self> {
        let pose = free.first()?.pose.clone();
        Some(match method {
            TareMethod::Equation12 => Self::Equation12 { first: mean(free.iter().map(|r| r.wrench)), pose },
            TareMethod::Separated => {
                let offset = mean(free.iter().map(|r| unweighted(&r.wrench, &r.pose, weight)));
                Self::Separated { offset, weight: weight.cloned() }
            }
        })
    }

    /// The wrench on the object in sensor axes, from a reading taken at `pose`, sign as on the object.
    pub fn apply(&self, reading: &Wrench6, pose: &GripperPose) -> Wrench6 {
        match self {
            Self::Separated { offset, weight } => minus(&unweighted(reading, pose, weight.as_ref()), offset),
            Self::Equation12 { first, pose: start } => minus(reading, &turned(first, start, pose)),
        }
    }
}

/// Equation 11 from the first gripper frame to the present one. Heights are left out: both origins are taken to
/// lie in one level plane, which changes no planar component of a weight.
fn turned(first: &Wrench6, start: &GripperPose, now: &GripperPose) -> Wrench6 {
    let rotation: Rotation3<f64> = (now.attitude.inverse() * start.attitude).to_rotation_matrix();
    let [dx, dy] = [0, 1].map(|k| start.position[k] - now.position[k]);
    let position = now.attitude.inverse_transform_vector(&Vector3::new(dx, dy, 0.0));
    force_moment_transform(&rotation, &position, first)
}

/// The reading without the weight: the reaction on the object is what is left of the sensor's load, so a weight
/// enters a reading of that sign negatively.
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

/// Standard deviation of the mean of `values`, which may be correlated from sample to sample; `None` for fewer
/// than two. The correlation is summed until it is first lost in its own noise.
pub(crate) fn sd_of_mean(values: &[f64]) -> Option<f64> {
    let n = values.len();
    if n < 2 {
        return None;
    }
    let mean = values.iter().sum::<f64>() / n as f64;
    let off: Vec<f64> = values.iter().map(|v| v - mean).collect();
    let covariance = |lag: usize| off.iter().zip(&off[lag..]).map(|(a, b)| a * b).sum::<f64>() / n as f64;
    let variance = covariance(0);
    let lost = 2.0 * variance / (n as f64).sqrt();
    let correlated: f64 = (1..n / 3).map(covariance).take_while(|&c| c > lost).sum();
    Some(((variance + 2.0 * correlated) / (n - 1) as f64).sqrt())
}

/// The weight of the gripper from readings at several attitudes, one list an episode; `None` where the attitudes
/// differ too little. Each episode has its own offset where it holds several attitudes, otherwise all share one.
pub(crate) fn weigh(episodes: &[Vec<FreeReading>]) -> Option<Weight> {
    let pooled: Vec<FreeReading> = episodes.iter().flatten().cloned().collect();
    regress(episodes).or_else(|| regress(&[pooled]))
}

/// Root mean square angle between the attitudes and their mean that suffices to weigh the gripper, rad.
const LEAST_TILT: f64 = 0.05;

fn regress(groups: &[Vec<FreeReading>]) -> Option<Weight> {
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
    if n < 2.0 || (spread / n).sqrt() < LEAST_TILT {
        return None;
    }
    // Attitudes about one axis leave the moment along gravity's change open; the least moment stands for it.
    let inverse = normal.pseudo_inverse(1e-6 * normal.norm()).ok()?;
    Some(Weight { force: force / spread, moment: inverse * right })
}

#[cfg(test)]
mod tests;
