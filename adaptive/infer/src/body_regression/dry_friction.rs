//! Dry friction of the whole body on the floor.
//!
//! The floor resists at four points, each with a quarter of the friction, against the velocity of that point (Goyal, Ruina,
//! Papadopoulos 1991). The centre of the points is the mass centre, because friction is proportional to the load.

use nalgebra::Vector3;
use trundle_model::{Effect, Kind, Model, Support, to_body};

use crate::baseline::{StateVector, Transition};

/// Distance of the points from the mass centre, as a fraction of half the sides: between a uniform pressure (0.58) and feet
/// near the corners.
const POINT_RATIO: f64 = 0.7;
/// Times at which a step is sampled, as fractions of it: friction may reverse within a step.
const MIDPOINTS: [f64; 4] = [0.125, 0.375, 0.625, 0.875];
/// Largest squared error, in variances of the noise, of the twist of an object at rest: χ² of three degrees of freedom
/// exceeds it in one of 900 cases.
const MAX_REST_SQUARES: f64 = 16.0;
/// An impulse that would move the object by this multiple of the noise of a velocity, but does not, shows friction.
const CLEAR_MOTION_RATIO: f64 = 6.0;

/// Points where the floor resists, object frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Contact {
    center: [f64; 2],
    /// Distance of the points from the centre along each axis, m.
    reach: [f64; 2],
    /// Variance of an observed velocity of a point along an axis, m²/s².
    variance: f64,
}

/// Wrench of dry friction of 1 N against a twist.
pub(super) struct Sliding {
    /// Object axes about the origin.
    pub wrench: Vector3<f64>,
    /// Share of the friction whose direction the noise of the twist hides: one at rest.
    pub undirected: f64,
}

impl Contact {
    /// `half`: half the sides of the bounding box, m. `noise`: standard deviations of observed twists.
    pub fn new(center: [f64; 2], half: [f64; 2], noise: [f64; 3]) -> Self {
        let reach = half.map(|side| POINT_RATIO * side);
        let [u, v, w] = noise;
        let turning = w * w * (reach[0] * reach[0] + reach[1] * reach[1]);
        Self { center, reach, variance: 0.5 * (u * u + v * v + turning) }
    }

    /// Add dry friction to a model, N.
    pub fn add_to(&self, model: &mut Model, friction: f64) {
        let effect =
            Effect::free(Kind::SupportFriction).with("force", Some(friction)).with("spread", Some(1.0));
        model.body.support = self.points().map(|point| Support { point, share: 0.25 }).to_vec();
        model.effects.push(effect);
    }

    /// The four points, m.
    fn points(&self) -> [[f64; 2]; 4] {
        let ([x, y], [a, b]) = (self.center, self.reach);
        [[x - a, y - b], [x + a, y - b], [x + a, y + b], [x - a, y + b]]
    }

    /// Expected mean wrench of 1 N of friction during a step, from the observed twists before and after it. The direction of a
    /// velocity `v` with the variance `σ²` along each axis has the mean length `|v|/√(|v|² + 2σ²)`.
    pub fn sliding(&self, before: Vector3<f64>, after: Vector3<f64>) -> Sliding {
        let (mut wrench, mut undirected) = (Vector3::zeros(), 0.0);
        for time in MIDPOINTS {
            let [u, v, w] = (before + (after - before) * time).into();
            let hidden = 2.0 * self.variance * (time * time + (1.0 - time) * (1.0 - time));
            for [x, y] in self.points() {
                let at = [u - w * y, v + w * x];
                let square = at[0] * at[0] + at[1] * at[1] + hidden;
                let [fx, fy] = at.map(|component| component / square.sqrt());
                wrench += Vector3::new(fx, fy, x * fy - y * fx);
                undirected += hidden / square;
            }
        }
        let count = (MIDPOINTS.len() * self.points().len()) as f64;
        Sliding { wrench: wrench / count, undirected: undirected / count }
    }

    /// Largest force of the wrenches that the object has withstood at rest since it last moved, N; zero if a free object of
    /// this mass would rest too.
    pub fn withstood(&self, data: &[Transition], noise: [f64; 3], mass: f64) -> f64 {
        let is_at_rest = |step: &&Transition| {
            [&step.before, &step.after].into_iter().all(|state| {
                let twist = body_twist(state);
                (0..3).map(|k| (twist[k] / noise[k]).powi(2)).sum::<f64>() < MAX_REST_SQUARES
            })
        };
        let resting = data.iter().rev().take_while(is_at_rest);
        let (mut impulse, mut most) = (0.0, 0.0f64);
        for step in resting {
            let force = self.force(step.wrench);
            impulse += force * step.dt;
            most = most.max(force);
        }
        let clear = CLEAR_MOTION_RATIO * mass * noise[0].max(noise[1]);
        if impulse > clear { most } else { 0.0 }
    }

    /// Friction that withstands a wrench at least, N: the norm of force and torque over the distance of the points.
    fn force(&self, [fx, fy, torque]: [f64; 3]) -> f64 {
        let [x, y] = self.center;
        let about_center = torque - (x * fy - y * fx);
        let [a, b] = self.reach;
        (fx * fx + fy * fy + about_center * about_center / (a * a + b * b)).sqrt()
    }
}

/// Twist of the object's origin, object axes.
pub(super) fn body_twist(&[_, _, heading, vx, vy, spin]: &StateVector) -> Vector3<f64> {
    Vector3::from(to_body([vx, vy, spin], heading))
}
