//! Symmetric 3×3 matrices over (pose, velocity, acceleration).
//!
//! Only the six independent entries are stored. The likelihood of a jerk intensity takes some hundred thousand filter
//! steps, so the cost of a step matters.

/// The matrix `[[pp, pv, pa], [pv, vv, va], [pa, va, aa]]`.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Symmetric {
    pub pp: f64,
    pub pv: f64,
    pub pa: f64,
    pub vv: f64,
    pub va: f64,
    pub aa: f64,
}

impl Symmetric {
    /// `x xᵀ`.
    #[inline]
    pub fn outer_product([x, y, z]: [f64; 3]) -> Self {
        Self { pp: x * x, pv: x * y, pa: x * z, vv: y * y, va: y * z, aa: z * z }
    }

    /// First column.
    #[inline]
    pub fn first_column(&self) -> [f64; 3] {
        [self.pp, self.pv, self.pa]
    }

    /// `P + factor·Q`.
    #[inline]
    pub fn add_scaled(&self, other: &Self, factor: f64) -> Self {
        Self {
            pp: self.pp + factor * other.pp,
            pv: self.pv + factor * other.pv,
            pa: self.pa + factor * other.pa,
            vv: self.vv + factor * other.vv,
            va: self.va + factor * other.va,
            aa: self.aa + factor * other.aa,
        }
    }

    /// `F P Fᵀ` with the transition matrix `F` of constant acceleration over `dt`.
    #[inline]
    pub fn propagated(&self, dt: f64) -> Self {
        let Self { pp, pv, pa, vv, va, aa } = self;
        let half = 0.5 * dt * dt;
        let (to_p, to_v, to_a) =
            (pp + dt * pv + half * pa, pv + dt * vv + half * va, pa + dt * va + half * aa);
        let turned = va + dt * aa;
        Self {
            pp: to_p + dt * to_v + half * to_a,
            pv: to_v + dt * to_a,
            pa: to_a,
            vv: vv + dt * va + dt * turned,
            va: turned,
            aa: *aa,
        }
    }

    /// `Fᵀ W F` with the same transition matrix.
    pub fn propagated_back(&self, dt: f64) -> Self {
        let Self { pp, pv, pa, vv, va, aa } = self;
        let half = 0.5 * dt * dt;
        let (by_v, by_a) = (dt * pp + pv, half * pp + dt * pv + pa);
        let (v_by_v, v_by_a) = (dt * pv + vv, half * pv + dt * vv + va);
        Self {
            pp: *pp,
            pv: by_v,
            pa: by_a,
            vv: dt * by_v + v_by_v,
            va: dt * by_a + v_by_a,
            aa: half * by_a + dt * v_by_a + half * pa + dt * va + aa,
        }
    }

    /// `(I − k H)ᵀ W (I − k H) + w HᵀH` with `H = [1, 0, 0]`.
    pub fn measured(&self, gain: [f64; 3], w: f64) -> Self {
        let [p, v, a] = self.times(gain);
        let [along_p, along_v, along_a] = gain;
        let twice = along_p * p + along_v * v + along_a * a;
        Self { pp: self.pp - 2.0 * p + twice + w, pv: self.pv - v, pa: self.pa - a, ..*self }
    }

    /// `P x`.
    pub fn times(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        self.rows().map(|[a, b, c]| a * x + b * y + c * z)
    }

    /// `P W P`.
    pub fn sandwich(&self, inner: Self) -> Self {
        let [p, v, a] = self.rows();
        let by = |row: [f64; 3], x: [f64; 3]| row[0] * x[0] + row[1] * x[1] + row[2] * x[2];
        let (wp, wv, wa) = (inner.times(p), inner.times(v), inner.times(a));
        Self { pp: by(p, wp), pv: by(p, wv), pa: by(p, wa), vv: by(v, wv), va: by(v, wa), aa: by(a, wa) }
    }

    /// The full matrix by rows.
    pub fn rows(&self) -> [[f64; 3]; 3] {
        let Self { pp, pv, pa, vv, va, aa } = *self;
        [[pp, pv, pa], [pv, vv, va], [pa, va, aa]]
    }
}

#[cfg(test)]
mod tests {
    use super::Symmetric;
    use nalgebra::{Matrix3, Vector3};

    fn full(s: &Symmetric) -> Matrix3<f64> {
        Matrix3::from_fn(|i, j| s.rows()[i][j])
    }

    #[test]
    fn products_equal_those_of_full_matrices() {
        let p = Symmetric { pp: 2.0, pv: 0.3, pa: -0.4, vv: 1.5, va: 0.7, aa: 3.0 };
        let w = Symmetric { pp: 0.6, pv: -0.2, pa: 0.1, vv: 0.9, va: -0.3, aa: 0.8 };
        let (dt, gain) = (0.3, [0.7, -1.2, 0.4]);
        let step = Matrix3::new(1.0, dt, dt * dt / 2.0, 0.0, 1.0, dt, 0.0, 0.0, 1.0);
        let keep = Matrix3::identity() - Vector3::from(gain) * Vector3::x().transpose();
        let measured = keep.transpose() * full(&w) * keep + 0.2 * Vector3::x() * Vector3::x().transpose();
        for (name, ours, expected) in [
            ("propagated", p.propagated(dt), step * full(&p) * step.transpose()),
            ("propagated back", w.propagated_back(dt), step.transpose() * full(&w) * step),
            ("measured", w.measured(gain, 0.2), measured),
            ("sandwich", p.sandwich(w), full(&p) * full(&w) * full(&p)),
            ("add_scaled", p.add_scaled(&w, 0.5), full(&p) + full(&w) * 0.5),
        ] {
            assert!((full(&ours) - expected).amax() < 1e-14, "{name}: {ours:?} {expected}");
        }
    }
}
