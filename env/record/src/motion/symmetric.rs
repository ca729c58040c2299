//! Symmetric matrices over (pose, velocity, acceleration), by their six entries: the likelihood of a jerk's intensity
//! takes some hundred thousand steps of a filter, and twice the entries would be twice the time.

/// `[[pp, pv, pa], [pv, vv, va], [pa, va, aa]]`.
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
    pub fn square([x, y, z]: [f64; 3]) -> Self {
        Self { pp: x * x, pv: x * y, pa: x * z, vv: y * y, va: y * z, aa: z * z }
    }

    /// Its first column.
    #[inline]
    pub fn first(&self) -> [f64; 3] {
        [self.pp, self.pv, self.pa]
    }

    /// `P + by·Q`.
    #[inline]
    pub fn plus(&self, other: &Self, by: f64) -> Self {
        Self {
            pp: self.pp + by * other.pp,
            pv: self.pv + by * other.pv,
            pa: self.pa + by * other.pa,
            vv: self.vv + by * other.vv,
            va: self.va + by * other.va,
            aa: self.aa + by * other.aa,
        }
    }

    /// `F P Fᵀ` with the transition `F` of a constant acceleration over `dt`.
    #[inline]
    pub fn carried(&self, dt: f64) -> Self {
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

    /// `Fᵀ W F` with the same transition.
    pub fn carried_back(&self, dt: f64) -> Self {
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

    /// `(I − k H)ᵀ W (I − k H) + w HᵀH`, `H` taking the pose.
    pub fn seen(&self, gain: [f64; 3], w: f64) -> Self {
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
    pub fn around(&self, inner: Self) -> Self {
        let [p, v, a] = self.rows();
        let by = |row: [f64; 3], x: [f64; 3]| row[0] * x[0] + row[1] * x[1] + row[2] * x[2];
        let (wp, wv, wa) = (inner.times(p), inner.times(v), inner.times(a));
        Self { pp: by(p, wp), pv: by(p, wv), pa: by(p, wa), vv: by(v, wv), va: by(v, wa), aa: by(a, wa) }
    }

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
    fn products_are_those_of_whole_matrices() {
        let p = Symmetric { pp: 2.0, pv: 0.3, pa: -0.4, vv: 1.5, va: 0.7, aa: 3.0 };
        let w = Symmetric { pp: 0.6, pv: -0.2, pa: 0.1, vv: 0.9, va: -0.3, aa: 0.8 };
        let (dt, gain) = (0.3, [0.7, -1.2, 0.4]);
        let step = Matrix3::new(1.0, dt, dt * dt / 2.0, 0.0, 1.0, dt, 0.0, 0.0, 1.0);
        let keep = Matrix3::identity() - Vector3::from(gain) * Vector3::x().transpose();
        let seen = keep.transpose() * full(&w) * keep + 0.2 * Vector3::x() * Vector3::x().transpose();
        for (name, ours, whole) in [
            ("carried", p.carried(dt), step * full(&p) * step.transpose()),
            ("carried back", w.carried_back(dt), step.transpose() * full(&w) * step),
            ("seen", w.seen(gain, 0.2), seen),
            ("around", p.around(w), full(&p) * full(&w) * full(&p)),
            ("plus", p.plus(&w, 0.5), full(&p) + full(&w) * 0.5),
        ] {
            assert!((full(&ours) - whole).amax() < 1e-14, "{name}: {ours:?} {whole}");
        }
    }
}
