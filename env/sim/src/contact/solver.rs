//! Contact impulses on one body by projected Gauss–Seidel iterations with soft contacts.
//!
//! The equations, their order and their constants are those of rapier 0.36 for a dynamic body against fixed ones, so that
//! both agree to rounding. In a step:
//!
//! 1. the impulses of the last step are applied again (warm start),
//! 2. normal impulses are solved with a bias that removes penetration, and the pose is integrated,
//! 3. normal and friction impulses are solved together without that bias.
//!
//! Two points with a common normal are solved together as a linear complementarity problem.

use std::f64::consts::TAU;

use super::manifold::{ContactPoint, Manifold};
use super::vector::{Frame, Vec2, add, angle_of_tangent, cross, dot, perpendicular, scale, sub};
use crate::colliders::RIM_FRICTION_COEFFICIENT;

/// Natural frequency, Hz, and damping ratio of contacts with fixed bodies.
const CONTACT_FREQUENCY_HZ: f64 = 60.0;
const CONTACT_DAMPING_RATIO: f64 = 10.0;
/// Largest speed at which penetration is removed, m/s.
const MAX_CORRECTION_M_PER_S: f64 = 3.0;
/// Softness of a rigid contact.
const RIGID: [f64; 2] = [1.0; 2];
/// Iterations of normal and friction impulses without bias.
const STABILISATION_ITERATIONS: usize = 4;
/// Least determinant of the matrix of two points, relative to the product of its diagonal, at which both are solved together.
const MIN_PAIR_DETERMINANT: f64 = 0.01;

/// Motion and mass properties of the body in a step. Velocities are those of the mass centre, world axes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Motion {
    /// Pose of a frame at the mass centre.
    pub frame: Frame,
    pub velocity: Vec2,
    pub spin: f64,
    /// Angle turned in the step, rad.
    pub turn: f64,
    pub inverse_mass: f64,
    pub inverse_inertia: f64,
}

impl Motion {
    /// Change the velocities by an impulse along `direction` that changes the spin by `angular` per impulse.
    #[inline(always)]
    fn apply(&mut self, direction: Vec2, angular: f64, impulse: f64) {
        self.velocity = add(self.velocity, scale(direction, self.inverse_mass * impulse));
        self.spin += angular * impulse;
    }

    pub fn integrate(&mut self, dt: f64) {
        let [cos, sin] = self.frame.rotation;
        let turn = self.spin * dt;
        let [re, im] = [cos - turn * sin, sin + turn * cos];
        let length = (re * re + im * im).sqrt();
        self.frame.rotation = [re / length, im / length];
        self.frame.origin = add(self.frame.origin, scale(self.velocity, dt));
        self.turn = angle_of_tangent(turn);
    }
}

/// Length of a step, s, and distance below which points are in contact, m.
#[derive(Clone, Copy, Debug)]
pub(super) struct Span {
    pub dt: f64,
    pub limit: f64,
}

/// Softness of contacts at a step length.
#[derive(Clone, Copy, Debug)]
pub(super) struct Softness {
    pub dt: f64,
    inverse_dt: f64,
    /// Speed of correction per depth, 1/s.
    correction_rate: f64,
    /// Factor of soft impulses, and its inverse.
    factor: [f64; 2],
}

/// What a manifold does in a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Activity {
    /// It has no points in contact.
    Apart,
    /// It has points in contact, but they are not reached in the step.
    Idle,
    /// It may cause impulses.
    Pressing,
}

/// Distance of a point from an obstacle in addition to its motion in a step, above which it causes no impulse, m.
const IDLE_MARGIN_M: f64 = 1e-4;

impl Softness {
    pub fn new(dt: f64) -> Self {
        let angular = CONTACT_FREQUENCY_HZ * TAU;
        let correction_rate = angular / (dt * angular + 2.0 * CONTACT_DAMPING_RATIO);
        let compliance = 1.0 / (dt * correction_rate) - 1.0;
        let softness = compliance * compliance
            / ((1.0 + compliance) * 4.0 * CONTACT_DAMPING_RATIO * CONTACT_DAMPING_RATIO);
        let factor = [1.0 / (1.0 + softness), 1.0 + softness];
        Self { dt, inverse_dt: 1.0 / dt, correction_rate, factor }
    }
}

/// Constraints of one manifold.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Constraint {
    /// Index of the manifold.
    pub manifold: usize,
    /// Unit direction of normal impulses on the body, world axes.
    direction: Vec2,
    points: [PointConstraint; 2],
    count: usize,
    /// Velocity of one point along the normal per impulse at the other.
    coupling: f64,
    /// Whether the two points are solved together.
    is_pair: bool,
    /// Inverse determinant of the pair's matrix without softness, and with the present softness; zero if that is singular.
    inverse_determinant: f64,
    soft_inverse_determinant: f64,
}

#[derive(Clone, Copy, Debug, Default)]
struct PointConstraint {
    /// Index of the point in its manifold.
    index: usize,
    /// Vector from the mass centre to the contact at the start, body axes and world axes.
    local_arm: Vec2,
    arm: Vec2,
    /// Distance at the start, m.
    distance: f64,
    normal: Row,
    friction: Row,
    /// Required change of the normal velocity, m/s.
    bias: f64,
    /// Factor of soft impulses, and its inverse.
    softness: [f64; 2],
}

/// One direction of impulses at a point.
#[derive(Clone, Copy, Debug, Default)]
struct Row {
    /// Torque, and change of the spin, per impulse.
    torque: f64,
    spin: f64,
    /// Mass that an impulse accelerates, kg, and its inverse.
    mass: f64,
    inverse_mass: f64,
    impulse: f64,
}

impl Row {
    fn new(arm: Vec2, direction: Vec2, motion: &Motion, impulse: f64) -> Self {
        let torque = cross(arm, direction);
        let spin = motion.inverse_inertia * torque;
        let inverse_mass = motion.inverse_mass + spin * torque;
        Self { torque, spin, mass: 1.0 / inverse_mass, inverse_mass, impulse }
    }

    #[inline(always)]
    fn velocity(&self, direction: Vec2, motion: &Motion) -> f64 {
        dot(direction, motion.velocity) + self.torque * motion.spin
    }

    /// Returns whether the impulse changed.
    #[inline(always)]
    fn change_to(&mut self, impulse: f64, direction: Vec2, motion: &mut Motion) -> bool {
        let change = impulse - self.impulse;
        self.impulse = impulse;
        motion.apply(direction, self.spin, change);
        change != 0.0
    }
}

impl Constraint {
    /// Set to the points of a manifold in contact. `object` is the object frame.
    pub fn set(&mut self, manifold: &Manifold, object: &Frame, motion: &Motion, span: Span) {
        self.direction = scale(object.rotate(manifold.normal), -1.0);
        self.count = 0;
        for (k, point) in manifold.points[..manifold.count].iter().enumerate() {
            if manifold.activity_of(point, object, motion, span) != Activity::Apart {
                self.push(k, point, object, motion);
            }
        }
        self.is_pair = false;
        if self.count == 2 {
            let [a, b] = &self.points;
            self.coupling = motion.inverse_mass + a.normal.spin * b.normal.torque;
            let product = a.normal.inverse_mass * b.normal.inverse_mass;
            let determinant = product - self.coupling * self.coupling;
            self.is_pair = determinant > MIN_PAIR_DETERMINANT * product;
            self.inverse_determinant = 1.0 / determinant;
        }
    }

    fn push(&mut self, index: usize, point: &ContactPoint, object: &Frame, motion: &Motion) {
        let (on_object, normal) = (object.to_world(point.on_object), scale(self.direction, -1.0));
        let shift = dot(sub(point.on_obstacle, on_object), normal) - point.distance;
        let middle = scale(add(add(on_object, scale(normal, shift)), point.on_obstacle), 0.5);
        let arm = sub(middle, motion.frame.origin);
        self.points[self.count] = PointConstraint {
            index,
            local_arm: motion.frame.rotate_back(arm),
            arm,
            distance: point.distance,
            normal: Row::new(arm, self.direction, motion, point.impulse),
            friction: Row::new(arm, perpendicular(self.direction), motion, point.friction_impulse),
            ..PointConstraint::default()
        };
        self.count += 1;
    }

    fn warm_start(&mut self, motion: &mut Motion, softness: &Softness) {
        let tangent = perpendicular(self.direction);
        for point in &mut self.points[..self.count] {
            let correction = (point.distance * softness.correction_rate).clamp(-MAX_CORRECTION_M_PER_S, 0.0);
            point.bias = point.distance.max(0.0) * softness.inverse_dt + correction;
            point.softness = if point.distance <= 0.0 { softness.factor } else { RIGID };
            motion.apply(self.direction, point.normal.spin, point.normal.impulse);
        }
        for point in &self.points[..self.count] {
            motion.apply(tangent, point.friction.spin, point.friction.impulse);
        }
        if self.is_pair {
            let [a, b] = self.points.map(|point| point.normal.inverse_mass * point.softness[1]);
            let determinant = a * b - self.coupling * self.coupling;
            self.soft_inverse_determinant = if determinant > 0.0 { 1.0 / determinant } else { 0.0 };
        }
    }

    /// Bias after the integration of the pose: only approach to a separated contact is limited.
    fn remove_bias(&mut self, moved: Vec2, motion: &Motion, softness: &Softness) {
        for point in &mut self.points[..self.count] {
            let displaced = sub(add(moved, motion.frame.rotate(point.local_arm)), point.arm);
            let distance = point.distance + dot(displaced, self.direction);
            point.bias = distance.max(0.0) * softness.inverse_dt;
            point.softness = RIGID;
        }
        self.soft_inverse_determinant = self.inverse_determinant;
    }

    /// Returns whether an impulse changed.
    fn solve_normal(&mut self, motion: &mut Motion) -> bool {
        let (direction, mut changes) = (self.direction, false);
        if self.count == 2 && self.is_pair {
            let impulses = self.solve_pair(motion);
            for (point, impulse) in self.points.iter_mut().zip(impulses) {
                changes |= point.normal.change_to(impulse, direction, motion);
            }
            return changes;
        }
        for point in &mut self.points[..self.count] {
            let velocity = point.normal.velocity(direction, motion) + point.bias;
            let impulse = point.softness[0] * (point.normal.impulse - point.normal.mass * velocity).max(0.0);
            changes |= point.normal.change_to(impulse, direction, motion);
        }
        changes
    }

    /// Returns whether an impulse changed.
    fn solve_friction(&mut self, motion: &mut Motion) -> bool {
        let (tangent, mut changes) = (perpendicular(self.direction), false);
        for point in &mut self.points[..self.count] {
            let limit = RIM_FRICTION_COEFFICIENT * point.normal.impulse;
            let velocity = point.friction.velocity(tangent, motion);
            let impulse = (point.friction.impulse - point.friction.mass * velocity).clamp(-limit, limit);
            changes |= point.friction.change_to(impulse, tangent, motion);
        }
        changes
    }

    /// Normal impulses of two points: the solution λ ≥ 0 of the linear complementarity problem `0 ≤ λ ⟂ K λ + b ≥ 0`,
    /// with the diagonal of K divided by the softness.
    fn solve_pair(&self, motion: &Motion) -> Vec2 {
        let ([p, q], coupling) = (&self.points, self.coupling);
        let impulse = [p.normal.impulse, q.normal.impulse];
        let velocity = [p, q].map(|point| point.normal.velocity(self.direction, motion) + point.bias);
        let b = [
            velocity[0] - p.normal.inverse_mass * impulse[0] - coupling * impulse[1],
            velocity[1] - coupling * impulse[0] - q.normal.inverse_mass * impulse[1],
        ];
        let soft = [p, q].map(|point| point.normal.inverse_mass * point.softness[1]);
        let both = [coupling * b[1] - soft[1] * b[0], coupling * b[0] - soft[0] * b[1]];
        if self.soft_inverse_determinant > 0.0 && both[0] >= 0.0 && both[1] >= 0.0 {
            return scale(both, self.soft_inverse_determinant);
        }
        let first = -b[0] * p.normal.mass * p.softness[0];
        if first >= 0.0 && b[1] + coupling * first >= 0.0 {
            return [first, 0.0];
        }
        let second = -b[1] * q.normal.mass * q.softness[0];
        if second >= 0.0 && b[0] + coupling * second >= 0.0 {
            return [0.0, second];
        }
        if b[0] >= 0.0 && b[1] >= 0.0 { [0.0; 2] } else { impulse }
    }

    /// Store the impulses for the next step.
    pub fn store(&self, manifold: &mut Manifold) {
        for point in &self.points[..self.count] {
            let stored = &mut manifold.points[point.index];
            (stored.impulse, stored.friction_impulse) = (point.normal.impulse, point.friction.impulse);
        }
    }
}

/// Solve all constraints of a step, and integrate the pose.
pub(super) fn solve(constraints: &mut [Constraint], motion: &mut Motion, softness: &Softness) {
    for constraint in &mut *constraints {
        constraint.warm_start(motion, softness);
    }
    for constraint in &mut *constraints {
        constraint.solve_normal(motion);
    }
    let start = motion.frame.origin;
    motion.integrate(softness.dt);
    let moved = sub(motion.frame.origin, start);
    for constraint in &mut *constraints {
        constraint.remove_bias(moved, motion, softness);
    }
    for _ in 0..STABILISATION_ITERATIONS {
        let mut changes = false;
        for constraint in &mut *constraints {
            changes |= constraint.solve_normal(motion);
            changes |= constraint.solve_friction(motion);
        }
        // The iterations that follow would repeat this one.
        if !changes {
            break;
        }
    }
}

impl Manifold {
    /// What the points do in a step.
    pub fn activity(&self, object: &Frame, motion: &Motion, span: Span) -> Activity {
        let mut activity = Activity::Apart;
        for point in &self.points[..self.count] {
            match self.activity_of(point, object, motion, span) {
                Activity::Apart => {}
                Activity::Idle if activity == Activity::Apart => activity = Activity::Idle,
                Activity::Idle => {}
                Activity::Pressing => return Activity::Pressing,
            }
        }
        activity
    }

    fn activity_of(&self, point: &ContactPoint, object: &Frame, motion: &Motion, span: Span) -> Activity {
        let has_impulse = point.impulse != 0.0 || point.friction_impulse != 0.0;
        if point.distance < span.limit && (has_impulse || point.distance < IDLE_MARGIN_M) {
            return Activity::Pressing;
        }
        let arm = sub(object.to_world(point.on_object), motion.frame.origin);
        let velocity = add(motion.velocity, scale(perpendicular(arm), motion.spin));
        let approach = dot(velocity, object.rotate(self.normal)) * span.dt;
        if point.distance >= span.limit && point.distance - approach >= span.limit {
            return Activity::Apart;
        }
        // The bias after the integration needs twice the approach; the rest covers the curvature of the path.
        let turn = motion.spin * span.dt;
        let reach = 3.0 * approach.max(0.0) + turn * turn * (arm[0].abs() + arm[1].abs()) + IDLE_MARGIN_M;
        if has_impulse || point.distance < reach { Activity::Pressing } else { Activity::Idle }
    }
}
