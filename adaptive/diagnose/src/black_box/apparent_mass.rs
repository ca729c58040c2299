//! Apparent mass of a black-box simulator, from its response to the wrench.

use super::likelihood::PathLikelihood;
use super::linearisation::IntervalMap;
use super::path::Interval;
use nalgebra::Matrix3;

impl PathLikelihood {
    /// Mass that the wrench accelerates, kg: the median over all intervals.
    pub fn apparent_mass(&self) -> Option<f64> {
        let pairs = self.paths.iter().zip(&self.maps).flat_map(|(p, m)| p.intervals.iter().zip(m));
        let mut all: Vec<f64> = pairs.filter_map(|(interval, map)| interval_mass(interval, map)).collect();
        all.sort_by(f64::total_cmp);
        all.get(all.len() / 2).copied()
    }
}

/// Apparent mass in one interval, kg.
///
/// A constant wrench `w` changes the twist by `∫ e^(−K(T−s)) ds M⁻¹ w`, where `A = e^(−KT)` is the decay of the
/// initial twist. To second order the integral is `(I + A) T/2`. `None` if it is singular, or if the object is on
/// a rail.
fn interval_mass(interval: &Interval, map: &IntervalMap) -> Option<f64> {
    let decay: Matrix3<f64> = map.a.fixed_view::<3, 3>(3, 3).into_owned();
    let gains: Matrix3<f64> = map.b.fixed_view::<3, 3>(3, 0).into_owned();
    let integral = (Matrix3::identity() + decay) * (interval.span / 2.0);
    let mass_matrix = (integral.try_inverse()? * gains).try_inverse()?;
    // Rotate from object axes to world axes: the first two columns are the mass times a rotation.
    let (sin, cos) = interval.middle.pose[2].sin_cos();
    let rotated = mass_matrix * Matrix3::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0);
    let mass = 0.5 * (rotated[(0, 0)] + rotated[(1, 1)]);
    (mass.is_finite() && mass > 0.0).then_some(mass)
}
