//! The laws, one file each.

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

/// A parameter that cannot be negative, log-normal a priori with a spread `sd` in e-folds.
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

/// A parameter of either sign, normal a priori around zero.
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

/// Standard deviations of noise at which a sign is told half: at one it is told by 6 %, at five by 98 %.
const HALF_SIGN_SD: f64 = 2.0;

/// Keeps the sign of nothing finite.
const MIN_ROUNDING: f64 = 1e-9;

/// The sign of a value that is read with noise, from −1 to 1 as far as it is told. Where the noise is not known it is rounded
/// off over `rounding`.
fn sign<T: Real>(value: T, noise: f64, rounding: T) -> T {
    if noise > 0.0 {
        let fourth = (value / (HALF_SIGN_SD * noise)).squared().squared();
        return (fourth / (fourth + 1.0)) * value.re().signum();
    }
    value / (value.squared() + (rounding.squared() + MIN_ROUNDING * MIN_ROUNDING)).sqrt()
}

/// How far out a face presses, as a multiple of where an even pressure would.
///
/// A priori a factor of 1.5 either way: a table on its four corners is 1.73, a disc on its rim 1.41 times as far
/// out as an even one, a face that bears on a boss of half its size half as far.
const fn spread() -> Param {
    let help = "how far out the pressure under a flat face lies, over that of an even one; 1 on known feet";
    let spread = Param {
        scales_face_pressure: true,
        ..positive("spread", "1", 5.0, (1.0, 0.4), help).role(Role::Shape)
    };
    spread.planar()
}

/// Points of support with the distance from their centre scaled.
fn spread_out<T: Real>(body: &Body, spread: T) -> Vec<([T; 2], f64)> {
    let center = [0, 1].map(|k| body.support.iter().map(|s| s.share * s.point[k]).sum::<f64>());
    let one = |s: &Support| ([0, 1].map(|k| spread * (s.point[k] - center[k]) + center[k]), s.share);
    body.support.iter().map(one).collect()
}

/// The episode of an event, by its place in the recording: a choice that is made, not searched.
const fn choice(name: &'static str, help: &'static str) -> Param {
    Param { lower: 0.0, role: Role::Choice, ..signed(name, "1", 1e6, 1.0, help) }.refinement(0.0)
}

impl Param {
    /// What it is to its law, where that is not how strong it is.
    const fn role(mut self, role: Role) -> Self {
        self.role = role;
        self
    }

    /// Left at `value` unless asked for: the law then is the simple one.
    const fn refinement(mut self, value: f64) -> Self {
        self.refinement = Some(value);
        self
    }

    /// Its smallest legal value.
    const fn at_least(mut self, lower: f64) -> Self {
        self.lower = lower;
        self
    }

    /// One of several, of which the data need hold only one.
    const fn alternative(mut self) -> Self {
        self.is_alternative = true;
        self
    }

    /// Of no meaning on a rail.
    const fn planar(mut self) -> Self {
        self.on_rail = false;
        self
    }
}

#[cfg(test)]
mod tests {
    use super::sign;

    #[test]
    fn a_sign_is_told_as_far_as_a_value_stands_out_of_its_noise() {
        let of = |value: f64| sign(value, 0.1, 5.0);
        assert!(of(0.1).abs() < 0.06 && of(0.5) > 0.97 && of(-3.0) < -0.9999, "whatever the rounding is");
        assert_eq!(of(0.2), 0.5, "half at two standard deviations");
        assert_eq!(of(0.0), 0.0);
        let rounded = |value: f64| sign(value, 0.0, 5.0);
        assert!((rounded(5.0) - 0.5f64.sqrt()).abs() < 1e-12, "noise is not known");
        assert_eq!(sign(0.0, 0.0, 0.0), 0.0);
    }
}
