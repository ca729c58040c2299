//! Random pushes that excite the dynamics: varying grasps, directions, turns, stops and reversals.

use std::f64::consts::{PI, TAU};

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};
use trundle_model::{Body, Fixture};

use crate::{DriveMode, Push, SimError};

/// Position of the grasp on the line from the fixture's centre (0) to the rim (1).
const GRASP_RIM_FRACTION: f64 = 0.95;
/// Duration of a velocity ramp, s.
const RAMP_S: f64 = 0.25;
/// Shortest and longest time at a constant velocity, s.
const HOLD_RANGE_S: (f64, f64) = (0.4, 1.1);
/// Probability that a stop follows a segment of motion.
const STOP_PROBABILITY: f64 = 0.4;

/// Distribution of random pushes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Excitation {
    /// Number of episodes.
    pub count: usize,
    /// Time in contact of each episode, s.
    pub duration: f64,
    /// Largest speed of the gripper, m/s.
    pub speed: f64,
    /// Largest spin of the gripper, rad/s.
    pub spin: f64,
    /// Largest distance of the start from the origin along x and y, m. The start heading is uniform.
    pub spread: f64,
}

impl Default for Excitation {
    fn default() -> Self {
        Self { count: 8, duration: 6.0, speed: 0.25, spin: 0.5, spread: 0.3 }
    }
}

impl Excitation {
    /// Check the values.
    ///
    /// # Errors
    /// If the number of episodes or their duration is out of range, or a limit is negative.
    pub fn check(&self) -> Result<(), SimError> {
        if !(1..=10_000).contains(&self.count) {
            return Err(SimError::value("random.count", self.count, "must lie in 1..10000 episodes"));
        }
        if !(self.duration > RAMP_S && self.duration <= 3600.0) {
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

    /// Draw a push of this body.
    pub fn draw(&self, body: &Body, rng: &mut ChaCha8Rng) -> Push {
        let start = [
            rng.random_range(-1.0..=1.0) * self.spread,
            rng.random_range(-1.0..=1.0) * self.spread,
            rng.random_range(-PI..=PI),
        ];
        let knots = self.draw_knots(rng);
        Push { start, grasp: draw_grasp(body, rng), drive: DriveMode::Velocity, knots }
    }

    /// Segments of constant velocity with ramps between them, some followed by a stop.
    fn draw_knots(&self, rng: &mut ChaCha8Rng) -> Vec<[f64; 4]> {
        let mut knots = vec![[0.0; 4]];
        let mut t = 0.0;
        while t < self.duration {
            let velocity = self.draw_velocity(rng);
            t = append_hold(&mut knots, t, velocity, rng);
            if rng.random_bool(STOP_PROBABILITY) {
                t = append_hold(&mut knots, t, [0.0; 3], rng);
            }
        }
        truncate(knots, self.duration)
    }

    fn draw_velocity(&self, rng: &mut ChaCha8Rng) -> [f64; 3] {
        let speed = self.speed * rng.random_range(0.3..=1.0);
        let (sin, cos) = rng.random_range(0.0..TAU).sin_cos();
        [speed * cos, speed * sin, self.spin * rng.random_range(-1.0..=1.0)]
    }
}

/// Append a ramp to a velocity and a hold. Returns the end time, s.
fn append_hold(knots: &mut Vec<[f64; 4]>, t: f64, [x, y, spin]: [f64; 3], rng: &mut ChaCha8Rng) -> f64 {
    let end = t + RAMP_S + rng.random_range(HOLD_RANGE_S.0..=HOLD_RANGE_S.1);
    knots.extend([[t + RAMP_S, x, y, spin], [end, x, y, spin]]);
    end
}

/// The knots before `end`, and a last knot at `end`.
fn truncate(mut knots: Vec<[f64; 4]>, end: f64) -> Vec<[f64; 4]> {
    knots.retain(|knot| knot[0] < end);
    if let Some(&last) = knots.last() {
        knots.push([end, last[1], last[2], last[3]]);
    }
    knots
}

/// A grasp near the rim of a random fixture, with uniform gripper heading.
fn draw_grasp(body: &Body, rng: &mut ChaCha8Rng) -> [f64; 3] {
    let angle = rng.random_range(-PI..=PI);
    let index = rng.random_range(0..body.fixtures.len().max(1));
    let (rim, center) = match body.fixtures.get(index) {
        Some(Fixture::Polygon { vertices, .. }) => (draw_rim_point(vertices, rng), vertex_mean(vertices)),
        Some(Fixture::Disc { center: [x, y], radius, .. }) => {
            let (sin, cos) = rng.random_range(0.0..TAU).sin_cos();
            ([x + radius * cos, y + radius * sin], [*x, *y])
        }
        None => ([0.0; 2], [0.0; 2]),
    };
    let [x, y] = [0, 1].map(|k| center[k] + GRASP_RIM_FRACTION * (rim[k] - center[k]));
    [x, y, angle]
}

fn vertex_mean(vertices: &[[f64; 2]]) -> [f64; 2] {
    [0, 1].map(|k| vertices.iter().map(|v| v[k]).sum::<f64>() / vertices.len() as f64)
}

/// A point on a polygon's rim, uniform in arc length.
fn draw_rim_point(vertices: &[[f64; 2]], rng: &mut ChaCha8Rng) -> [f64; 2] {
    let next = vertices.iter().cycle().skip(1);
    let edges: Vec<_> = vertices.iter().zip(next).map(|(&a, &b)| (a, b)).collect();
    let length = |(a, b): &([f64; 2], [f64; 2])| (b[0] - a[0]).hypot(b[1] - a[1]);
    let total: f64 = edges.iter().map(length).sum();
    let mut remaining = rng.random::<f64>() * total;
    for edge in &edges {
        let edge_length = length(edge);
        if remaining < edge_length {
            let (a, b) = edge;
            return [0, 1].map(|k| a[k] + remaining / edge_length * (b[k] - a[k]));
        }
        remaining -= edge_length;
    }
    vertices.first().copied().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    #[test]
    fn grasps_lie_on_the_object_and_commands_stay_within_their_limits() {
        let square =
            Fixture::Polygon { vertices: vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]], density: 1.0 };
        let disc = Fixture::Disc { center: [3.0, 0.5], radius: 0.5, density: 1.0 };
        let body = Body::from_fixtures(vec![square, disc], 2.0).unwrap();
        let excitation = Excitation::default();
        let mut rng = ChaCha8Rng::seed_from_u64(0);
        for _ in 0..200 {
            let push = excitation.draw(&body, &mut rng);
            let [x, y, _] = push.grasp;
            let on_square = (0.0..=1.0).contains(&x) && (0.0..=1.0).contains(&y);
            assert!(on_square || (x - 3.0).hypot(y - 0.5) <= 0.5, "{x} {y}");
            assert!(push.knots.windows(2).all(|pair| pair[0][0] < pair[1][0]));
            assert_eq!(push.knots.last().map(|knot| knot[0]), Some(excitation.duration));
            assert!(push.knots.iter().all(|k| k[1].hypot(k[2]) <= 0.25 + 1e-12 && k[3].abs() <= 0.5));
        }
    }
}
