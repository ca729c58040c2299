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
    /// `1/√M` of the directions that can move, 0 of those that a rail blocks.
    scale: [T; 3],
}

impl<T: Real> Plant<T> {
    pub(crate) fn new(mass: T, body: &Body, dof: [bool; 3], laws: Vec<Law<T>>) -> Self {
        let inertia = mass * (body.gyration * body.gyration);
        let free = |moves: bool, m: T| if moves { m.sqrt().recip() } else { T::zero() };
        let scale = [free(dof[0], mass), free(dof[1], mass), free(dof[2], inertia)];
        Self { mass, inertia, com: body.com.map(T::lift), laws, scale }
    }

    /// What all laws do at a state, object axes about the object origin.
    pub fn action(&self, state: &State<T>, clock: Clock) -> Action<T> {
        let heading = state.pose[2].sin_cos();
        let [vx, vy, spin] = state.twist;
        let (sin, cos) = heading;
        self.act(state, heading, [cos * vx + sin * vy, cos * vy - sin * vx, spin], clock)
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
    pub fn step(&self, state: &State<T>, applied: [T; 3], clock: Clock, dt: f64) -> State<T> {
        let [x, y, theta] = state.pose;
        let half = dt / 2.0;
        let start = theta.sin_cos();
        let before = self.to_center(state.twist, start);

        let twist = rotate_back(state.twist, start);
        let near = self.solve_half(
            before,
            self.about_center(applied, self.act(state, start, twist, clock)),
            start,
            half,
        );
        let spin = (before[2] + near[2]) * 0.5;
        let middle_heading = theta + spin * half;
        let middle = middle_heading.sin_cos();
        let near_origin = self.to_origin(near, middle);
        let mid = State {
            pose: [x + near_origin[0] * half, y + near_origin[1] * half, middle_heading],
            twist: near_origin,
        };

        let twist = rotate_back(near_origin, middle);
        let after =
            self.solve(before, self.about_center(applied, self.act(&mid, middle, twist, clock)), middle, dt);
        let theta_after = theta + (before[2] + after[2]) * half;
        let end = theta_after.sin_cos();
        let (from, to) = (self.center_offset(start), self.center_offset(end));
        State {
            pose: [
                x + from[0] - to[0] + (before[0] + after[0]) * half,
                y + from[1] - to[1] + (before[1] + after[1]) * half,
                theta_after,
            ],
            twist: self.to_origin(after, end),
        }
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
        let push = [0, 1, 2].map(|k| action.push[k] + applied[k]);
        let moment = push[2] + push[0] * cy - push[1] * cx;
        let [a, b, c] = self.scale;
        Action {
            push: [push[0] * a, push[1] * b, moment * c],
            drag: [xx * a * a, xy * a * b, yy * b * b, sx * a * c, sy * b * c, spin * c * c],
        }
    }

    /// Implicit Euler over `h`; velocities of the mass centre, world axes.
    #[inline]
    fn solve_half(&self, before: [T; 3], scaled: Action<T>, heading: (T, T), h: f64) -> [T; 3] {
        let u = self.momentum(before, heading);
        let rhs = [0, 1, 2].map(|k| u[k] + scaled.push[k] * h);
        let mut lhs = scaled.drag.map(|d| d * h);
        add_identity(&mut lhs);
        self.velocity(solve_spd(lhs, rhs), heading)
    }

    /// The (0,2) Padé step over `h`.
    #[inline]
    fn solve(&self, before: [T; 3], scaled: Action<T>, heading: (T, T), h: f64) -> [T; 3] {
        let u = self.momentum(before, heading);
        let drag = scaled.drag;
        let damped = multiply(drag, scaled.push);
        let rhs = [0, 1, 2].map(|k| u[k] + (scaled.push[k] + damped[k] * (h / 2.0)) * h);
        let square = squared(drag);
        let mut lhs = [0, 1, 2, 3, 4, 5].map(|k| (drag[k] + square[k] * (h / 2.0)) * h);
        add_identity(&mut lhs);
        self.velocity(solve_spd(lhs, rhs), heading)
    }

    /// `M^½ v` in object axes. On a blocked direction the velocity is zero and stays so.
    #[inline]
    fn momentum(&self, v: [T; 3], heading: (T, T)) -> [T; 3] {
        let v = rotate_back(v, heading);
        [0, 1, 2].map(|k| if self.scale[k].re() > 0.0 { v[k] / self.scale[k] } else { T::zero() })
    }

    #[inline]
    fn velocity(&self, u: [T; 3], heading: (T, T)) -> [T; 3] {
        rotate([0, 1, 2].map(|k| u[k] * self.scale[k]), heading)
    }

    /// The mass centre relative to the object origin, world axes.
    #[inline]
    fn center_offset(&self, (sin, cos): (T, T)) -> [T; 2] {
        let [cx, cy] = self.com;
        [cos * cx - sin * cy, sin * cx + cos * cy]
    }

    #[inline]
    fn to_center(&self, [vx, vy, spin]: [T; 3], heading: (T, T)) -> [T; 3] {
        let [rx, ry] = self.center_offset(heading);
        [vx - spin * ry, vy + spin * rx, spin]
    }

    #[inline]
    fn to_origin(&self, [vx, vy, spin]: [T; 3], heading: (T, T)) -> [T; 3] {
        let [rx, ry] = self.center_offset(heading);
        [vx + spin * ry, vy - spin * rx, spin]
    }
}

#[inline]
fn rotate<T: Real>([x, y, z]: [T; 3], (sin, cos): (T, T)) -> [T; 3] {
    [cos * x - sin * y, sin * x + cos * y, z]
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
fn add_identity<T: Real>(m: &mut [T; 6]) {
    for k in [0, 2, 5] {
        m[k] = m[k] + 1.0;
    }
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
