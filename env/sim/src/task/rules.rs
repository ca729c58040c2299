//! The figures of the task; all are true of every episode, none is hidden.

/// Time between two actions, s.
pub const CONTROL: f64 = 0.05;
/// Simulation steps in that time.
pub const STEPS: u32 = 25;
/// Simulation step, s.
pub const DT: f64 = CONTROL / STEPS as f64;
/// Time in which the arm brings the wrench from one action to the next, s.
pub const RISE: f64 = 0.02;

/// Wrist readings per second: every bend of the wrench falls on one, so that straight lines between
/// readings are the wrench that acted.
pub const SENSOR_RATE: f64 = 200.0;

/// Wrench of a full action, gripper axes (those of the object), `[N, N, N·m]`.
pub const FULL: [f64; 3] = [100.0, 100.0, 40.0];
/// Half the side of the square that the object's origin must not leave, m.
pub const ARENA: f64 = 2.5;
/// Largest coordinate at which the object or the goal may be put, m.
pub const PLACES: f64 = 2.0;
/// Speed of the object's origin at which it is out of control, m/s.
pub const TOP_SPEED: f64 = 2.0;
/// Spin at which it is out of control, rad/s.
pub const TOP_SPIN: f64 = 4.0;

/// Within this distance of the goal the task is done, m,
pub const REACH: f64 = 0.05;
/// within this heading error, rad,
pub const FACING: f64 = 0.1;
/// and no faster than this, m/s.
pub const STANDSTILL: f64 = 0.1;
/// What a radian of heading error costs, in metres.
pub const HEADING_COST: f64 = 0.3;
/// What losing the object costs.
pub const LOSS: f64 = 100.0;

/// The table, as in `configs/objects/office_table.toml`: half its sides, m,
pub const HALF: [f64; 2] = [0.6, 0.4];
/// its wheels, object frame, m,
pub const WHEELS: [[f64; 2]; 4] = [[-0.5, -0.3], [0.5, -0.3], [0.5, 0.3], [-0.5, 0.3]];
/// and its mass, kg.
pub const MASS: f64 = 22.0;
/// Where the gripper holds it unless told: the middle of the rear edge.
pub const GRASP: [f64; 2] = [-0.6, 0.0];

/// One standard deviation of the velocities that the agent is told, `[m/s, m/s, rad/s]`.
pub const TWIST_NOISE: [f64; 3] = [0.005, 0.005, 0.01];
/// Draws beyond this many standard deviations are cut, so that the observation has true bounds.
pub const CUT: f64 = 4.0;
/// Largest factor on all noise.
pub const NOISIEST: f64 = 10.0;

/// Length of an observation: pose as x, y, cos, sin; twist; goal as x, y, cos, sin; wrist wrench; grasp.
pub const OBSERVATION: usize = 16;

/// Largest magnitude of each entry of an observation, whatever the agent does.
///
/// The object is lost at the limits above; what it can gain within one action comes on top: the
/// largest force on the mass moves it by at most 0.33 m/s and 2 rad/s.
pub const BOUNDS: [f64; OBSERVATION] =
    [3.0, 3.0, 1.0, 1.0, 4.0, 4.0, 7.0, 3.0, 3.0, 1.0, 1.0, 120.0, 120.0, 43.0, HALF[0], HALF[1]];
