//! Symmetric 3 × 3 systems in `f64`, with derivatives propagated through their factors.

use crate::Real;

/// `[x, y, about z]`.
pub(crate) type Vector = [f64; 3];

/// A symmetric matrix `[xx, xy, yy, xz, yz, zz]`.
#[derive(Clone, Copy)]
pub(crate) struct Symmetric(pub [f64; 6]);

impl Symmetric {
    #[inline(always)]
    pub fn times(self, by: f64) -> Self {
        Self(self.0.map(|a| a * by))
    }

    #[inline(always)]
    pub fn plus(self, other: Self) -> Self {
        Self(sum(self.0, other.0))
    }

    #[inline(always)]
    pub fn plus_identity(self) -> Self {
        let [xx, xy, yy, xz, yz, zz] = self.0;
        Self([xx + 1.0, xy, yy + 1.0, xz, yz, zz + 1.0])
    }

    #[inline(always)]
    pub fn trace(self) -> f64 {
        self.0[0] + self.0[2] + self.0[5]
    }

    #[inline(always)]
    pub fn rows(self) -> [Vector; 3] {
        let [xx, xy, yy, xz, yz, zz] = self.0;
        [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]
    }

    #[inline(always)]
    pub fn multiply(self, [x, y, z]: Vector) -> Vector {
        self.rows().map(|[a, b, c]| a * x + b * y + c * z)
    }

    #[inline(always)]
    pub fn squared(self) -> Self {
        let [xx, xy, yy, xz, yz, zz] = self.0;
        Self([
            xx * xx + xy * xy + xz * xz,
            xx * xy + xy * yy + xz * yz,
            xy * xy + yy * yy + yz * yz,
            xx * xz + xy * yz + xz * zz,
            xy * xz + yy * yz + yz * zz,
            xz * xz + yz * yz + zz * zz,
        ])
    }

    /// `LDLᵀ` factorisation of a positive definite matrix.
    #[inline(always)]
    pub fn factors(self) -> Factors {
        let [xx, xy, yy, xz, yz, zz] = self.0;
        let d0 = xx.recip();
        let (l1, l2) = (xy * d0, xz * d0);
        let d1 = (yy - l1 * xy).recip();
        let cross = yz - l2 * xy;
        let l3 = cross * d1;
        let d2 = (zz - l2 * xz - l3 * cross).recip();
        Factors { inverse: [d0, d1, d2], lower: [l1, l2, l3] }
    }
}

/// `LDLᵀ` factors of a positive definite matrix: `D⁻¹`, and `L` below its unit diagonal, `[yx, zx, zy]`.
pub(crate) struct Factors {
    inverse: Vector,
    lower: Vector,
}

impl Factors {
    #[inline(always)]
    pub fn solve(&self, [x, y, z]: Vector) -> Vector {
        let ([d0, d1, d2], [l1, l2, l3]) = (self.inverse, self.lower);
        let y = y - l1 * x;
        let z = (z - l2 * x - l3 * y) * d2;
        let y = y * d1 - l3 * z;
        [x * d0 - l1 * y - l2 * z, y, z]
    }

    /// Derivatives of the solution, given the derivatives of the right-hand side.
    #[inline(always)]
    pub fn solve_slopes<T: Real>(&self, [x, y, z]: [T; 3]) -> [T; 3] {
        let ([d0, d1, d2], [l1, l2, l3]) = (self.inverse, self.lower);
        let y = T::slopes([(y, 1.0), (x, -l1)]);
        let z = T::slopes([(z, d2), (x, -l2 * d2), (y, -l3 * d2)]);
        let y = T::slopes([(y, d1), (z, -l3)]);
        [T::slopes([(x, d0), (y, -l1), (z, -l2)]), y, z]
    }
}

/// Elementwise sum.
#[inline(always)]
pub(crate) fn sum<const N: usize>(mut a: [f64; N], b: [f64; N]) -> [f64; N] {
    for (a, b) in a.iter_mut().zip(b) {
        *a += b;
    }
    a
}

/// Elementwise difference.
#[inline(always)]
pub(crate) fn difference<const N: usize>(mut a: [f64; N], b: [f64; N]) -> [f64; N] {
    for (a, b) in a.iter_mut().zip(b) {
        *a -= b;
    }
    a
}

/// Elementwise product.
#[inline(always)]
pub(crate) fn product<const N: usize>(mut a: [f64; N], by: [f64; N]) -> [f64; N] {
    for (a, by) in a.iter_mut().zip(by) {
        *a *= by;
    }
    a
}
