//! What laws add to the wrench of a foreign simulator.

use super::own_states::Moment;
use super::path::Interval;
use nalgebra::{Matrix3, Vector3};
use trundle_infer::Readings;
use trundle_model::{Clock, Plant, Rigid, State, to_body, transport};

/// Points by which a law is averaged over the twist, in standard deviations: the corners of a tetrahedron, which have
/// mean and covariance of the normal distribution.
const POINTS: [[f64; 3]; 4] = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];

/// Whether a plant adds anything at all.
pub(crate) fn acts(plant: &Plant<f64>) -> bool {
    !plant.laws.is_empty() || plant.is_unnamed()
}

/// Mean wrench that laws add over an interval of the seen motion, object axes about the origin: on the object,
/// through what they make heavier, and by what they correct of the readings. `moments` are those of [`super::own_states`],
/// `accel` is how the simulator alone accelerates, world axes.
///
/// It is averaged over what the smoothed twist leaves open: near standstill the sign of a dry friction is not known
/// better than the velocity's. What is heavier resists the acceleration that is predicted, not the one that was seen: that
/// is also due to what is missing, and would be explained by itself.
pub(crate) fn added(
    plant: &Plant<f64>,
    interval: &Interval,
    readings: &Readings,
    moments: &[Moment],
    accel: [f64; 3],
) -> [f64; 3] {
    let spin = interval.middle.twist[2];
    let mut sum: [f64; 3] = (on_object(plant, interval, moments).iter().sum::<Vector3<f64>>() / 4.0).into();
    for step in &interval.steps {
        let (acting, read) = (readings.applied_wrench(plant, step).0, transport(step.reading, step.frame));
        sum = [0, 1, 2].map(|k| sum[k] + (acting[k] - read[k]) * step.dt / interval.span);
    }
    let (bare, heading) = (bare(plant), interval.middle.pose[2]);
    let alone = needed(&bare, to_body(accel, heading), spin);
    let together = [0, 1, 2].map(|k| alone[k] + sum[k]);
    let with = needed(&bare, accelerated(&plant.rigid(interval.clock()), together, spin), spin);
    [0, 1, 2].map(|k| with[k] - alone[k])
}

/// Covariance of [`added`] by what the smoothed twist leaves open, object axes: where a dry friction holds, the seen
/// motion does not tell with which force.
pub(crate) fn doubted(plant: &Plant<f64>, interval: &Interval, moments: &[Moment]) -> Matrix3<f64> {
    let all = on_object(plant, interval, moments);
    let mean = all.iter().sum::<Vector3<f64>>() / 4.0;
    all.iter().map(|w| (w - mean) * (w - mean).transpose()).sum::<Matrix3<f64>>() / 4.0
}

/// Mean wrench of the laws on the object over an interval, for each of the [`POINTS`].
fn on_object(plant: &Plant<f64>, interval: &Interval, moments: &[Moment]) -> [Vector3<f64>; 4] {
    let middle = [Moment { state: interval.middle, share: 1.0 }];
    let (clock, moments) = (interval.clock(), if moments.is_empty() { &middle[..] } else { moments });
    POINTS.map(|point| {
        let wrench = |Moment { state, share }: &Moment| {
            let twist = [0, 1, 2].map(|k| state.twist[k] + point[k] * interval.doubt[k]);
            let moved = State { twist, ..*state };
            Vector3::from(plant.action(&moved, clock).wrench(to_body(twist, state.pose[2]))) * *share
        };
        moments.iter().map(wrench).sum()
    })
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

/// The acceleration of the origin `[x, y, spin]` that a wrench about it gives, object axes; see [`needed`].
fn accelerated(rigid: &Rigid<f64>, [fx, fy, torque]: [f64; 3], spin: f64) -> [f64; 3] {
    let [x, y] = rigid.com;
    let alpha = (torque - x * fy + y * fx) / rigid.inertia;
    let ax = fx / rigid.mass + alpha * y + spin * spin * x;
    let ay = fy / rigid.mass - alpha * x + spin * spin * y;
    [ax, ay, alpha]
}
