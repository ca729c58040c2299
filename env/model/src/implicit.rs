//! The linear system of a step: velocities after a time under a push and a drag.
//!
//! With `ρ` the radius of gyration and `G = diag(1, 1, ρ)`, in `u = G v` the inertia is `m` alike in
//! every direction, and the drag `m⁻¹ G⁻¹ D G⁻¹` symmetric. Per step of `h`, `C` is that times `h`, and
//! `q = h m⁻¹ G⁻¹ w` the velocity that the push `w` would give.
//!
//! Values are plain numbers. The derivatives of `P(C) u' = r(u, q, C)` are those of an implicit function,
//! `P du' = dr − dP u'`: matrices are never differentiated, only their products with known vectors.

use crate::heading::Heading;
use crate::symmetric::{Symmetric, Vector, difference, product, sum};
use crate::{Body, GeneralisedForce, Real};

/// What resists a change of velocity: mass, mass centre, gyration, and a rail.
#[derive(Clone, Debug)]
pub(crate) struct ConstantMassMatrix<T> {
    mass: T,
    /// One over it, 1/kg.
    inverse_mass: f64,
    /// Mass centre, object frame, m.
    center: [f64; 2],
    /// Diagonal of `G`; 0 where a rail blocks.
    g: Vector,
    /// One over it, and likewise 0.
    g_inverse: Vector,
    /// Products of `scale`, by which a drag matrix `[xx, xy, yy, xθ, yθ, θθ]` is scaled.
    g_products: [f64; 6],
    /// Whether neither mass nor drag carry derivatives: then only the push does.
    is_constant: bool,
}

/// Drag and push over a step, about the mass centre: `C` and `q`.
#[derive(Clone, Copy)]
struct ScaledForce {
    damping: Symmetric,
    velocity: Vector,
}

/// Velocity of the mass centre after a step, object axes, and the step's `C`.
pub(crate) type Solved<T> = ([T; 3], Symmetric);

/// What a step is solved with: it knows the mass centre and the inertia. Velocities are in object axes.
pub(crate) trait MassMatrix<T> {
    /// The mass centre, from the object origin, world axes, m.
    fn centre_offset(&self, heading: Heading<T>) -> [T; 2];
    /// The velocity of the mass centre, from that of the object origin.
    fn centre_twist(&self, twist: [T; 3]) -> [T; 3];
    /// The velocity of the object origin, from that of the mass centre.
    fn origin_twist(&self, twist: [T; 3]) -> [T; 3];
    /// Implicit Euler over `h`: `(I + C) u' = u + q`.
    fn solve_euler(&self, v: [T; 3], force: &GeneralisedForce<T>, h: f64) -> Solved<T>;
    /// The (0,2) Padé step over `h`: `(I + C + C²/2) u' = u + q + Cq/2`.
    fn solve_pade(&self, v: [T; 3], force: &GeneralisedForce<T>, h: f64) -> Solved<T>;
    /// What `C` takes of a velocity of the mass centre over a step, `|C G v|`, m/s.
    fn velocity_change(&self, v: &[T; 3], damping: Symmetric) -> f64;
}

impl<T: Real> ConstantMassMatrix<T> {
    pub fn new(mass: T, body: &Body, dof: [bool; 3], is_constant: bool) -> Self {
        let along = [1.0, 1.0, body.gyration];
        let free = |of: fn(f64) -> f64| [0, 1, 2].map(|k| if dof[k] { of(along[k]) } else { 0.0 });
        let (g, g_inverse) = (free(|g| g), free(f64::recip));
        let [a, b, c] = g_inverse;
        let g_products = [a * a, a * b, b * b, a * c, b * c, c * c];
        Self {
            mass,
            inverse_mass: mass.re().recip(),
            center: body.com,
            g,
            g_inverse,
            g_products,
            is_constant,
        }
    }

    /// An force about the object origin, moved to the mass centre.
    #[inline(always)]
    fn scale_force(&self, force: &GeneralisedForce<T>, h: f64) -> ScaledForce {
        let ([cx, cy], k) = (self.center, h * self.inverse_mass);
        let [xx, xy, yy, tx, ty, tt] = &force.damping;
        let [xx, xy, yy, tx, ty, tt] = [xx.re(), xy.re(), yy.re(), tx.re(), ty.re(), tt.re()];
        // Twist at the origin from the twist at the centre: v_o = v_c + ω (c_y, −c_x).
        let (sx, sy) = (tx + xx * cy - xy * cx, ty + xy * cy - yy * cx);
        let spin = tt + tx * cy - ty * cx + sx * cy - sy * cx;
        let [fx, fy, torque] = values(&force.force);
        let wrench = product([fx, fy, torque + fx * cy - fy * cx], self.g_inverse);
        ScaledForce {
            damping: Symmetric(product([xx, xy, yy, sx, sy, spin], self.g_products)).times(k),
            velocity: wrench.map(|p| p * k),
        }
    }

    /// The derivatives of `q` where only the push has any.
    #[inline(always)]
    fn force_slopes(&self, [px, py, torque]: &[T; 3], h: f64) -> [T; 3] {
        let ([cx, cy], k) = (self.center, h * self.inverse_mass);
        let [a, b, c] = self.g_inverse.map(|s| s * k);
        let torque = T::slopes([(*torque, c), (*px, c * cy), (*py, -c * cx)]);
        [T::slopes([(*px, a)]), T::slopes([(*py, b)]), torque]
    }

    /// The derivatives of `share·q − C u` at a fixed `u`.
    #[inline(always)]
    fn slopes(
        &self,
        force: &GeneralisedForce<T>,
        scaled_force: ScaledForce,
        h: f64,
        share: f64,
        u: Vector,
    ) -> [T; 3] {
        let ([cx, cy], k) = (self.center, h * self.inverse_mass);
        let [vx, vy, spin] = product(u, self.g_inverse).map(|v| -v * k);
        let (vx, vy) = (vx + spin * cy, vy - spin * cx);
        let ([px, py, pt], [xx, xy, yy, tx, ty, tt]) = (force.force, force.damping);
        let by_force = share * k;
        let fx = T::slopes([(px, by_force), (xx, vx), (xy, vy), (tx, spin)]);
        let fy = T::slopes([(py, by_force), (xy, vx), (yy, vy), (ty, spin)]);
        let parts = [(pt, by_force), (tx, vx), (ty, vy), (tt, spin), (fx, cy), (fy, -cx)];
        let wrench = [fx, fy, T::slopes(parts)];
        let by_mass = difference(scaled_force.damping.multiply(u), scaled_force.velocity.map(|q| q * share));
        let [a, b, c] = by_mass.map(|m| m * self.inverse_mass);
        let ([fx, fy, torque], [sx, sy, sz]) = (wrench, self.g_inverse);
        [
            T::slopes([(fx, sx), (self.mass, a)]),
            T::slopes([(fy, sy), (self.mass, b)]),
            T::slopes([(torque, sz), (self.mass, c)]),
        ]
    }

    /// A velocity from `u` and its derivatives.
    #[inline(always)]
    fn velocity(&self, u: Vector, slopes: [T; 3]) -> [T; 3] {
        let ([ux, uy, uz], [x, y, z], [a, b, c]) = (u, slopes, self.g_inverse);
        [T::chained(ux * a, [(x, a)]), T::chained(uy * b, [(y, b)]), T::chained(uz * c, [(z, c)])]
    }
}

impl<T: Real> MassMatrix<T> for ConstantMassMatrix<T> {
    #[inline(always)]
    fn centre_offset(&self, heading: Heading<T>) -> [T; 2] {
        heading.rotate_point(self.center)
    }

    /// Implicit Euler over `h`: `(I + C) u' = u + q`.
    #[inline(always)]
    fn solve_euler(&self, v: [T; 3], force: &GeneralisedForce<T>, h: f64) -> Solved<T> {
        let scaled_force = self.scale_force(force, h);
        let factors = scaled_force.damping.plus_identity().factors();
        let start = product(values(&v), self.g);
        let end = factors.solve(sum(start, scaled_force.velocity));
        let ([vx, vy, vz], [a, b, c]) = (v, self.g);
        let [x, y, z] = if self.is_constant {
            self.force_slopes(&force.force, h)
        } else {
            self.slopes(force, scaled_force, h, 1.0, end)
        };
        let right =
            [T::slopes([(vx, a), (x, 1.0)]), T::slopes([(vy, b), (y, 1.0)]), T::slopes([(vz, c), (z, 1.0)])];
        (self.velocity(end, factors.solve_slopes(right)), scaled_force.damping)
    }

    /// The (0,2) Padé step over `h`: `(I + C + C²/2) u' = u + q + Cq/2`. On a blocked direction the
    /// velocity is zero and stays so.
    ///
    /// With `e = dq − dC u'` and `y = (q − C u')/2`, its derivatives are those of
    /// `P du' = du + (I + C/2) e + dC y`.
    #[inline(always)]
    fn solve_pade(&self, v: [T; 3], force: &GeneralisedForce<T>, h: f64) -> Solved<T> {
        let scaled_force = self.scale_force(force, h);
        let half = scaled_force.damping.times(0.5);
        let factors =
            scaled_force.damping.plus(scaled_force.damping.squared().times(0.5)).plus_identity().factors();
        let start = product(values(&v), self.g);
        let end = factors.solve(sum(start, sum(scaled_force.velocity, half.multiply(scaled_force.velocity))));
        let rows = half.plus_identity().rows();
        let ([vx, vy, vz], [a, b, c], [p, q, r]) = (v, self.g, rows);
        let right = if self.is_constant {
            let gain = self.force_slopes(&force.force, h);
            [row_slopes((vx, a), p, gain), row_slopes((vy, b), q, gain), row_slopes((vz, c), r, gain)]
        } else {
            let gain = self.slopes(force, scaled_force, h, 1.0, end);
            let y = difference(scaled_force.damping.multiply(end), scaled_force.velocity).map(|y| 0.5 * y);
            let [x, y, z] = self.slopes(force, scaled_force, h, 0.0, y);
            let start = |v: T, root: f64, correction: T| (T::slopes([(v, root), (correction, 1.0)]), 1.0);
            let (vx, vy, vz) = (start(vx, a, x), start(vy, b, y), start(vz, c, z));
            [row_slopes(vx, p, gain), row_slopes(vy, q, gain), row_slopes(vz, r, gain)]
        };
        (self.velocity(end, factors.solve_slopes(right)), scaled_force.damping)
    }

    #[inline(always)]
    fn velocity_change(&self, v: &[T; 3], damping: Symmetric) -> f64 {
        damping.multiply(product(values(v), self.g)).map(|u| u * u).iter().sum::<f64>().sqrt()
    }

    /// The velocity of the mass centre, from that of the object origin, object axes.
    #[inline(always)]
    fn centre_twist(&self, [vx, vy, spin]: [T; 3]) -> [T; 3] {
        shift_twist([vx, vy, spin], self.center)
    }

    /// The velocity of the object origin, from that of the mass centre, object axes.
    #[inline(always)]
    fn origin_twist(&self, twist: [T; 3]) -> [T; 3] {
        shift_twist(twist, self.center.map(|c| -c))
    }
}

/// The velocity of a point `[x, y]` from where it is known.
#[inline(always)]
fn shift_twist<T: Real>([vx, vy, spin]: [T; 3], [x, y]: [f64; 2]) -> [T; 3] {
    let turn = spin.re();
    let vx = T::chained(vx.re() - turn * y, [(vx, 1.0), (spin, -y)]);
    [vx, T::chained(vy.re() + turn * x, [(vy, 1.0), (spin, x)]), spin]
}

/// The derivatives of a number, and of three by a row of weights.
#[inline(always)]
fn row_slopes<T: Real>(one: (T, f64), [a, b, c]: Vector, [x, y, z]: [T; 3]) -> T {
    T::slopes([one, (x, a), (y, b), (z, c)])
}

/// Values without their derivatives.
#[inline(always)]
fn values<T: Real>([x, y, z]: &[T; 3]) -> Vector {
    [x.re(), y.re(), z.re()]
}
