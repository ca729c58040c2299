//! The linear system of a step: velocities after a time under a push and a drag.
//!
//! With `ρ` the radius of gyration and `G = diag(1, 1, ρ)`, in `u = G v` the inertia is `m` alike in
//! every direction, and the drag `m⁻¹ G⁻¹ D G⁻¹` symmetric. Per step of `h`, `C` is that times `h`, and
//! `q = h m⁻¹ G⁻¹ w` the velocity that the push `w` would give.
//!
//! Values are plain numbers. The derivatives of `P(C) u' = r(u, q, C)` are those of an implicit function,
//! `P du' = dr − dP u'`: matrices are never differentiated, only their products with known vectors.

use crate::heading::Heading;
use crate::symmetric::{Symmetric, Vector, less, scaled, sum};
use crate::{Action, Body, Real};

/// What resists a change of velocity: mass, mass centre, gyration, and a rail.
#[derive(Clone, Debug)]
pub(crate) struct Inertia<T> {
    mass: T,
    /// One over it, 1/kg.
    lightness: f64,
    /// Mass centre, object frame, m.
    center: [f64; 2],
    /// Diagonal of `G`; 0 where a rail blocks.
    root: Vector,
    /// One over it, and likewise 0.
    scale: Vector,
    /// Products of `scale`, by which a drag matrix `[xx, xy, yy, xθ, yθ, θθ]` is scaled.
    weight: [f64; 6],
    /// Whether neither mass nor drag carry derivatives: then only the push does.
    flat: bool,
}

/// Drag and push over a step, about the mass centre: `C` and `q`.
#[derive(Clone, Copy)]
struct Load {
    drag: Symmetric,
    push: Vector,
}

/// Velocity of the mass centre after a step, object axes, and the step's `C`.
pub(crate) type Solved<T> = ([T; 3], Symmetric);

/// What a step is solved with: it knows the mass centre and the inertia. Velocities are in object axes.
pub(crate) trait Inert<T> {
    /// The mass centre, from the object origin, world axes, m.
    fn place(&self, heading: Heading<T>) -> [T; 2];
    /// The velocity of the mass centre, from that of the object origin.
    fn at_center(&self, twist: [T; 3]) -> [T; 3];
    /// The velocity of the object origin, from that of the mass centre.
    fn at_origin(&self, twist: [T; 3]) -> [T; 3];
    /// Implicit Euler over `h`: `(I + C) u' = u + q`.
    fn solve_half(&self, v: [T; 3], action: &Action<T>, h: f64) -> Solved<T>;
    /// The (0,2) Padé step over `h`: `(I + C + C²/2) u' = u + q + Cq/2`.
    fn solve(&self, v: [T; 3], action: &Action<T>, h: f64) -> Solved<T>;
    /// What `C` takes of a velocity of the mass centre over a step, `|C G v|`, m/s.
    fn slowed(&self, v: &[T; 3], drag: Symmetric) -> f64;
}

impl<T: Real> Inertia<T> {
    pub fn new(mass: T, body: &Body, dof: [bool; 3], flat: bool) -> Self {
        let along = [1.0, 1.0, body.gyration];
        let free = |of: fn(f64) -> f64| [0, 1, 2].map(|k| if dof[k] { of(along[k]) } else { 0.0 });
        let (root, scale) = (free(|g| g), free(f64::recip));
        let [a, b, c] = scale;
        let weight = [a * a, a * b, b * b, a * c, b * c, c * c];
        Self { mass, lightness: mass.re().recip(), center: body.com, root, scale, weight, flat }
    }

    /// An action about the object origin, moved to the mass centre.
    #[inline(always)]
    fn load(&self, action: &Action<T>, h: f64) -> Load {
        let ([cx, cy], k) = (self.center, h * self.lightness);
        let [xx, xy, yy, tx, ty, tt] = &action.drag;
        let [xx, xy, yy, tx, ty, tt] = [xx.re(), xy.re(), yy.re(), tx.re(), ty.re(), tt.re()];
        // Twist at the origin from the twist at the centre: v_o = v_c + ω (c_y, −c_x).
        let (sx, sy) = (tx + xx * cy - xy * cx, ty + xy * cy - yy * cx);
        let spin = tt + tx * cy - ty * cx + sx * cy - sy * cx;
        let [fx, fy, torque] = values(&action.push);
        let push = scaled([fx, fy, torque + fx * cy - fy * cx], self.scale);
        Load {
            drag: Symmetric(scaled([xx, xy, yy, sx, sy, spin], self.weight)).times(k),
            push: push.map(|p| p * k),
        }
    }

    /// The derivatives of `q` where only the push has any.
    #[inline(always)]
    fn pushed(&self, [px, py, torque]: &[T; 3], h: f64) -> [T; 3] {
        let ([cx, cy], k) = (self.center, h * self.lightness);
        let [a, b, c] = self.scale.map(|s| s * k);
        let torque = T::slopes([(*torque, c), (*px, c * cy), (*py, -c * cx)]);
        [T::slopes([(*px, a)]), T::slopes([(*py, b)]), torque]
    }

    /// The derivatives of `share·q − C u` at a fixed `u`.
    #[inline(always)]
    fn slopes(&self, action: &Action<T>, load: Load, h: f64, share: f64, u: Vector) -> [T; 3] {
        let ([cx, cy], k) = (self.center, h * self.lightness);
        let [vx, vy, spin] = scaled(u, self.scale).map(|v| -v * k);
        let (vx, vy) = (vx + spin * cy, vy - spin * cx);
        let ([px, py, pt], [xx, xy, yy, tx, ty, tt]) = (action.push, action.drag);
        let pushed = share * k;
        let fx = T::slopes([(px, pushed), (xx, vx), (xy, vy), (tx, spin)]);
        let fy = T::slopes([(py, pushed), (xy, vx), (yy, vy), (ty, spin)]);
        let parts = [(pt, pushed), (tx, vx), (ty, vy), (tt, spin), (fx, cy), (fy, -cx)];
        let wrench = [fx, fy, T::slopes(parts)];
        let by_mass = less(load.drag.multiply(u), load.push.map(|q| q * share));
        let [a, b, c] = by_mass.map(|m| m * self.lightness);
        let ([fx, fy, torque], [sx, sy, sz]) = (wrench, self.scale);
        [
            T::slopes([(fx, sx), (self.mass, a)]),
            T::slopes([(fy, sy), (self.mass, b)]),
            T::slopes([(torque, sz), (self.mass, c)]),
        ]
    }

    /// A velocity from `u` and its derivatives.
    #[inline(always)]
    fn velocity(&self, u: Vector, slopes: [T; 3]) -> [T; 3] {
        let ([ux, uy, uz], [x, y, z], [a, b, c]) = (u, slopes, self.scale);
        [T::chained(ux * a, [(x, a)]), T::chained(uy * b, [(y, b)]), T::chained(uz * c, [(z, c)])]
    }
}

impl<T: Real> Inert<T> for Inertia<T> {
    #[inline(always)]
    fn place(&self, heading: Heading<T>) -> [T; 2] {
        heading.place(self.center)
    }

    /// Implicit Euler over `h`: `(I + C) u' = u + q`.
    #[inline(always)]
    fn solve_half(&self, v: [T; 3], action: &Action<T>, h: f64) -> Solved<T> {
        let load = self.load(action, h);
        let factors = load.drag.plus_identity().factors();
        let start = scaled(values(&v), self.root);
        let end = factors.solve(sum(start, load.push));
        let ([vx, vy, vz], [a, b, c]) = (v, self.root);
        let [x, y, z] =
            if self.flat { self.pushed(&action.push, h) } else { self.slopes(action, load, h, 1.0, end) };
        let right =
            [T::slopes([(vx, a), (x, 1.0)]), T::slopes([(vy, b), (y, 1.0)]), T::slopes([(vz, c), (z, 1.0)])];
        (self.velocity(end, factors.solve_slopes(right)), load.drag)
    }

    /// The (0,2) Padé step over `h`: `(I + C + C²/2) u' = u + q + Cq/2`. On a blocked direction the
    /// velocity is zero and stays so.
    ///
    /// With `e = dq − dC u'` and `y = (q − C u')/2`, its derivatives are those of
    /// `P du' = du + (I + C/2) e + dC y`.
    #[inline(always)]
    fn solve(&self, v: [T; 3], action: &Action<T>, h: f64) -> Solved<T> {
        let load = self.load(action, h);
        let half = load.drag.times(0.5);
        let factors = load.drag.plus(load.drag.squared().times(0.5)).plus_identity().factors();
        let start = scaled(values(&v), self.root);
        let end = factors.solve(sum(start, sum(load.push, half.multiply(load.push))));
        let rows = half.plus_identity().rows();
        let ([vx, vy, vz], [a, b, c], [p, q, r]) = (v, self.root, rows);
        let right = if self.flat {
            let gain = self.pushed(&action.push, h);
            [weighed((vx, a), p, gain), weighed((vy, b), q, gain), weighed((vz, c), r, gain)]
        } else {
            let gain = self.slopes(action, load, h, 1.0, end);
            let missed = less(load.drag.multiply(end), load.push).map(|y| 0.5 * y);
            let [x, y, z] = self.slopes(action, load, h, 0.0, missed);
            let bent = |v: T, root: f64, bend: T| (T::slopes([(v, root), (bend, 1.0)]), 1.0);
            let (vx, vy, vz) = (bent(vx, a, x), bent(vy, b, y), bent(vz, c, z));
            [weighed(vx, p, gain), weighed(vy, q, gain), weighed(vz, r, gain)]
        };
        (self.velocity(end, factors.solve_slopes(right)), load.drag)
    }

    #[inline(always)]
    fn slowed(&self, v: &[T; 3], drag: Symmetric) -> f64 {
        drag.multiply(scaled(values(v), self.root)).map(|u| u * u).iter().sum::<f64>().sqrt()
    }

    /// The velocity of the mass centre, from that of the object origin, object axes.
    #[inline(always)]
    fn at_center(&self, [vx, vy, spin]: [T; 3]) -> [T; 3] {
        shifted([vx, vy, spin], self.center)
    }

    /// The velocity of the object origin, from that of the mass centre, object axes.
    #[inline(always)]
    fn at_origin(&self, twist: [T; 3]) -> [T; 3] {
        shifted(twist, self.center.map(|c| -c))
    }
}

/// The velocity of a point `[x, y]` from where it is known.
#[inline(always)]
fn shifted<T: Real>([vx, vy, spin]: [T; 3], [x, y]: [f64; 2]) -> [T; 3] {
    let turn = spin.re();
    let vx = T::chained(vx.re() - turn * y, [(vx, 1.0), (spin, -y)]);
    [vx, T::chained(vy.re() + turn * x, [(vy, 1.0), (spin, x)]), spin]
}

/// The derivatives of a number, and of three by a row of weights.
#[inline(always)]
fn weighed<T: Real>(one: (T, f64), [a, b, c]: Vector, [x, y, z]: [T; 3]) -> T {
    T::slopes([one, (x, a), (y, b), (z, c)])
}

/// Values without their derivatives.
#[inline(always)]
fn values<T: Real>([x, y, z]: &[T; 3]) -> Vector {
    [x.re(), y.re(), z.re()]
}
