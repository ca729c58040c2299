//! A push in a few numbers: grasp, direction, profile, strength, and where the object stands.

use serde::Serialize;
use std::f64::consts::FRAC_PI_2;

/// Course of the wrench over the time in contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Profile {
    /// Push one way, then let go.
    Steady,
    /// Forward, twice as long back, forward: a free body comes back to where it was, at rest.
    ThereAndBack,
    /// The same three times as fast.
    Shuttle,
    /// Short pushes of either sign with rests between, in which the object comes to a stop.
    Pulses,
    /// A slow and a fast oscillation at once.
    TwoFrequencies,
    /// Turn about the grasp, there and back, with a torque alone.
    Turn,
    /// There and back while it is turned at twice the frequency.
    Weave,
}

/// Time in which the wrench rises, s.
const RAMP: f64 = 0.15;
/// Knots a second of what oscillates.
const FINE: f64 = 20.0;

impl Profile {
    /// All of them.
    pub const ALL: [Self; 7] = [
        Self::ThereAndBack,
        Self::Steady,
        Self::Shuttle,
        Self::Turn,
        Self::Pulses,
        Self::TwoFrequencies,
        Self::Weave,
    ];

    /// Whether it has a torque, which means nothing on a rail.
    pub fn turns(self) -> bool {
        matches!(self, Self::Turn | Self::Weave)
    }

    /// How readily it is made, at most one.
    fn ease(self) -> f64 {
        match self {
            Self::Steady | Self::ThereAndBack | Self::Turn => 1.0,
            Self::Shuttle | Self::Pulses => 0.85,
            Self::TwoFrequencies | Self::Weave => 0.7,
        }
    }

    /// Shares of the largest force and torque over `duration`: rows `[t, force, torque]`, lines between.
    fn shares(self, duration: f64) -> Vec<[f64; 3]> {
        let along = |levels: &[(f64, f64)]| -> Vec<[f64; 3]> {
            trapezes(levels, duration).into_iter().map(|[t, share]| [t, share, 0.0]).collect()
        };
        match self {
            Self::Steady => along(&[(0.55, 1.0), (0.45, 0.0)]),
            Self::ThereAndBack => along(&BACK),
            Self::Shuttle => along(&repeated(&BACK, 3)),
            Self::Pulses => along(&PULSES),
            Self::Turn => trapezes(&BACK, duration).into_iter().map(|[t, share]| [t, 0.0, share]).collect(),
            Self::TwoFrequencies => sampled(duration, |p| [0.5 * p.sin() + 0.5 * (9.0 * p).sin(), 0.0]),
            Self::Weave => sampled(duration, |p| [(2.0 * p).cos() * ease(p), (4.0 * p).sin()]),
        }
    }
}

/// Shares of the time, and of the force.
const BACK: [(f64, f64); 3] = [(0.25, 1.0), (0.5, -1.0), (0.25, 1.0)];
const PULSES: [(f64, f64); 8] =
    [(0.1, 1.0), (0.15, 0.0), (0.1, -1.0), (0.15, 0.0), (0.1, -1.0), (0.15, 0.0), (0.1, 1.0), (0.15, 0.0)];

fn repeated(levels: &[(f64, f64)], times: usize) -> Vec<(f64, f64)> {
    let one = levels.iter().map(|(span, level)| (span / times as f64, *level));
    std::iter::repeat_n(one, times).flatten().collect()
}

/// Knots of levels that are held for shares of the time, with ramps between; zero at both ends.
fn trapezes(levels: &[(f64, f64)], duration: f64) -> Vec<[f64; 2]> {
    let (mut knots, mut t, mut before) = (vec![[0.0, 0.0]], 0.0, 0.0);
    for &(share, level) in levels {
        let end = t + share * duration;
        if level != before {
            knots.push([t + RAMP.min(0.4 * share * duration), level]);
        }
        knots.push([end, level]);
        (t, before) = (end, level);
    }
    if let (Some(last), true) = (knots.last_mut(), before != 0.0) {
        last[0] = duration - RAMP.min(0.1 * duration);
        knots.push([duration, 0.0]);
    }
    knots
}

/// Knots of two functions of a phase that goes once around.
fn sampled(duration: f64, shares: impl Fn(f64) -> [f64; 2]) -> Vec<[f64; 3]> {
    let count = (FINE * duration).ceil().max(4.0) as usize;
    let knot = |k: usize| {
        let share = k as f64 / count as f64;
        let [force, torque] = shares(std::f64::consts::TAU * share);
        [share * duration, force, torque]
    };
    (0..=count).map(knot).collect()
}

/// From nothing to one within the first and the last tenth of a turn of the phase.
fn ease(phase: f64) -> f64 {
    let share = phase / std::f64::consts::TAU;
    (10.0 * share.min(1.0 - share)).clamp(0.0, 1.0)
}

/// A push.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Push {
    /// Where the gripper holds the object, object frame, m.
    pub grasp: [f64; 2],
    /// Along which it pushes, object frame, rad.
    pub direction: f64,
    /// Pose at which the object stands at rest, world, m and rad.
    pub start: [f64; 3],
    /// Course of the wrench.
    pub profile: Profile,
    /// Largest force, N.
    pub force: f64,
    /// Largest torque, N·m.
    pub torque: f64,
    /// Time in contact, s.
    pub duration: f64,
}

impl Push {
    /// Pose of the gripper in the object frame, its x along the push, m and rad.
    pub fn gripper(&self) -> [f64; 3] {
        [self.grasp[0], self.grasp[1], self.direction]
    }

    /// The command as a scenario holds it: rows `[t, f_x, f_y, τ]`, t in s from contact on, gripper axes, straight
    /// lines between.
    pub fn knots(&self) -> Vec<[f64; 4]> {
        let row = |[t, force, torque]: [f64; 3]| [t, self.force * force, 0.0, self.torque * torque];
        self.profile.shares(self.duration).into_iter().map(row).collect()
    }

    /// The same, weaker or stronger by a factor.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        Self { force: self.force * factor, torque: self.torque * factor, ..*self }
    }

    /// How readily it is made, at most one: what separates a little less but is simpler is preferred. Quarters and
    /// halves of them are easier to see than other angles.
    pub(super) fn ease(&self, heading: f64) -> f64 {
        let plain = |angle: f64, unit: f64| {
            let turns = angle / unit;
            if (turns - turns.round()).abs() < 0.02 { 1.0 } else { 0.8 }
        };
        self.profile.ease()
            * plain(self.start[2] - heading, FRAC_PI_2)
            * plain(self.direction, FRAC_PI_2 / 2.0)
    }

    /// Quarters by which the object is turned from a heading, to the left, -1 to 2; `None` for another angle.
    pub(super) fn quarters(&self, heading: f64) -> Option<i32> {
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
    fn every_profile_is_one_that_a_scenario_takes_and_keeps_its_limits() {
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
    fn there_and_back_gives_as_much_impulse_either_way() {
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
    fn quarters_are_counted_to_the_left() {
        let turned = |heading: f64| Push { start: [0.0, 0.0, heading], ..push(Profile::Turn) };
        let found = [0.1, 0.1 + FRAC_PI_2, 0.1 + 2.0 * FRAC_PI_2, 0.1 - FRAC_PI_2, 0.7]
            .map(|h| turned(h).quarters(0.1));
        assert_eq!(found, [Some(0), Some(1), Some(2), Some(-1), None]);
    }
}
