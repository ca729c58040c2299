//! A push with few parameters: grasp, direction, profile, strength, and start pose.

use serde::Serialize;
use std::f64::consts::FRAC_PI_2;

/// Time profile of the wrench.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Profile {
    /// A constant force in one direction, then release.
    Steady,
    /// Forwards, backwards for twice as long, forwards: a free body returns to its start at rest.
    ThereAndBack,
    /// `ThereAndBack` three times, each three times as fast.
    Shuttle,
    /// Short pulses of either sign, with pauses in which the object comes to rest.
    Pulses,
    /// The sum of a slow and a fast oscillation.
    TwoFrequencies,
    /// A pure torque in one direction, back, and forth again.
    Turn,
    /// An oscillating force, with an oscillating torque at twice the frequency.
    Weave,
}

/// Rise time of the wrench, s.
const RAMP_S: f64 = 0.15;
/// Rate of the knots of oscillating profiles, Hz.
const KNOT_RATE_HZ: f64 = 20.0;

impl Profile {
    /// All profiles.
    pub const ALL: [Self; 7] = [
        Self::ThereAndBack,
        Self::Steady,
        Self::Shuttle,
        Self::Turn,
        Self::Pulses,
        Self::TwoFrequencies,
        Self::Weave,
    ];

    /// Whether the profile includes a torque, which is not possible on a rail.
    pub fn turns(self) -> bool {
        matches!(self, Self::Turn | Self::Weave)
    }

    /// Preference for simple profiles, at most one.
    fn simplicity(self) -> f64 {
        match self {
            Self::Steady | Self::ThereAndBack | Self::Turn => 1.0,
            Self::Shuttle | Self::Pulses => 0.85,
            Self::TwoFrequencies | Self::Weave => 0.7,
        }
    }

    /// Force and torque over `duration` as shares of their maxima: rows `[t, force, torque]`, to be interpolated
    /// linearly.
    fn shares(self, duration: f64) -> Vec<[f64; 3]> {
        let force_only = |levels: &[(f64, f64)]| -> Vec<[f64; 3]> {
            trapezoids(levels, duration).into_iter().map(|[t, share]| [t, share, 0.0]).collect()
        };
        match self {
            Self::Steady => force_only(&[(0.55, 1.0), (0.45, 0.0)]),
            Self::ThereAndBack => force_only(&THERE_AND_BACK),
            Self::Shuttle => force_only(&repeated(&THERE_AND_BACK, 3)),
            Self::Pulses => force_only(&PULSES),
            Self::Turn => {
                trapezoids(&THERE_AND_BACK, duration).into_iter().map(|[t, share]| [t, 0.0, share]).collect()
            }
            Self::TwoFrequencies => sampled(duration, |p| [0.5 * p.sin() + 0.5 * (9.0 * p).sin(), 0.0]),
            Self::Weave => sampled(duration, |p| [(2.0 * p).cos() * taper(p), (4.0 * p).sin()]),
        }
    }
}

/// Levels: shares of the duration and of the maximum force.
const THERE_AND_BACK: [(f64, f64); 3] = [(0.25, 1.0), (0.5, -1.0), (0.25, 1.0)];
const PULSES: [(f64, f64); 8] =
    [(0.1, 1.0), (0.15, 0.0), (0.1, -1.0), (0.15, 0.0), (0.1, -1.0), (0.15, 0.0), (0.1, 1.0), (0.15, 0.0)];

fn repeated(levels: &[(f64, f64)], times: usize) -> Vec<(f64, f64)> {
    let one = levels.iter().map(|(span, level)| (span / times as f64, *level));
    std::iter::repeat_n(one, times).flatten().collect()
}

/// Knots of constant levels over shares of the duration, with ramps between them and zero at both ends.
fn trapezoids(levels: &[(f64, f64)], duration: f64) -> Vec<[f64; 2]> {
    let (mut knots, mut t, mut before) = (vec![[0.0, 0.0]], 0.0, 0.0);
    for &(share, level) in levels {
        let end = t + share * duration;
        if level != before {
            knots.push([t + RAMP_S.min(0.4 * share * duration), level]);
        }
        knots.push([end, level]);
        (t, before) = (end, level);
    }
    if let (Some(last), true) = (knots.last_mut(), before != 0.0) {
        last[0] = duration - RAMP_S.min(0.1 * duration);
        knots.push([duration, 0.0]);
    }
    knots
}

/// Knots of two functions of a phase that runs through one period.
fn sampled(duration: f64, shares: impl Fn(f64) -> [f64; 2]) -> Vec<[f64; 3]> {
    let count = (KNOT_RATE_HZ * duration).ceil().max(4.0) as usize;
    let knot = |k: usize| {
        let share = k as f64 / count as f64;
        let [force, torque] = shares(std::f64::consts::TAU * share);
        [share * duration, force, torque]
    };
    (0..=count).map(knot).collect()
}

/// Window that rises from zero to one over the first tenth of the period and falls over the last.
fn taper(phase: f64) -> f64 {
    let share = phase / std::f64::consts::TAU;
    (10.0 * share.min(1.0 - share)).clamp(0.0, 1.0)
}

/// A push.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Push {
    /// Position of the grasp, object frame, m.
    pub grasp: [f64; 2],
    /// Direction of the force, object frame, rad.
    pub direction: f64,
    /// Pose of the object at rest before the push, world, m and rad.
    pub start: [f64; 3],
    /// Time profile of the wrench.
    pub profile: Profile,
    /// Maximum force, N.
    pub force: f64,
    /// Maximum torque, N·m.
    pub torque: f64,
    /// Time in contact, s.
    pub duration: f64,
}

impl Push {
    /// Pose of the gripper in the object frame, with x along the force, m and rad.
    pub fn gripper(&self) -> [f64; 3] {
        [self.grasp[0], self.grasp[1], self.direction]
    }

    /// The command in the format of a scenario: rows `[t, f_x, f_y, τ]`, t in s since contact, gripper axes, to be
    /// interpolated linearly.
    pub fn knots(&self) -> Vec<[f64; 4]> {
        let row = |[t, force, torque]: [f64; 3]| [t, self.force * force, 0.0, self.torque * torque];
        self.profile.shares(self.duration).into_iter().map(row).collect()
    }

    /// The push with force and torque multiplied by a factor.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        Self { force: self.force * factor, torque: self.torque * factor, ..*self }
    }

    /// Preference for pushes that are simple to make, at most one. Headings at multiples of 90° and directions at
    /// multiples of 45° are easier to set up than others.
    pub(super) fn simplicity(&self, heading: f64) -> f64 {
        let preference = |angle: f64, unit: f64| {
            let turns = angle / unit;
            if (turns - turns.round()).abs() < 0.02 { 1.0 } else { 0.8 }
        };
        self.profile.simplicity()
            * preference(self.start[2] - heading, FRAC_PI_2)
            * preference(self.direction, FRAC_PI_2 / 2.0)
    }

    /// Number of quarter turns to the left from a heading, −1 to 2; `None` for other angles.
    pub(super) fn quarter_turns(&self, heading: f64) -> Option<i32> {
        let turn = (self.start[2] - heading) / FRAC_PI_2;
        let whole = turn.round();
        ((turn - whole).abs() < 0.02).then(|| (whole as i32 + 1).rem_euclid(4) - 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn push(profile: Profile) -> Push {
        let start = [0.0; 3];
        Push { grasp: [0.5, 0.1], direction: 0.3, start, profile, force: 20.0, torque: 4.0, duration: 6.0 }
    }

    #[test]
    fn every_profile_is_valid_in_a_scenario_and_respects_its_limits() {
        for profile in Profile::ALL {
            let knots = push(profile).knots();
            assert!(knots.windows(2).all(|w| w[0][0] < w[1][0]), "{profile:?} {knots:?}");
            assert_eq!(knots.last().map(|k| k[0]), Some(6.0), "{profile:?}");
            let peak = |k: usize| knots.iter().map(|knot| knot[k].abs()).fold(0.0, f64::max);
            assert!(peak(1) <= 20.0 + 1e-9 && peak(2) == 0.0 && peak(3) <= 4.0 + 1e-9);
            assert_eq!(peak(3) > 0.0, profile.turns());
            assert!(peak(1) + peak(3) > 3.9);
        }
    }

    #[test]
    fn symmetric_profiles_have_no_net_impulse() {
        for profile in [Profile::ThereAndBack, Profile::Shuttle, Profile::Pulses] {
            let impulse: f64 = push(profile)
                .knots()
                .windows(2)
                .map(|w| (w[1][0] - w[0][0]) * (w[0][1] + w[1][1]) / 2.0)
                .sum();
            assert!(impulse.abs() < 0.1 * 20.0 * 6.0, "{profile:?} {impulse}");
        }
    }

    #[test]
    fn quarter_turns_count_to_the_left() {
        let turned = |heading: f64| Push { start: [0.0, 0.0, heading], ..push(Profile::Turn) };
        let found = [0.1, 0.1 + FRAC_PI_2, 0.1 + 2.0 * FRAC_PI_2, 0.1 - FRAC_PI_2, 0.7]
            .map(|h| turned(h).quarter_turns(0.1));
        assert_eq!(found, [Some(0), Some(1), Some(2), Some(-1), None]);
    }
}
