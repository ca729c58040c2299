//! Forces and damping on an object with three degrees of freedom.

use crate::Real;

/// A generalised force on the object, split for the implicit integrator: `force − damping · twist`.
///
/// Both parts are about the object origin in object axes. `damping` is symmetric, `[xx, xy, yy, xθ, yθ, θθ]`, and
/// positive semidefinite.
#[derive(Clone, Copy, Debug)]
pub struct GeneralisedForce<T> {
    /// Part that the integrator treats explicitly, `[N, N, N·m]`.
    pub force: [T; 3],
    /// Lower triangle of the damping matrix.
    pub damping: [T; 6],
}

impl<T: Real> GeneralisedForce<T> {
    /// Zero force and damping.
    #[inline]
    pub fn zero() -> Self {
        Self { force: [T::zero(); 3], damping: [T::zero(); 6] }
    }

    /// Add a force at a body point, object axes, N.
    #[inline]
    pub fn add_force_at(&mut self, [x, y]: [T; 2], [fx, fy]: [T; 2]) {
        self.force[0] += fx;
        self.force[1] += fy;
        self.force[2] += x * fy - y * fx;
    }

    /// Add viscous damping at a body point with the symmetric matrix `[[xx, xy], [xy, yy]]`, N·s/m.
    #[inline]
    pub fn add_damping_at(&mut self, [x, y]: [T; 2], [xx, xy, yy]: [T; 3]) {
        let (tx, ty) = (xy * x - xx * y, yy * x - xy * y);
        for (sum, term) in self.damping.iter_mut().zip([xx, xy, yy, tx, ty, ty * x - tx * y]) {
            *sum += term;
        }
    }

    /// Add isotropic viscous damping at a body point, `c` in N·s/m.
    #[inline]
    pub fn add_isotropic_damping_at(&mut self, [x, y]: [T; 2], c: T) {
        let (cx, cy) = (c * x, c * y);
        self.damping[0] += c;
        self.damping[2] += c;
        self.damping[3] -= cy;
        self.damping[4] += cx;
        self.damping[5] += cx * x + cy * y;
    }

    /// Add another generalised force.
    #[inline]
    pub fn add(&mut self, other: &Self) {
        for (sum, term) in self.force.iter_mut().zip(&other.force) {
            *sum += *term;
        }
        for (sum, term) in self.damping.iter_mut().zip(&other.damping) {
            *sum += *term;
        }
    }

    /// The wrench `force − damping · twist`, `[N, N, N·m]`.
    #[inline]
    pub fn wrench(&self, [vx, vy, spin]: [T; 3]) -> [T; 3] {
        let [xx, xy, yy, tx, ty, tt] = self.damping;
        [
            self.force[0] - (xx * vx + xy * vy + tx * spin),
            self.force[1] - (xy * vx + yy * vy + ty * spin),
            self.force[2] - (tx * vx + ty * vy + tt * spin),
        ]
    }
}
