//! Free motion: one step of a model under an applied wrench.
//!
//! The laws give `push − drag·twist`; the drag is treated implicitly, because a locked wheel makes
//! `μ·dt/m` much larger than one. A half step of implicit Euler finds the middle of the interval,
//! where drag, push and heading are taken; the whole step then is the (0,2) Padé approximant
//!
//! ```text
//! (I + hA + h²A²/2) u' = u + (h + h²A/2) w,    A = M^-½ D M^-½,  u = M^½ v,  w = M^-½ push
//! ```
//! second order, L-stable, and without overshoot where dry friction stops a body (`D = f/|v|`).

use crate::law::{Action, Clock, Situation};
use crate::{Body, Law, Real};

/// Motion state of the object frame's origin: pose `[m, m, rad]` and twist `[m/s, m/s, rad/s]`, world axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State<T> {
    /// Pose of the object frame in the world.
    pub pose: [T; 3],
    /// Velocity of its origin, and spin.
    pub twist: [T; 3],
}

impl<T: Real> State<T> {
    /// At rest at a pose.
    pub fn at_rest(pose: [f64; 3]) -> Self {
        Self { pose: pose.map(T::lift), twist: [T::zero(); 3] }
    }
}

/// A step is halved at most so often: to 1/16.
const HALVINGS: u32 = 4;

/// What a change of the drag within half a step may do to the velocity over a step before it is halved, m/s.
const STEADY: f64 = 3e-4;

/// A model with its parameters in place, ready to be stepped.
#[derive(Clone, Debug)]
pub struct Plant<T> {
    /// Mass, kg.
    pub mass: T,
    /// Inertia about the mass centre, kg·m².
    pub inertia: T,
    /// Mass centre, object frame, m.
    pub com: [T; 2],
    /// The laws.
    pub laws: Vec<Law<T>>,
    /// `√M` of the directions that can move, 0 of those that a rail blocks.
    root: [T; 3],
    /// One over it, and likewise 0.
    scale: [T; 3],
    /// Products of `scale`, by which a drag matrix `[xx, xy, yy, xθ, yθ, θθ]` is scaled.
    weight: [T; 6],
}

impl<T: Real> Plant<T> {
    pub(crate) fn new(mass: T, body: &Body, dof: [bool; 3], laws: Vec<Law<T>>) -> Self {
        let inertia = mass * (body.gyration * body.gyration);
        let free = |moves: bool, root: T| if moves { root } else { T::zero() };
        let along = |[x, y, theta]: [T; 3]| [free(dof[0], x), free(dof[1], y), free(dof[2], theta)];
        let (line, turn) = (mass.sqrt(), inertia.sqrt());
        let root = along([line, line, turn]);
        let [a, b, c] = along([line.recip(), line.recip(), turn.recip()]);
        let weight = [a * a, a * b, b * b, a * c, b * c, c * c];
        Self { mass, inertia, com: body.com.map(T::lift), laws, root, scale: [a, b, c], weight }
    }

    /// What all laws do at a state, object axes about the object origin.
    pub fn action(&self, state: &State<T>, clock: Clock) -> Action<T> {
        let heading = state.pose[2].sin_cos();
        self.act(state, heading, rotate_back(state.twist, heading), clock)
    }

    /// A sensor reading, reading axes about its reference point, as the wrench that truly acted.
    pub fn correct(&self, mut reading: [T; 3], clock: Clock) -> [T; 3] {
        for law in &self.laws {
            reading = law.correct(reading, clock);
        }
        reading
    }

    /// The state after `dt` seconds under `applied`, the mean wrench on the object over the step
    /// in object axes about the object origin (it turns with the object).
    ///
    /// Where the drag changes much within the step, as dry friction does when a body stops or turns
    /// back, the step is halved, again and again if need be.
    pub fn step(&self, state: &State<T>, applied: [T; 3], clock: Clock, dt: f64) -> State<T> {
        self.halved(state, applied, clock, dt, HALVINGS)
    }

    fn halved(&self, state: &State<T>, applied: [T; 3], clock: Clock, dt: f64, halvings: u32) -> State<T> {
        let (after, change) = self.leap(state, applied, clock, dt);
        if halvings == 0 || change < STEADY {
            return after;
        }
        let middle = self.halved(state, applied, clock, dt / 2.0, halvings - 1);
        self.halved(&middle, applied, clock, dt / 2.0, halvings - 1)
    }

    /// One undivided step, and what the change of the drag in its first half does to the velocity, m/s.
    fn leap(&self, state: &State<T>, applied: [T; 3], clock: Clock, dt: f64) -> (State<T>, f64) {
        let half = dt / 2.0;
        let [x, y, theta] = state.pose;
        let start = theta.sin_cos();
        let from = turned(self.com, start);
        let before = carried(state.twist, from);

        let twist = rotate_back(state.twist, start);
        let load = self.about_center(applied, self.act(state, start, twist, clock));
        let near = rotate(self.solve_half(carried(twist, self.com), &load, half), start);

        let heading = theta + (before[2] + near[2]) * (half / 2.0);
        let middle = heading.sin_cos();
        let twist = carried(rotate_back(near, middle), [-self.com[0], -self.com[1]]);
        let [vx, vy, _] = state.twist;
        let mid = State { pose: [x + vx * half, y + vy * half, heading], twist };
        let first = load.size();
        let load = self.about_center(applied, self.act(&mid, middle, twist, clock));
        let speed = twist.iter().map(|v| v.re() * v.re()).sum::<f64>().sqrt();
        let change = dt * (load.size() - first).abs() * speed;
        let after = rotate(self.solve(rotate_back(before, middle), &load, dt), middle);

        let heading = theta + (before[2] + after[2]) * half;
        let to = turned(self.com, heading.sin_cos());
        let after = State {
            pose: [
                x + from[0] - to[0] + (before[0] + after[0]) * half,
                y + from[1] - to[1] + (before[1] + after[1]) * half,
                heading,
            ],
            twist: carried(after, [-to[0], -to[1]]),
        };
        (after, change)
    }

    #[inline]
    fn act(&self, state: &State<T>, heading: (T, T), twist: [T; 3], clock: Clock) -> Action<T> {
        let position = [state.pose[0], state.pose[1]];
        let at = Situation { position, heading, twist, mass: self.mass, com: self.com, clock };
        let mut sum = Action::none();
        for law in &self.laws {
            law.act(&at, &mut sum);
        }
        sum
    }

    /// An action and an applied wrench, moved to the mass centre and scaled by `M^-½`.
    #[inline]
    fn about_center(&self, applied: [T; 3], action: Action<T>) -> Action<T> {
        let [cx, cy] = self.com;
        let [xx, xy, yy, tx, ty, tt] = action.drag;
        // Twist at the origin from the twist at the centre: v_o = v_c + ω (c_y, −c_x).
        let (sx, sy) = (tx + xx * cy - xy * cx, ty + xy * cy - yy * cx);
        let spin = tt + tx * cy - ty * cx + sx * cy - sy * cx;
        let [px, py, torque] = sum(action.push, applied);
        Action {
            push: scaled([px, py, torque + px * cy - py * cx], self.scale),
            drag: scaled([xx, xy, yy, sx, sy, spin], self.weight),
        }
    }

    /// Implicit Euler over `h`; velocities of the mass centre, object axes.
    #[inline]
    fn solve_half(&self, v: [T; 3], Action { push, drag }: &Action<T>, h: f64) -> [T; 3] {
        let u = sum(scaled(v, self.root), times(*push, h));
        scaled(solve_spd(plus_identity(times(*drag, h)), u), self.scale)
    }

    /// The (0,2) Padé step over `h`. On a blocked direction the velocity is zero and stays so.
    #[inline]
    fn solve(&self, v: [T; 3], Action { push, drag }: &Action<T>, h: f64) -> [T; 3] {
        let second = h * h / 2.0;
        let u = sum(scaled(v, self.root), times(*push, h));
        let u = sum(u, times(multiply(*drag, *push), second));
        let matrix = sum(times(*drag, h), times(squared(*drag), second));
        scaled(solve_spd(plus_identity(matrix), u), self.scale)
    }
}

/// Sum by elements.
#[inline]
fn sum<T: Real, const N: usize>(mut a: [T; N], b: [T; N]) -> [T; N] {
    for (a, b) in a.iter_mut().zip(b) {
        *a += b;
    }
    a
}

/// Product by elements.
#[inline]
fn scaled<T: Real, const N: usize>(mut a: [T; N], by: [T; N]) -> [T; N] {
    for (a, by) in a.iter_mut().zip(by) {
        *a = *a * by;
    }
    a
}

/// Product with a number.
#[inline]
fn times<T: Real, const N: usize>(mut a: [T; N], by: f64) -> [T; N] {
    for a in &mut a {
        *a = *a * by;
    }
    a
}

/// The twist of a body, taken at a point that lies `[x, y]` from where it was given.
#[inline]
fn carried<T: Real>([vx, vy, spin]: [T; 3], [x, y]: [T; 2]) -> [T; 3] {
    [vx - spin * y, vy + spin * x, spin]
}

/// A vector of the body in world axes.
#[inline]
fn turned<T: Real>([x, y]: [T; 2], (sin, cos): (T, T)) -> [T; 2] {
    [cos * x - sin * y, sin * x + cos * y]
}

#[inline]
fn rotate<T: Real>([x, y, z]: [T; 3], heading: (T, T)) -> [T; 3] {
    let [x, y] = turned([x, y], heading);
    [x, y, z]
}

#[inline]
fn rotate_back<T: Real>(v: [T; 3], (sin, cos): (T, T)) -> [T; 3] {
    rotate(v, (-sin, cos))
}

/// A world-axes vector `[x, y, about z]` in the axes of a frame at `angle`.
pub fn to_body<T: Real>(v: [T; 3], angle: T) -> [T; 3] {
    rotate_back(v, angle.sin_cos())
}

/// A vector `[x, y, about z]` in the axes of a frame at `angle`, in world axes.
pub fn to_world<T: Real>(v: [T; 3], angle: T) -> [T; 3] {
    rotate(v, angle.sin_cos())
}

/// A wrench given in a frame at `frame = [x, y, angle]` of the object, in object axes about the
/// object origin: the planar form of eq. 11.
#[inline]
pub fn transport<T: Real>(wrench: [T; 3], frame: [f64; 3]) -> [T; 3] {
    let (sin, cos) = frame[2].sin_cos();
    let fx = wrench[0] * cos - wrench[1] * sin;
    let fy = wrench[0] * sin + wrench[1] * cos;
    [fx, fy, wrench[2] + fy * frame[0] - fx * frame[1]]
}

#[inline]
fn plus_identity<T: Real>([xx, xy, yy, xz, yz, zz]: [T; 6]) -> [T; 6] {
    [xx + 1.0, xy, yy + 1.0, xz, yz, zz + 1.0]
}

/// Product of a symmetric matrix `[xx, xy, yy, xz, yz, zz]` and a vector.
#[inline]
fn multiply<T: Real>([xx, xy, yy, xz, yz, zz]: [T; 6], [x, y, z]: [T; 3]) -> [T; 3] {
    [xx * x + xy * y + xz * z, xy * x + yy * y + yz * z, xz * x + yz * y + zz * z]
}

/// Square of a symmetric matrix.
#[inline]
fn squared<T: Real>([xx, xy, yy, xz, yz, zz]: [T; 6]) -> [T; 6] {
    [
        xx * xx + xy * xy + xz * xz,
        xx * xy + xy * yy + xz * yz,
        xy * xy + yy * yy + yz * yz,
        xx * xz + xy * yz + xz * zz,
        xy * xz + yy * yz + yz * zz,
        xz * xz + yz * yz + zz * zz,
    ]
}

/// Solve a symmetric positive definite system by LDLᵀ.
#[inline]
fn solve_spd<T: Real>([xx, xy, yy, xz, yz, zz]: [T; 6], [x, y, z]: [T; 3]) -> [T; 3] {
    let d0 = xx.recip();
    let (l1, l2) = (xy * d0, xz * d0);
    let d1 = (yy - l1 * xy).recip();
    let cross = yz - l2 * xy;
    let l3 = cross * d1;
    let d2 = (zz - l2 * xz - l3 * cross).recip();
    let y = y - l1 * x;
    let z = (z - l2 * x - l3 * y) * d2;
    let y = y * d1 - l3 * z;
    [x * d0 - l1 * y - l2 * z, y, z]
}
