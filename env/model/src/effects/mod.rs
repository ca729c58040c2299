//! The laws of the catalogue, one file each.

pub(crate) mod axis_friction;
mod axis_pair;
pub(crate) mod body_axis_friction;
pub(crate) mod caster_swivel;
pub(crate) mod clock_drift;
pub(crate) mod cogging;
pub(crate) mod com_offset;
pub(crate) mod coulomb_friction;
pub(crate) mod cross_talk;
pub(crate) mod dead_band;
pub(crate) mod directional_friction;
pub(crate) mod doorsill;
pub(crate) mod drive_lag;
mod dry_friction;
mod event;
pub(crate) mod floor_grain;
pub(crate) mod floor_patch;
pub(crate) mod floor_slope;
pub(crate) mod force_bias;
pub(crate) mod force_scale;
mod geometry;
pub(crate) mod gripper_inertia;
pub(crate) mod latency;
pub(crate) mod mass_change;
pub(crate) mod mass_spread;
pub(crate) mod obstacle_contact;
pub(crate) mod quadratic_drag;
pub(crate) mod saturation;
pub(crate) mod sensor_lag;
pub(crate) mod sensor_play;
pub(crate) mod spin_drag;
pub(crate) mod support_drag;
pub(crate) mod support_friction;
pub(crate) mod swinging_load;
pub(crate) mod tether;
pub(crate) mod thinning_drag;
pub(crate) mod tracker_offset;
pub(crate) mod viscous_wheel;
pub(crate) mod wheel_event;

use crate::law::{Param, Prior, Role};
use crate::{Body, Real, Support};
use std::f64::consts::PI;

/// Coordinate of a point on the body along `axis` (0: x, 1: y).
const fn on_body(name: &'static str, axis: usize, help: &'static str) -> Param {
    let prior = Prior::OnBody(axis);
    Param {
        name,
        unit: "m",
        lower: -10.0,
        upper: 10.0,
        prior,
        refinement: None,
        on_rail: false,
        scales_face_pressure: false,
        needs_known_mass: false,
        is_alternative: false,
        role: Role::BodyPoint(axis),
        help,
    }
}

/// An angle with a period.
const fn angle(name: &'static str, period: f64, help: &'static str) -> Param {
    let prior = Prior::Angle(period);
    Param {
        name,
        unit: "rad",
        lower: -2.0 * PI,
        upper: 2.0 * PI,
        prior,
        refinement: None,
        on_rail: false,
        scales_face_pressure: false,
        needs_known_mass: false,
        is_alternative: false,
        role: Role::Angle,
        help,
    }
}

/// A non-negative parameter with a log-normal prior; `sd` is the standard deviation of its logarithm.
const fn positive(
    name: &'static str,
    unit: &'static str,
    upper: f64,
    (median, sd): (f64, f64),
    help: &'static str,
) -> Param {
    let prior = Prior::LogNormal { median, sd };
    Param {
        name,
        unit,
        lower: 0.0,
        upper,
        prior,
        refinement: None,
        on_rail: true,
        scales_face_pressure: false,
        needs_known_mass: false,
        is_alternative: false,
        role: Role::Amplitude,
        help,
    }
}

/// A parameter of either sign with a normal prior around zero.
const fn signed(name: &'static str, unit: &'static str, limit: f64, sd: f64, help: &'static str) -> Param {
    let prior = Prior::Normal { mean: 0.0, sd };
    Param {
        name,
        unit,
        lower: -limit,
        upper: limit,
        prior,
        refinement: None,
        on_rail: true,
        scales_face_pressure: false,
        needs_known_mass: false,
        is_alternative: true,
        role: Role::Amplitude,
        help,
    }
}

/// Signal-to-noise ratio at which a sign has the weight 0.5. At a ratio of one the weight is 6 %, at five 98 %.
const HALF_SIGN_SD: f64 = 2.0;

/// Smallest smoothing width, which keeps the sign of zero finite.
const MIN_ROUNDING: f64 = 1e-9;

/// Sign of a noisy value, between −1 and 1, weighted by its signal-to-noise ratio. If the noise is unknown (zero), the
/// sign is smoothed over `rounding`.
fn sign<T: Real>(value: T, noise: f64, rounding: T) -> T {
    if noise > 0.0 {
        let fourth = (value / (HALF_SIGN_SD * noise)).squared().squared();
        return (fourth / (fourth + 1.0)) * value.re().signum();
    }
    value / (value.squared() + (rounding.squared() + MIN_ROUNDING * MIN_ROUNDING)).sqrt()
}

/// Radial spread of the pressure under a face relative to uniform pressure.
///
/// The prior allows a factor of about 1.5. A rectangle on its four corners has 1.73, a disc on its rim 1.41, and a face
/// that rests on its inner half 0.5.
const fn spread() -> Param {
    let help =
        "radial spread of the pressure under a flat face relative to uniform pressure; 1 on known feet";
    let spread = Param {
        scales_face_pressure: true,
        ..positive("spread", "1", 5.0, (1.0, 0.4), help).role(Role::Shape)
    };
    spread.planar()
}

/// Support points with their distance from the centre scaled by `spread`.
fn spread_out<T: Real>(body: &Body, spread: T) -> Vec<([T; 2], f64)> {
    let center = [0, 1].map(|k| body.support.iter().map(|s| s.share * s.point[k]).sum::<f64>());
    let one = |s: &Support| ([0, 1].map(|k| spread * (s.point[k] - center[k]) + center[k]), s.share);
    body.support.iter().map(one).collect()
}

/// A discrete choice, which is given and not searched.
const fn choice(name: &'static str, help: &'static str) -> Param {
    Param { lower: 0.0, role: Role::Choice, ..signed(name, "1", 1e6, 1.0, help) }.refinement(0.0)
}

impl Param {
    /// Set the role.
    const fn role(mut self, role: Role) -> Self {
        self.role = role;
        self
    }

    /// Make it a refinement with the default `value`.
    const fn refinement(mut self, value: f64) -> Self {
        self.refinement = Some(value);
        self
    }

    /// Set the lower bound.
    const fn at_least(mut self, lower: f64) -> Self {
        self.lower = lower;
        self
    }

    /// Make it a member of a group of which one identifiable member suffices.
    const fn alternative(mut self) -> Self {
        self.is_alternative = true;
        self
    }

    /// Exclude it for objects on a rail.
    const fn planar(mut self) -> Self {
        self.on_rail = false;
        self
    }
}

#[cfg(test)]
mod tests {
    use super::sign;

    #[test]
    fn the_sign_is_weighted_by_the_signal_to_noise_ratio() {
        let of = |value: f64| sign(value, 0.1, 5.0);
        assert!(of(0.1).abs() < 0.06 && of(0.5) > 0.97 && of(-3.0) < -0.9999, "independent of the rounding");
        assert_eq!(of(0.2), 0.5, "half at two standard deviations");
        assert_eq!(of(0.0), 0.0);
        let rounded = |value: f64| sign(value, 0.0, 5.0);
        assert!((rounded(5.0) - 0.5f64.sqrt()).abs() < 1e-12, "unknown noise");
        assert_eq!(sign(0.0, 0.0, 0.0), 0.0);
    }
}
