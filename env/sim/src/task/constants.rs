//! Constants of the tasks. They apply to every episode, and none is hidden.

/// Time between two actions, except in the action mode `push`, s.
pub const CONTROL_PERIOD_S: f64 = 0.05;
/// Default number of simulation steps in [`CONTROL_PERIOD_S`].
pub const DEFAULT_SUBSTEPS: u32 = 25;
/// Time between two actions in the action mode `push`, s.
pub const PUSH_PERIOD_S: f64 = 1.0;
/// Fraction of [`PUSH_PERIOD_S`] in which the fingertip pushes. Then it is retracted.
pub const PUSH_CONTACT_FRACTION: f64 = 0.8;
/// Time in which the wrench ramps from one action to the next, s.
pub const WRENCH_RISE_S: f64 = 0.02;
/// Duration of a regrasp, s.
pub const REGRASP_S: f64 = 1.0;

/// Wrist readings per second. Every knot of the wrench coincides with a reading, so that linear interpolation of the
/// readings reproduces the applied wrench.
pub const SENSOR_RATE_HZ: f64 = 200.0;

/// Wrench of a full action, in gripper axes (parallel to the object axes), `[N, N, N·m]`. It is also the limit of the arm.
pub const FULL_WRENCH: [f64; 3] = [100.0, 100.0, 40.0];
/// Full action in the mode `regrasp`: the wrench, the grasp position from the centre of the bounds as a fraction of half
/// a side along x and y, and the request to regrasp.
pub const FULL_REGRASP: [f64; MAX_ACTION_WIDTH] =
    [FULL_WRENCH[0], FULL_WRENCH[1], FULL_WRENCH[2], 1.0, 1.0, 1.0];
/// Velocity of a full action, world axes, `[m/s, m/s, rad/s]`.
pub const FULL_VELOCITY: [f64; 3] = [0.3, 0.3, 0.6];
/// Full action in the mode `push`: direction of the contact from the mass centre, rad; angle between push and inward
/// normal, rad; and half of the speed range, m/s.
pub const FULL_PUSH: [f64; 3] = [std::f64::consts::PI, std::f64::consts::FRAC_PI_3, 0.15];

/// Half the side of the square workspace of the object origin, m.
pub const ARENA_HALF_SIDE_M: f64 = 2.5;
/// Largest coordinate of a start or goal, m.
pub const MAX_PLACEMENT_M: f64 = 2.0;
/// Speed of the object origin above which the episode fails, m/s.
pub const MAX_SPEED_M_PER_S: f64 = 2.0;
/// Spin above which the episode fails, rad/s.
pub const MAX_SPIN_RAD_PER_S: f64 = 4.0;

/// Speed below which the object counts as at the goal, m/s.
pub const MAX_GOAL_SPEED_M_PER_S: f64 = 0.1;
/// Cost of a heading error, m/rad.
pub const HEADING_COST_M_PER_RAD: f64 = 0.3;
/// Default range of the friction of a locked wheel in both directions, N·s/m.
pub const LOCKED_FRICTION_N_S_PER_M: (f64, f64) = (60.0, 300.0);
/// Cost of leaving the workspace or exceeding a speed limit.
pub const FAILURE_COST: f64 = 100.0;

/// Standard deviation of the observed velocities, `[m/s, m/s, rad/s]`.
pub const TWIST_NOISE_SD: [f64; 3] = [0.005, 0.005, 0.01];
/// Observation noise is clipped to this number of standard deviations.
pub const MAX_NOISE_SDS: f64 = 4.0;
/// Largest value of the option `noise`.
pub const MAX_NOISE_FACTOR: f64 = 10.0;

/// Largest time constant of an arm's lag, s.
pub const MAX_ARM_LAG_S: f64 = 2.0;
/// Largest delay of arm or sensors, and largest stated decision time, s.
pub const MAX_DELAY_S: f64 = 1.0;
/// Largest measured decision time that the world waits for, s.
pub const MAX_DECISION_S: f64 = 10.0;

/// Number of entries of the bounding box in observations of version 1: half sides, middle.
pub const BOUNDS_ENTRIES: usize = 4;
/// Number of directions of an observed outline.
pub const OUTLINE_ENTRIES: usize = 24;
/// Number of entries common to all observations: pose as x, y, cos, sin; twist; goal as x, y, cos, sin; wrist wrench;
/// grasp.
pub const COMMON_ENTRIES: usize = 16;
/// Largest magnitudes of the common entries. Observations are clipped to them.
pub const COMMON_BOUNDS: [f64; COMMON_ENTRIES] =
    [3.0, 3.0, 1.0, 1.0, 4.0, 4.0, 7.0, 3.0, 3.0, 1.0, 1.0, 120.0, 120.0, 43.0, 1.5, 1.5];
/// Largest number of entries of an action.
pub const MAX_ACTION_WIDTH: usize = 6;
/// Largest magnitude of observed sizes and positions, m.
pub const MAX_FEATURE_M: f64 = 3.0;
