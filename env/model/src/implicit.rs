//! The linear system of an implicit step: the velocity after a time `h` under a force and damping.
//!
//! Let `ρ` be the radius of gyration, `G = diag(1, 1, ρ)` and `u = G v`. In these coordinates the mass matrix is `m I`.
//! The scaled damping of a step is the symmetric matrix `C = h m⁻¹ G⁻¹ D G⁻¹`, and the scaled force `q = h m⁻¹ G⁻¹ w`
//! is the change of velocity that the wrench `w` causes without damping.
//!
//! Values are computed in `f64`. The derivatives of `P(C) u' = r(u, q, C)` follow from the implicit function theorem,
//! `P du' = dr − dP u'`. Only products of matrix derivatives with known vectors are needed.

use crate::heading::Heading;
use crate::symmetric::{Symmetric, Vector, difference, product, sum};
use crate::{Body, GeneralisedForce, Real};

/// Mass matrix of a body whose mass centre and radius of gyration are constant. A rail blocks some directions.
#[derive(Clone, Debug)]
pub(crate) struct ConstantMassMatrix<T> {
    mass: T,
    /// Inverse mass, 1/kg.
    inverse_mass: f64,
    /// Mass centre, object frame, m.
    center: [f64; 2],
    /// Diagonal of `G`; 0 in blocked directions.
    g: Vector,
    /// Diagonal of `G⁻¹`; 0 in blocked directions.
    g_inverse: Vector,
    /// Products of entries of `G⁻¹` that scale a damping matrix `[xx, xy, yy, xθ, yθ, θθ]`.
    g_products: [f64; 6],
    /// Whether neither mass nor damping carries derivatives, so that only the force does.
    is_constant: bool,
}

/// Scaled damping `C` and scaled force `q` of a step, about the mass centre.
#[derive(Clone, Copy)]
struct ScaledForce {
    damping: Symmetric,
    velocity: Vector,
}

/// Velocity of the mass centre after a step, object axes, and the step's `C`.
pub(crate) type Solved<T> = ([T; 3], Symmetric);

/// Mass matrix and mass centre with which a step is solved. Velocities are in object axes.
pub(crate) trait MassMatrix<T> {
    /// Offset of the mass centre from the object origin, world axes, m.
    fn centre_offset(&self, heading: Heading<T>) -> [T; 2];
    /// Twist at the mass centre, given the twist at the object origin.
    fn centre_twist(&self, twist: [T; 3]) -> [T; 3];
    /// Twist at the object origin, given the twist at the mass centre.
    fn origin_twist(&self, twist: [T; 3]) -> [T; 3];
    /// Implicit Euler over `h`: `(I + C) u' = u + q`.
    fn solve_euler(&self, v: [T; 3], force: &GeneralisedForce<T>, h: f64) -> Solved<T>;
    /// The (0,2) Padé step over `h`: `(I + C + C²/2) u' = u + q + Cq/2`.
    fn solve_pade(&self, v: [T; 3], force: &GeneralisedForce<T>, h: f64) -> Solved<T>;
    /// Change of a velocity `v` of the mass centre by the scaled damping `C`, `|C G v|`, m/s.
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

    /// Scale a generalised force about the object origin and move it to the mass centre.
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

    /// Derivatives of `q` if only the force has derivatives.
    #[inline(always)]
    fn force_slopes(&self, [px, py, torque]: &[T; 3], h: f64) -> [T; 3] {
        let ([cx, cy], k) = (self.center, h * self.inverse_mass);
        let [a, b, c] = self.g_inverse.map(|s| s * k);
        let torque = T::slopes([(*torque, c), (*px, c * cy), (*py, -c * cx)]);
        [T::slopes([(*px, a)]), T::slopes([(*py, b)]), torque]
    }

    /// Derivatives of `share·q − C u` at fixed `u`.
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

    /// Velocity `v = G⁻¹ u` with its derivatives.
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

    /// In blocked directions the velocity stays zero.
    ///
    /// With `e = dq − dC u'` and `y = (q − C u')/2`, the derivatives solve `P du' = du + (I + C/2) e + dC y`.
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

    #[inline(always)]
    fn centre_twist(&self, [vx, vy, spin]: [T; 3]) -> [T; 3] {
        shift_twist([vx, vy, spin], self.center)
    }

    #[inline(always)]
    fn origin_twist(&self, twist: [T; 3]) -> [T; 3] {
        shift_twist(twist, self.center.map(|c| -c))
    }
}

/// Twist at a point offset by `[x, y]` from the point where `twist` is given.
#[inline(always)]
fn shift_twist<T: Real>([vx, vy, spin]: [T; 3], [x, y]: [f64; 2]) -> [T; 3] {
    let turn = spin.re();
    let vx = T::chained(vx.re() - turn * y, [(vx, 1.0), (spin, -y)]);
    [vx, T::chained(vy.re() + turn * x, [(vy, 1.0), (spin, x)]), spin]
}

/// Derivatives of a scaled number plus a weighted sum of three.
#[inline(always)]
fn row_slopes<T: Real>(one: (T, f64), [a, b, c]: Vector, [x, y, z]: [T; 3]) -> T {
    T::slopes([one, (x, a), (y, b), (z, c)])
}

/// Values without their derivatives.
#[inline(always)]
fn values<T: Real>([x, y, z]: &[T; 3]) -> Vector {
    [x.re(), y.re(), z.re()]
}
