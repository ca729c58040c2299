//! The linear system of an implicit step if the mass properties depend on parameters or time.
//!
//! It uses plain arithmetic in numbers with derivatives. [`crate::implicit`] is three times as fast but requires
//! constant mass properties.

use crate::heading::Heading;
use crate::implicit::{MassMatrix, Solved};
use crate::symmetric::Symmetric;
use crate::{GeneralisedForce, Real, Rigid};

/// Mass matrix of a body with variable mass properties. A rail blocks some directions.
#[derive(Clone, Copy, Debug)]
pub(crate) struct VariableMassMatrix<T> {
    rigid: Rigid<T>,
    /// Diagonal of `G = diag(1, 1, ρ)`, with `u = G v`; 0 in blocked directions.
    g: [T; 3],
    /// Diagonal of `G⁻¹`; 0 in blocked directions.
    g_inverse: [T; 3],
}

impl<T: Real> VariableMassMatrix<T> {
    pub fn new(rigid: Rigid<T>, dof: [bool; 3]) -> Self {
        let gyration = (rigid.inertia / rigid.mass).sqrt();
        let one = T::lift(1.0);
        let free = |along: [T; 3]| [0, 1, 2].map(|k| if dof[k] { along[k] } else { T::zero() });
        Self { rigid, g: free([one, one, gyration]), g_inverse: free([one, one, gyration.recip()]) }
    }

    /// Scaled damping `C` and scaled force `q` of a step, about the mass centre.
    fn scale_force(&self, force: &GeneralisedForce<T>, h: f64) -> ([T; 6], [T; 3]) {
        let ([cx, cy], k) = (self.rigid.com, self.rigid.mass.recip() * h);
        let [xx, xy, yy, tx, ty, tt] = force.damping;
        let (sx, sy) = (tx + xx * cy - xy * cx, ty + xy * cy - yy * cx);
        let spin = tt + tx * cy - ty * cx + sx * cy - sy * cx;
        let [fx, fy, torque] = force.force;
        let wrench = [fx, fy, torque + fx * cy - fy * cx];
        let [a, b, c] = self.g_inverse;
        let damping = [xx * a * a, xy * a * b, yy * b * b, sx * a * c, sy * b * c, spin * c * c];
        (damping.map(|d| d * k), [wrench[0] * a * k, wrench[1] * b * k, wrench[2] * c * k])
    }

    fn scaled(&self, v: [T; 3], by: [T; 3]) -> [T; 3] {
        [v[0] * by[0], v[1] * by[1], v[2] * by[2]]
    }
}

impl<T: Real> MassMatrix<T> for VariableMassMatrix<T> {
    fn centre_offset(&self, heading: Heading<T>) -> [T; 2] {
        let [x, y] = self.rigid.com;
        let [x, y, _] = heading.to_world([x, y, T::zero()]);
        [x, y]
    }

    fn centre_twist(&self, [vx, vy, spin]: [T; 3]) -> [T; 3] {
        let [cx, cy] = self.rigid.com;
        [vx - spin * cy, vy + spin * cx, spin]
    }

    fn origin_twist(&self, [vx, vy, spin]: [T; 3]) -> [T; 3] {
        let [cx, cy] = self.rigid.com;
        [vx + spin * cy, vy - spin * cx, spin]
    }

    fn solve_euler(&self, v: [T; 3], force: &GeneralisedForce<T>, h: f64) -> Solved<T> {
        let (damping, wrench) = self.scale_force(force, h);
        let right = sum(self.scaled(v, self.g), wrench);
        (self.scaled(solve_ldl(plus_identity(damping), right), self.g_inverse), values(&damping))
    }

    fn solve_pade(&self, v: [T; 3], force: &GeneralisedForce<T>, h: f64) -> Solved<T> {
        let (damping, wrench) = self.scale_force(force, h);
        let square = squared(damping);
        let system: [T; 6] = std::array::from_fn(|k| damping[k] + square[k] * 0.5);
        let correction = multiply(damping, wrench).map(|p| p * 0.5);
        let right = sum(self.scaled(v, self.g), sum(wrench, correction));
        (self.scaled(solve_ldl(plus_identity(system), right), self.g_inverse), values(&damping))
    }

    fn velocity_change(&self, v: &[T; 3], damping: Symmetric) -> f64 {
        let along = [0, 1, 2].map(|k| v[k].re() * self.g[k].re());
        damping.multiply(along).map(|u| u * u).iter().sum::<f64>().sqrt()
    }
}

fn sum<T: Real>(a: [T; 3], b: [T; 3]) -> [T; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// Values of a matrix without derivatives.
fn values<T: Real>(matrix: &[T; 6]) -> Symmetric {
    Symmetric(matrix.map(|entry| entry.re()))
}

fn plus_identity<T: Real>([xx, xy, yy, tx, ty, tt]: [T; 6]) -> [T; 6] {
    [xx + 1.0, xy, yy + 1.0, tx, ty, tt + 1.0]
}

/// A symmetric matrix `[xx, xy, yy, xθ, yθ, θθ]` times a vector.
fn multiply<T: Real>([xx, xy, yy, tx, ty, tt]: [T; 6], [x, y, z]: [T; 3]) -> [T; 3] {
    [xx * x + xy * y + tx * z, xy * x + yy * y + ty * z, tx * x + ty * y + tt * z]
}

/// Square of a symmetric matrix.
fn squared<T: Real>(m: [T; 6]) -> [T; 6] {
    let [xx, xy, yy, tx, ty, tt] = m;
    let ([a, b, d], [_, c, e], [_, _, f]) =
        (multiply(m, [xx, xy, tx]), multiply(m, [xy, yy, ty]), multiply(m, [tx, ty, tt]));
    [a, b, c, d, e, f]
}

/// Solution of a symmetric positive definite system by `LDLᵀ` factorisation.
fn solve_ldl<T: Real>([xx, xy, yy, tx, ty, tt]: [T; 6], [x, y, z]: [T; 3]) -> [T; 3] {
    let (d1, l21, l31) = (xx, xy / xx, tx / xx);
    let d2 = yy - l21 * xy;
    let l32 = (ty - l31 * xy) / d2;
    let d3 = tt - l31 * tx - l32 * l32 * d2;
    let y = y - l21 * x;
    let z = z - l31 * x - l32 * y;
    let z = z / d3;
    let y = y / d2 - l32 * z;
    [x / d1 - l21 * y - l31 * z, y, z]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Body;
    use crate::implicit::ConstantMassMatrix;

    #[test]
    fn constant_and_variable_mass_matrices_agree() {
        let corners = [[-0.5, -0.3], [0.7, -0.3], [0.7, 0.5], [-0.5, 0.5]];
        let body = Body::from_footprint(&corners, 22.0).unwrap();
        let rigid = Rigid { mass: 22.0, com: body.com, inertia: body.inertia() };
        let force =
            GeneralisedForce { force: [3.0, -8.0, 2.0], damping: [40.0, 9.0, 120.0, -6.0, 11.0, 30.0] };
        for dof in [[true; 3], [true, false, false]] {
            let (constant, variable) =
                (ConstantMassMatrix::new(22.0, &body, dof, false), VariableMassMatrix::new(rigid, dof));
            for v in [[0.3, -0.2, 0.8], [0.0, 0.5, -1.0]] {
                for (a, b) in [
                    (constant.solve_pade(v, &force, 0.05), variable.solve_pade(v, &force, 0.05)),
                    (constant.solve_euler(v, &force, 0.05), variable.solve_euler(v, &force, 0.05)),
                ] {
                    let gap = (0..3).map(|k| (a.0[k] - b.0[k]).abs()).fold(0.0, f64::max);
                    let apart = (0..6).map(|k| (a.1.0[k] - b.1.0[k]).abs()).fold(0.0, f64::max);
                    assert!(gap < 1e-13 && apart < 1e-13, "{gap} {apart}");
                }
            }
        }
    }
}
