//! Backlash: motion of the side of a play whose position is not measured.

use crate::deflection::Unmeasured;
use crate::laws::magnitude;
use trundle_model::Real;

/// What moves the side, and how it resists.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Side<T> {
    /// Effort on it, without that of the other side.
    pub effort: T,
    /// Level of dry friction on it.
    pub friction: T,
    pub resistance: Unmeasured<T>,
}

/// Motion of a side at one time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SideMotion<T> {
    pub position: T,
    pub acceleration: T,
    pub velocity: T,
    /// Effort of dry friction, positive against a positive velocity; `None` while it moves with the measured side.
    pub friction: Option<T>,
}

/// Motion of the side that is not measured.
///
/// It moves freely until it meets the measured side, with which it then moves. Impacts are inelastic (time stepping after
/// Moreau 1988, with implicit damping and dry friction). `seen` are the positions of the measured side every `dt` seconds; the play is
/// `gap` in all.
pub(crate) fn unmeasured_side<T: Real>(
    seen: &[f64],
    gap: T,
    dt: f64,
    side: &dyn Fn(usize) -> Side<T>,
) -> Vec<SideMotion<T>> {
    let half = gap * 0.5;
    let mut x = T::lift(seen.first().copied().unwrap_or(0.0));
    let mut v = T::lift(seen.windows(2).next().map_or(0.0, |pair| (pair[1] - pair[0]) / dt));
    let mut found = Vec::with_capacity(seen.len());
    for k in 0..seen.len() {
        let Some(next) = seen.get(k + 1) else {
            found.push(SideMotion { position: x, acceleration: T::zero(), velocity: v, friction: None });
            break;
        };
        let Side { effort, friction, resistance: Unmeasured { inertia, damping, stiffness } } = side(k);
        let impulse = inertia * v + (effort - stiffness * (x - seen[k])) * dt;
        let stopping = if magnitude(impulse).re() <= friction.re() * dt {
            impulse
        } else {
            friction * (dt * impulse.re().signum())
        };
        let free = (impulse - stopping) / (inertia + damping * dt + f64::MIN_POSITIVE);
        let (low, high) = (-half + *next, half + *next);
        let moved = x + free * dt;
        let (reached, is_free) = match moved.re() {
            position if position >= high.re() => (high, false),
            position if position <= low.re() => (low, false),
            position if position.is_nan() => (low, false),
            _ => (moved, true),
        };
        // Velocities belong to the middle of the intervals.
        let velocity = (reached - x) / dt;
        found.push(SideMotion {
            position: x,
            acceleration: (velocity - v) / dt,
            velocity: (velocity + v) * 0.5,
            friction: is_free.then_some(stopping / dt),
        });
        (x, v) = (reached, velocity);
    }
    found
}

#[cfg(test)]
mod tests {
    use super::{Side, SideMotion, unmeasured_side};
    use crate::deflection::Unmeasured;

    const DT: f64 = 0.001;

    fn swing(k: usize) -> f64 {
        (2.0 * k as f64 * DT).sin()
    }

    fn relative(gap: f64, effort: f64, friction: f64) -> Vec<f64> {
        let seen: Vec<f64> = (0..6000).map(swing).collect();
        let side = |_: usize| Side {
            effort,
            friction,
            resistance: Unmeasured { inertia: 0.5, damping: 0.0, stiffness: 0.0 },
        };
        let (mut x, mut v) = (seen[0], (seen[1] - seen[0]) / DT);
        let mut step = |motion: SideMotion<f64>, k: usize| {
            v += motion.acceleration * DT;
            x += v * DT;
            x - swing(k + 1)
        };
        unmeasured_side(&seen, gap, DT, &side)
            .into_iter()
            .take(5999)
            .enumerate()
            .map(|(k, motion)| step(motion, k))
            .collect()
    }

    #[test]
    fn a_coasting_side_moves_from_face_to_face() {
        let found = relative(0.02, 0.0, 0.0);
        let (low, high) = found.iter().fold((0.0, 0.0), |(l, h), x| (f64::min(l, *x), f64::max(h, *x)));
        assert!((low + 0.01).abs() < 1e-6 && (high - 0.01).abs() < 1e-6, "{low} {high}");
        // While the measured side speeds up it pushes from behind, and later the other one coasts ahead.
        assert!((found[1500] - 0.01).abs() < 1e-6, "{}", found[1500]);
    }

    #[test]
    fn a_side_with_much_friction_is_pushed_from_behind() {
        // It meets the other face at reversals only, and rests in between.
        let found = relative(0.02, 0.0, 50.0);
        let behind =
            (100..5900).filter(|k| (found[*k] + 0.01 * (2.0 * *k as f64 * DT).cos().signum()).abs() < 1e-6);
        assert!(behind.count() > 5000);
    }

    #[test]
    fn a_strong_load_keeps_contact() {
        let found = relative(0.02, -50.0, 0.0);
        assert!(found[500..5900].iter().all(|x| (x + 0.01).abs() < 1e-6));
    }
}
