//! The mass that a foreign simulator moves, as its answers show it.

use super::likelihood::Along;
use super::linear::Map;
use super::path::Interval;
use nalgebra::Matrix3;

impl Along {
    /// Mass that the wrench moves, kg: the median over all intervals.
    pub fn felt_mass(&self) -> Option<f64> {
        let pairs = self.paths.iter().zip(&self.maps).flat_map(|(p, m)| p.intervals.iter().zip(m));
        let mut all: Vec<f64> = pairs.filter_map(|(interval, map)| felt(interval, map)).collect();
        all.sort_by(f64::total_cmp);
        all.get(all.len() / 2).copied()
    }
}

/// Mass in one interval: a wrench `w` held over it changes the twist by `∫ e^(−K(T−s)) ds M⁻¹ w`, where the twist
/// before fades as `A = e^(−KT)`; the integral is `(I + A) T/2` to second order. `None` where that has no inverse, or on
/// a rail.
fn felt(interval: &Interval, map: &Map) -> Option<f64> {
    let fades: Matrix3<f64> = map.a.fixed_view::<3, 3>(3, 3).into_owned();
    let gains: Matrix3<f64> = map.b.fixed_view::<3, 3>(3, 0).into_owned();
    let held = (Matrix3::identity() + fades) * (interval.span / 2.0);
    let resists = (held.try_inverse()? * gains).try_inverse()?;
    // From the object's axes to the world's: two columns of m times a turn.
    let (sin, cos) = interval.middle.pose[2].sin_cos();
    let turned = resists * Matrix3::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0);
    let mass = 0.5 * (turned[(0, 0)] + turned[(1, 1)]);
    (mass.is_finite() && mass > 0.0).then_some(mass)
}
