//! Wrenches that laws add to the input of a black-box simulator.

use super::law_states::QuadratureNode;
use super::path::Interval;
use nalgebra::{Matrix3, Vector3};
use trundle_infer::Readings;
use trundle_model::{Clock, Plant, Rigid, State, to_body, transport};

/// Sigma points of the twist, in standard deviations: the corners of a tetrahedron. They have the mean and
/// covariance of a standard normal distribution.
const SIGMA_POINTS: [[f64; 3]; 4] =
    [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];

/// Whether a plant adds any wrench.
pub(crate) fn has_laws(plant: &Plant<f64>) -> bool {
    !plant.laws.is_empty() || plant.has_discrepancy()
}

/// Mean wrench that laws add over an interval of the measured motion, object axes about the origin.
///
/// It is the sum of the laws on the object, of the inertia that they add, and of their corrections of the
/// readings. `nodes` are those of [`super::law_states`]; `accel` is the acceleration that the simulator alone
/// predicts, world axes.
///
/// The wrench is averaged over the uncertainty of the smoothed twist: near standstill the sign of a dry friction
/// is as uncertain as that of the velocity. Added inertia acts on the predicted acceleration. The measured
/// acceleration is also due to missing effects, so that a law could explain it by itself.
pub(crate) fn mean_law_wrench(
    plant: &Plant<f64>,
    interval: &Interval,
    readings: &Readings,
    nodes: &[QuadratureNode],
    accel: [f64; 3],
) -> [f64; 3] {
    let spin = interval.middle.twist[2];
    let mut sum: [f64; 3] =
        (wrenches_on_object(plant, interval, nodes).iter().sum::<Vector3<f64>>() / 4.0).into();
    for step in &interval.steps {
        let (acting, reading) = (readings.applied_wrench(plant, step).0, transport(step.reading, step.frame));
        sum = [0, 1, 2].map(|k| sum[k] + (acting[k] - reading[k]) * step.dt / interval.span);
    }
    let (rigid, heading) = (rigid_without_laws(plant), interval.middle.pose[2]);
    let without = wrench_for_acceleration(&rigid, to_body(accel, heading), spin);
    let total = [0, 1, 2].map(|k| without[k] + sum[k]);
    let with = wrench_for_acceleration(
        &rigid,
        acceleration_from_wrench(&plant.rigid(interval.clock()), total, spin),
        spin,
    );
    [0, 1, 2].map(|k| with[k] - without[k])
}

/// Covariance of [`mean_law_wrench`] due to the uncertainty of the smoothed twist, object axes. During sticking,
/// the measured motion does not determine the dry friction.
pub(crate) fn law_wrench_covariance(
    plant: &Plant<f64>,
    interval: &Interval,
    nodes: &[QuadratureNode],
) -> Matrix3<f64> {
    let all = wrenches_on_object(plant, interval, nodes);
    let mean = all.iter().sum::<Vector3<f64>>() / 4.0;
    all.iter().map(|w| (w - mean) * (w - mean).transpose()).sum::<Matrix3<f64>>() / 4.0
}

/// Mean wrench of the laws on the object over an interval, for each of the [`SIGMA_POINTS`].
fn wrenches_on_object(
    plant: &Plant<f64>,
    interval: &Interval,
    nodes: &[QuadratureNode],
) -> [Vector3<f64>; 4] {
    let middle = [QuadratureNode { state: interval.middle, weight: 1.0 }];
    let (clock, nodes) = (interval.clock(), if nodes.is_empty() { &middle[..] } else { nodes });
    SIGMA_POINTS.map(|point| {
        let wrench = |QuadratureNode { state, weight }: &QuadratureNode| {
            let twist = [0, 1, 2].map(|k| state.twist[k] + point[k] * interval.twist_sd[k]);
            let moved = State { twist, ..*state };
            Vector3::from(plant.generalised_force(&moved, clock).wrench(to_body(twist, state.pose[2])))
                * *weight
        };
        nodes.iter().map(wrench).sum()
    })
}

/// Mean wrench of the laws over a simulation step in which `force` also acts, object axes about the origin.
///
/// It follows from the plant's own integrator, which treats drag implicitly: explicit dry friction would chatter.
/// The states of the laws in `state` advance by one step.
pub(crate) fn law_wrench_over_step(
    plant: &Plant<f64>,
    state: &mut State<f64>,
    force: [f64; 3],
    clock: Clock,
    dt: f64,
) -> [f64; 3] {
    let after = plant.step(state, force, clock, dt);
    let heading = state.pose[2];
    let (before, end) = (to_body(state.twist, heading), to_body(after.twist, heading));
    let total = wrench_for_acceleration(
        &rigid_without_laws(plant),
        [0, 1, 2].map(|k| (end[k] - before[k]) / dt),
        before[2],
    );
    state.inner = after.inner;
    [0, 1, 2].map(|k| total[k] - force[k])
}

/// Wrench that gives a rigid body without laws a change of twist over a step, object axes about the origin.
pub(crate) fn wrench_from_motion(
    plant: &Plant<f64>,
    before: &[f64; 6],
    after: &[f64; 6],
    dt: f64,
) -> [f64; 3] {
    let change = to_body([0, 1, 2].map(|k| (after[3 + k] - before[3 + k]) / dt), before[2]);
    wrench_for_acceleration(&rigid_without_laws(plant), change, before[5])
}

fn rigid_without_laws(plant: &Plant<f64>) -> Rigid<f64> {
    Rigid { mass: plant.mass, com: plant.com, inertia: plant.inertia }
}

/// Wrench about the origin, object axes, that gives the origin the acceleration `[x, y, spin]`.
fn wrench_for_acceleration(rigid: &Rigid<f64>, [ax, ay, alpha]: [f64; 3], spin: f64) -> [f64; 3] {
    let [x, y] = rigid.com;
    let fx = rigid.mass * (ax - alpha * y - spin * spin * x);
    let fy = rigid.mass * (ay + alpha * x - spin * spin * y);
    [fx, fy, rigid.inertia * alpha + x * fy - y * fx]
}

/// Acceleration of the origin `[x, y, spin]` under a wrench about it, object axes; the inverse of
/// [`wrench_for_acceleration`].
fn acceleration_from_wrench(rigid: &Rigid<f64>, [fx, fy, torque]: [f64; 3], spin: f64) -> [f64; 3] {
    let [x, y] = rigid.com;
    let alpha = (torque - x * fy + y * fx) / rigid.inertia;
    let ax = fx / rigid.mass + alpha * y + spin * spin * x;
    let ay = fy / rigid.mass - alpha * x + spin * spin * y;
    [ax, ay, alpha]
}
