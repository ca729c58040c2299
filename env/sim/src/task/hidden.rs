//! What the agent must find out: which wheel is locked, and how firmly.

use std::f64::consts::PI;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use trundle_model::{Body, Effect, Kind, Model};

use super::rules::{HALF, MASS, WHEELS};
use crate::SimError;

/// Least and greatest friction of the locked wheel in its two directions, N·s/m.
const LOCKED: (f64, f64) = (60.0, 300.0);
/// Largest offset of the wrist sensor, `[N, N, N·m]`.
const OFFSET: [f64; 3] = [2.0, 2.0, 0.2];

/// A hidden wheel, and the offset of the sensor that touches the object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hidden {
    /// x, y, angle, μ_x, μ_y as in `viscous_wheel`.
    pub wheel: [f64; 5],
    /// `[N, N, N·m]`.
    pub offset: [f64; 3],
}

impl Hidden {
    pub(super) fn draw(random: &mut ChaCha8Rng) -> Self {
        let [x, y] = WHEELS[random.random_range(0..WHEELS.len())];
        let mut friction = || random.random_range(LOCKED.0.ln()..=LOCKED.1.ln()).exp();
        let (mu_x, mu_y) = (friction(), friction());
        let angle = random.random_range(0.0..PI);
        let offset = OFFSET.map(|most| random.random_range(-most..=most));
        Self { wheel: [x, y, angle, mu_x, mu_y], offset }
    }

    pub(super) fn model(&self) -> Result<Model, SimError> {
        let wheel = Effect { kind: Kind::ViscousWheel, values: self.wheel.map(Some).to_vec() };
        Ok(Model {
            body: table()?,
            mass: Some(MASS),
            dof: [true; 3],
            effects: vec![wheel],
            priors: Default::default(),
            unnamed: None,
        })
    }
}

/// The table as anybody can see it.
pub(super) fn table() -> Result<Body, SimError> {
    let [x, y] = HALF;
    Ok(Body::from_footprint(&[[-x, -y], [x, -y], [x, y], [-x, y]], MASS)?.standing_on(&WHEELS))
}
