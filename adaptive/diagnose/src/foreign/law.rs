//! What laws add to the wrench of a foreign simulator.

use super::path::{Interval, Recorded};
use nalgebra::{Matrix3, Vector3};
use trundle_model::{Clock, Plant, Rigid, State, to_body, transport};

/// Points by which a law is averaged over the twist, in standard deviations: the corners of a tetrahedron, which have
/// mean and covariance of the normal distribution.
const POINTS: [[f64; 3]; 4] = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];

/// Mean wrench that laws add over an interval of the seen motion, object axes about the origin: on the object,
/// through what they make heavier, and by what they correct of the readings.
///
/// It is averaged over what the smoothed twist leaves open: near standstill the sign of a dry friction is not known
/// better than the velocity's.
pub(crate) fn added(plant: &Plant<f64>, interval: &Interval, recorded: &Recorded) -> [f64; 3] {
    let (clock, pose, twist) = (interval.clock(), interval.middle.pose, interval.middle.twist);
    let mut sum = [0.0; 3];
    for point in POINTS {
        let moved = [0, 1, 2].map(|k| twist[k] + point[k] * interval.doubt[k]);
        let wrench = plant.action(&State::moving(pose, moved), clock).wrench(to_body(moved, pose[2]));
        sum = [0, 1, 2].map(|k| sum[k] + wrench[k] / 4.0);
    }
    let accel = to_body(interval.accel, pose[2]);
    let (with, without) =
        (needed(&plant.rigid(clock), accel, twist[2]), needed(&bare(plant), accel, twist[2]));
    sum = [0, 1, 2].map(|k| sum[k] - (with[k] - without[k]));
    let mut t = interval.t;
    for piece in &interval.pieces {
        let change = corrected(plant, recorded, t, piece.dt, piece.reading, piece.clock);
        let change = transport([0, 1, 2].map(|k| change[k] - piece.reading[k]), piece.frame);
        sum = [0, 1, 2].map(|k| sum[k] + change[k] * piece.dt / interval.span);
        t += piece.dt;
    }
    sum
}

/// Covariance of [`added`] by what the smoothed twist leaves open, object axes: where a dry friction holds, the seen
/// motion does not tell with which force.
pub(crate) fn doubted(plant: &Plant<f64>, interval: &Interval) -> Matrix3<f64> {
    let (clock, pose, twist) = (interval.clock(), interval.middle.pose, interval.middle.twist);
    let wrench = |point: [f64; 3]| {
        let moved = [0, 1, 2].map(|k| twist[k] + point[k] * interval.doubt[k]);
        Vector3::from(plant.action(&State::moving(pose, moved), clock).wrench(to_body(moved, pose[2])))
    };
    let all = POINTS.map(wrench);
    let mean = all.iter().sum::<Vector3<f64>>() / 4.0;
    all.iter().map(|w| (w - mean) * (w - mean).transpose()).sum::<Matrix3<f64>>() / 4.0
}

/// A mean reading over `[t, t + dt]` as the wrench that truly acted: what was late moved to its time, then what was
/// wrong corrected.
pub(crate) fn corrected(
    plant: &Plant<f64>,
    recorded: &Recorded,
    t: f64,
    dt: f64,
    reading: [f64; 3],
    clock: Clock,
) -> [f64; 3] {
    let Some(delay) = plant.delay(clock) else { return plant.correct(reading, clock) };
    let (now, late) = (recorded.mean(t, t + dt).0, recorded.mean(t + delay, t + delay + dt).0);
    plant.correct([0, 1, 2].map(|k| reading[k] + late[k] - now[k]), clock)
}

/// Mean wrench of the laws over a step of a simulation in which `force` acts beside them, object axes about the origin.
///
/// It is that of the laws' own integrator, which takes drag implicitly: an explicit dry friction would chatter. The
/// laws' own states move on in `state`.
pub(crate) fn over_step(
    plant: &Plant<f64>,
    state: &mut State<f64>,
    force: [f64; 3],
    clock: Clock,
    dt: f64,
) -> [f64; 3] {
    let after = plant.step(state, force, clock, dt);
    let heading = state.pose[2];
    let (before, end) = (to_body(state.twist, heading), to_body(after.twist, heading));
    let gained = needed(&bare(plant), [0, 1, 2].map(|k| (end[k] - before[k]) / dt), before[2]);
    state.inner = after.inner;
    [0, 1, 2].map(|k| gained[k] - force[k])
}

/// The wrench that gave a bare body a change of twist over a step, object axes about the origin.
pub(crate) fn acted(plant: &Plant<f64>, before: &[f64; 6], after: &[f64; 6], dt: f64) -> [f64; 3] {
    let change = to_body([0, 1, 2].map(|k| (after[3 + k] - before[3 + k]) / dt), before[2]);
    needed(&bare(plant), change, before[5])
}

fn bare(plant: &Plant<f64>) -> Rigid<f64> {
    Rigid { mass: plant.mass, com: plant.com, inertia: plant.inertia }
}

/// Wrench about the origin, object axes, that gives the origin the acceleration `[x, y, spin]`.
fn needed(rigid: &Rigid<f64>, [ax, ay, alpha]: [f64; 3], spin: f64) -> [f64; 3] {
    let [x, y] = rigid.com;
    let fx = rigid.mass * (ax - alpha * y - spin * spin * x);
    let fy = rigid.mass * (ay + alpha * x - spin * spin * y);
    [fx, fy, rigid.inertia * alpha + x * fy - y * fx]
}
