//! The figures of the tasks; all are true of every episode, none is hidden.

/// Time between two actions, s, but for pushes.
pub const CONTROL: f64 = 0.05;
/// Simulation steps in that time, unless told otherwise.
pub const STEPS: u32 = 25;
/// Time that a push takes, from the touch to the next choice of a place, s.
pub const PUSH: f64 = 1.0;
/// Share of it in which the tip moves; then it is withdrawn.
pub const MOVING: f64 = 0.8;
/// Time in which the arm brings the wrench from one action to the next, s.
pub const RISE: f64 = 0.02;
/// Time that the gripper takes from one place on the object to another, s.
pub const REGRASP: f64 = 1.0;

/// Wrist readings per second: every bend of the wrench falls on one, so that straight lines between
/// readings are the wrench that acted.
pub const SENSOR_RATE: f64 = 200.0;

/// Wrench of a full action, gripper axes (those of the object), `[N, N, N·m]`; also what the arm can do at most.
pub const FULL_WRENCH: [f64; 3] = [100.0, 100.0, 40.0];
/// The same where it can take hold elsewhere, and how far from the middle of the bounds: half a side, along x and along y.
/// The last entry only asks.
pub const FULL_REGRASP: [f64; WIDEST] = [FULL_WRENCH[0], FULL_WRENCH[1], FULL_WRENCH[2], 1.0, 1.0, 1.0];
/// Velocity of a full action, world axes, `[m/s, m/s, rad/s]`.
pub const FULL_VELOCITY: [f64; 3] = [0.3, 0.3, 0.6];
/// A full push: which way from the mass centre the tip touches, rad; how the push leans from the inward normal, rad;
/// and the greater half of the range of its speed, m/s.
pub const FULL_PUSH: [f64; 3] = [std::f64::consts::PI, std::f64::consts::FRAC_PI_3, 0.15];

/// Half the side of the square that the object's origin must not leave, m.
pub const ARENA: f64 = 2.5;
/// Largest coordinate at which the object or the goal may be put, m.
pub const PLACES: f64 = 2.0;
/// Speed of the object's origin at which it is out of control, m/s.
pub const TOP_SPEED: f64 = 2.0;
/// Spin at which it is out of control, rad/s.
pub const TOP_SPIN: f64 = 4.0;

/// No faster than this the task is done, m/s.
pub const STANDSTILL: f64 = 0.1;
/// What a radian of heading error costs, in metres.
pub const HEADING_COST: f64 = 0.3;
/// What a second of touching an obstacle costs.
pub const TOUCH_COST: f64 = 1.0;
/// What losing the object costs.
pub const LOSS: f64 = 100.0;

/// One standard deviation of the velocities that the agent is told, `[m/s, m/s, rad/s]`.
pub const TWIST_NOISE: [f64; 3] = [0.005, 0.005, 0.01];
/// Draws beyond this many standard deviations are cut.
pub const CUT: f64 = 4.0;
/// Largest factor on all noise.
pub const NOISIEST: f64 = 10.0;

/// Entries that every observation has: pose as x, y, cos, sin; twist; goal as x, y, cos, sin; wrist wrench; grasp.
pub const COMMON: usize = 16;
/// Their largest magnitude: beyond it an instrument is at the end of its scale.
pub const BOUNDS: [f64; COMMON] =
    [3.0, 3.0, 1.0, 1.0, 4.0, 4.0, 7.0, 3.0, 3.0, 1.0, 1.0, 120.0, 120.0, 43.0, 1.5, 1.5];
/// No action has more entries.
pub const WIDEST: usize = 6;
/// Largest magnitude of what an observation says of sizes and places, m.
pub const ROOM: f64 = 3.0;
