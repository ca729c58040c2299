//! Pushes drawn at random, made to excite: other grasps, directions, turns, stops and reversals.

use std::f64::consts::{PI, TAU};

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};
use trundle_model::{Body, Fixture};

use crate::{Drive, Push, SimError};

/// Share of the way from the mass centre to the rim at which the gripper holds the object.
const GRASP_DEPTH: f64 = 0.95;
/// Time from one velocity to the next, s.
const RAMP: f64 = 0.25;
/// Shortest and longest time at one velocity, s.
const HOLD: (f64, f64) = (0.4, 1.1);
/// Chance that a stretch of motion ends in a stop.
const STOP: f64 = 0.4;

/// How pushes are drawn.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Excitation {
    /// How many episodes.
    pub count: usize,
    /// Time in contact of each, s.
    pub duration: f64,
    /// Largest speed of the gripper, m/s.
    pub speed: f64,
    /// Largest spin of the gripper, rad/s.
    pub spin: f64,
    /// The object starts within this distance of the origin along x and y, m, heading anywhere.
    pub spread: f64,
}

impl Default for Excitation {
    fn default() -> Self {
        Self { count: 8, duration: 6.0, speed: 0.25, spin: 0.5, spread: 0.3 }
    }
}

impl Excitation {
    /// Refuse what cannot be.
    ///
    /// # Errors
    /// When nothing would be pushed, or a limit is negative.
    pub fn check(&self) -> Result<(), SimError> {
        if !(1..=10_000).contains(&self.count) {
            return Err(SimError::value("random.count", self.count, "must lie in 1..10000 episodes"));
        }
        if !(self.duration > RAMP && self.duration <= 3600.0) {
            return Err(SimError::value("random.duration", self.duration, "must lie in 0.25..3600 s"));
        }
        for (key, value) in
            [("random.speed", self.speed), ("random.spin", self.spin), ("random.spread", self.spread)]
        {
            if !(value.is_finite() && value >= 0.0) {
                return Err(SimError::value(key, value, "must be finite and not negative"));
            }
        }
        Ok(())
    }

    /// One push of this body.
    pub fn draw(&self, body: &Body, random: &mut ChaCha8Rng) -> Push {
        let start = [
            random.random_range(-1.0..=1.0) * self.spread,
            random.random_range(-1.0..=1.0) * self.spread,
            random.random_range(-PI..=PI),
        ];
        let knots = self.knots(random);
        Push { start, grasp: grasp(body, random), drive: Drive::Velocity, knots }
    }

    /// Stretches of constant velocity with ramps between, some followed by a stop.
    fn knots(&self, random: &mut ChaCha8Rng) -> Vec<[f64; 4]> {
        let mut knots = vec![[0.0; 4]];
        let mut t = 0.0;
        while t < self.duration {
            let velocity = self.velocity(random);
            t = hold(&mut knots, t, velocity, random);
            if random.random_bool(STOP) {
                t = hold(&mut knots, t, [0.0; 3], random);
            }
        }
        cut(knots, self.duration)
    }

    fn velocity(&self, random: &mut ChaCha8Rng) -> [f64; 3] {
        let speed = self.speed * random.random_range(0.3..=1.0);
        let (sin, cos) = random.random_range(0.0..TAU).sin_cos();
        [speed * cos, speed * sin, self.spin * random.random_range(-1.0..=1.0)]
    }
}

/// Ramp to a velocity and stay; the time at the end.
fn hold(knots: &mut Vec<[f64; 4]>, t: f64, [x, y, spin]: [f64; 3], random: &mut ChaCha8Rng) -> f64 {
    let end = t + RAMP + random.random_range(HOLD.0..=HOLD.1);
    knots.extend([[t + RAMP, x, y, spin], [end, x, y, spin]]);
    end
}

/// The knots up to `end`, which becomes the last one's time.
fn cut(mut knots: Vec<[f64; 4]>, end: f64) -> Vec<[f64; 4]> {
    knots.retain(|knot| knot[0] < end);
    if let Some(&last) = knots.last() {
        knots.push([end, last[1], last[2], last[3]]);
    }
    knots
}

/// A point near the rim of one of the fixtures, the gripper facing any way.
fn grasp(body: &Body, random: &mut ChaCha8Rng) -> [f64; 3] {
    let angle = random.random_range(-PI..=PI);
    let index = random.random_range(0..body.fixtures.len().max(1));
    let (rim, center) = match body.fixtures.get(index) {
        Some(Fixture::Polygon { vertices, .. }) => (along_rim(vertices, random), mean(vertices)),
        Some(Fixture::Disc { center: [x, y], radius, .. }) => {
            let (sin, cos) = random.random_range(0.0..TAU).sin_cos();
            ([x + radius * cos, y + radius * sin], [*x, *y])
        }
        None => ([0.0; 2], [0.0; 2]),
    };
    let [x, y] = [0, 1].map(|k| center[k] + GRASP_DEPTH * (rim[k] - center[k]));
    [x, y, angle]
}

fn mean(vertices: &[[f64; 2]]) -> [f64; 2] {
    [0, 1].map(|k| vertices.iter().map(|v| v[k]).sum::<f64>() / vertices.len() as f64)
}

/// A point on a polygon's rim, uniform by length.
fn along_rim(vertices: &[[f64; 2]], random: &mut ChaCha8Rng) -> [f64; 2] {
    let next = vertices.iter().cycle().skip(1);
    let edges: Vec<_> = vertices.iter().zip(next).map(|(&a, &b)| (a, b)).collect();
    let length = |(a, b): &([f64; 2], [f64; 2])| (b[0] - a[0]).hypot(b[1] - a[1]);
    let total: f64 = edges.iter().map(length).sum();
    let mut rest = random.random::<f64>() * total;
    for edge in &edges {
        let long = length(edge);
        if rest < long {
            let (a, b) = edge;
            return [0, 1].map(|k| a[k] + rest / long * (b[k] - a[k]));
        }
        rest -= long;
    }
    vertices.first().copied().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    #[test]
    fn grasps_lie_on_the_object_and_commands_within_their_limits() {
        let square =
            Fixture::Polygon { vertices: vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]], density: 1.0 };
        let disc = Fixture::Disc { center: [3.0, 0.5], radius: 0.5, density: 1.0 };
        let body = Body::from_fixtures(vec![square, disc], 2.0).unwrap();
        let excitation = Excitation::default();
        let mut random = ChaCha8Rng::seed_from_u64(0);
        for _ in 0..200 {
            let push = excitation.draw(&body, &mut random);
            let [x, y, _] = push.grasp;
            let on_square = (0.0..=1.0).contains(&x) && (0.0..=1.0).contains(&y);
            assert!(on_square || (x - 3.0).hypot(y - 0.5) <= 0.5, "{x} {y}");
            assert!(push.knots.windows(2).all(|pair| pair[0][0] < pair[1][0]));
            assert_eq!(push.knots.last().map(|knot| knot[0]), Some(excitation.duration));
            assert!(push.knots.iter().all(|k| k[1].hypot(k[2]) <= 0.25 + 1e-12 && k[3].abs() <= 0.5));
        }
    }
}
