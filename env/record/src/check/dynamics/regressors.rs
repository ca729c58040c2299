//! Regressors: the contribution of each unit parameter of a passive body to the reading.

use super::super::data::RecordingData;
use crate::inertia::DIRECTION_SCALE_SD;
use crate::metadata::{Frame, Reference};
use crate::motion::Motion;

/// Number of point masses, and of points of dry friction. They form a 3×3 grid over the object's bounding box. Their positive
/// combinations approximate every mass distribution and support in it.
pub(crate) const MASS_POINTS: usize = 9;
/// Number of elements of the symmetric damping matrix, in the order of [`DAMPING_INDICES`].
pub(crate) const DAMPING_ELEMENTS: usize = 6;
/// Number of constant terms: the sensor's offset (3) and a horizontal force that is constant in the world (2), from a slope
/// or a tilted sensor.
pub(crate) const CONSTANT_TERMS: usize = 5;
/// Total number of columns.
pub(crate) const COLUMNS: usize = 2 * MASS_POINTS + DAMPING_ELEMENTS + CONSTANT_TERMS;
/// Row and column of each element of the damping matrix.
pub(crate) const DAMPING_INDICES: [(usize, usize); DAMPING_ELEMENTS] =
    [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)];

/// Regressors of each output: force x, force y, torque over [`Scale::arm`].
pub(crate) type Row = [[f64; COLUMNS]; 3];

/// Interpretation of the columns of a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Convention {
    pub frame: Frame,
    pub reference: Reference,
    /// Whether angles count clockwise.
    pub clockwise: bool,
}

impl Convention {
    /// The convention that the recording states.
    pub fn stated(data: &RecordingData) -> Self {
        Self { frame: data.meta.wrench.frame, reference: data.reference(), clockwise: false }
    }
}

/// Bounding box of the object, and the lever arm that relates torques to forces.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Scale {
    pub middle: [f64; 2],
    pub half: [f64; 2],
    pub arm: f64,
}

impl Scale {
    /// Creates the scale from the corners of the bounding box. The lever arm is a quarter of the diagonal, about the radius
    /// of gyration.
    pub fn new([low, high]: [[f64; 2]; 2]) -> Self {
        let half = [0, 1].map(|k| (high[k] - low[k]) / 2.0);
        let size = 2.0 * half[0].hypot(half[1]);
        let arm = if size > 0.0 { size / 4.0 } else { 1.0 };
        Self { middle: [0, 1].map(|k| (low[k] + high[k]) / 2.0), half, arm }
    }
}

/// The regressors at one time. `gripper` is the pose of the gripper in the world.
pub(crate) fn row(motion: &Motion, gripper: &[f64; 3], scale: &Scale, convention: Convention) -> Row {
    let sense = if convention.clockwise { -1.0 } else { 1.0 };
    let theta = sense * motion.pose[2];
    let (sin, cos) = theta.sin_cos();
    let body = |v: [f64; 2]| [cos * v[0] + sin * v[1], cos * v[1] - sin * v[0]];
    let [ax, ay] = body([motion.accel[0], motion.accel[1]]);
    let [vx, vy] = body([motion.twist[0], motion.twist[1]]);
    let (rate, spin) = (sense * motion.twist[2], sense * motion.accel[2]);
    let place = body([gripper[0] - motion.pose[0], gripper[1] - motion.pose[1]]);
    let origin = if convention.reference == Reference::Sensor { place } else { [0.0; 2] };
    let angle = match convention.frame {
        Frame::Sensor => sense * gripper[2] - theta,
        Frame::Object => 0.0,
        Frame::World => -theta,
    };
    let mut out = RowBuilder { row: [[0.0; COLUMNS]; 3], origin, turn: angle.sin_cos(), arm: scale.arm };
    let sd = [0, 1, 2].map(|k| motion.cov[k][1][1].sqrt());
    let noise = DIRECTION_SCALE_SD * sd[0].hypot(sd[1]).hypot(2.0 * scale.arm * sd[2]);
    for (at, point) in grid(scale).into_iter().enumerate() {
        let [x, y] = point;
        let accel = [ax - spin * y - rate * rate * x, ay + spin * x - rate * rate * y];
        out.force(at, point, accel);
        let velocity = [vx - rate * y, vy + rate * x];
        let speed = velocity[0].hypot(velocity[1]).hypot(noise);
        out.force(MASS_POINTS + at, point, velocity.map(|v| if speed > 0.0 { v / speed } else { 0.0 }));
    }
    let twist = [vx, vy, scale.arm * rate];
    for (at, (i, j)) in DAMPING_INDICES.into_iter().enumerate() {
        let mut wrench = [0.0; 3];
        wrench[i] = twist[j];
        wrench[j] = twist[i];
        out.wrench(2 * MASS_POINTS + at, [wrench[0], wrench[1], scale.arm * wrench[2]]);
    }
    let first = COLUMNS - CONSTANT_TERMS;
    (0..3).for_each(|axis| out.row[axis][first + axis] = 1.0);
    out.force(first + 3, scale.middle, [cos, -sin]);
    out.force(first + 4, scale.middle, [sin, cos]);
    out.row
}

/// The 3×3 grid over the bounding box.
fn grid(scale: &Scale) -> [[f64; 2]; MASS_POINTS] {
    let at = |k: usize| k as f64 - 1.0;
    std::array::from_fn(|n| {
        [scale.middle[0] + at(n / 3) * scale.half[0], scale.middle[1] + at(n % 3) * scale.half[1]]
    })
}

/// Builder of a row. It transforms wrenches in object axes to the axes and the reference point of the reading.
struct RowBuilder {
    row: Row,
    origin: [f64; 2],
    turn: (f64, f64),
    arm: f64,
}

impl RowBuilder {
    /// Sets a column to a force in object axes at a point of the object.
    fn force(&mut self, column: usize, [x, y]: [f64; 2], [fx, fy]: [f64; 2]) {
        self.wrench(column, [fx, fy, x * fy - y * fx]);
    }

    /// Sets a column to a wrench in object axes about the object's origin.
    fn wrench(&mut self, column: usize, [fx, fy, torque]: [f64; 3]) {
        let (sin, cos) = self.turn;
        let [x, y] = self.origin;
        self.row[0][column] = cos * fx + sin * fy;
        self.row[1][column] = cos * fy - sin * fx;
        self.row[2][column] = (torque - x * fy + y * fx) / self.arm;
    }
}
