//! What the agent must find out: which wheel is locked, and what else acts on the object.

use std::f64::consts::PI;

use rand::RngExt;
use rand::seq::IndexedRandom;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use trundle_model::{Body, Effect, GeneralisedForce, Kind, MAX_INNER_STATES, Model, Prior};

use super::options::Secret;
use super::things::Thing;
use crate::SimError;
use crate::simulate::beginning;

/// Least and greatest friction of a locked wheel in its two directions, N·s/m.
const LOCKED: (f64, f64) = (60.0, 300.0);
/// Of a wheel that rolls, along its way.
const ROLLING: (f64, f64) = (3.0, 12.0);
/// Across the way of one that cannot turn.
const ACROSS: (f64, f64) = (120.0, 400.0);
/// How far a caster trails, m.
const TRAIL: (f64, f64) = (0.03, 0.08);
/// Largest offset of the wrist sensor, `[N, N, N·m]`.
const OFFSET: [f64; 3] = [2.0, 2.0, 0.2];
/// Standard deviation of the logarithm of a configuration's friction.
const SCATTER: f64 = 0.3;
/// Kinds of effects that are drawn, from the catalogue's first on: those that there were when the environments were first
/// published. What a seed hides must not change with the catalogue.
const OFFERED: usize = 24;
/// Draws of an effect until one fits the model.
const TRIES: u32 = 50;

/// Effects that nobody is told of, and the offset of the sensor that touches the object.
#[derive(Clone, Debug, PartialEq)]
pub struct Hidden {
    /// All values given.
    pub effects: Vec<Effect>,
    /// Where the laws' own states start.
    pub inner: [f64; MAX_INNER_STATES],
    /// `[N, N, N·m]`.
    pub offset: [f64; 3],
}

impl Hidden {
    /// Draw what is hidden of an object; `more` is there in any case.
    pub fn draw(
        thing: &Thing,
        secret: Secret,
        more: &[Effect],
        random: &mut ChaCha8Rng,
    ) -> Result<Self, SimError> {
        let mut effects = match secret {
            Secret::None => vec![],
            Secret::Locked => vec![locked(thing, random)],
            Secret::Configuration => configuration(thing, random),
            Secret::Wheels | Secret::Catalogue if thing.rolls() => wheels(thing, random),
            Secret::Wheels | Secret::Catalogue => configuration(thing, random),
        };
        effects.extend_from_slice(more);
        if secret == Secret::Catalogue {
            effects = with_any(thing, effects, random)?;
        }
        let offset = OFFSET.map(|most| random.random_range(-most..=most));
        let mut hidden = Self { effects, inner: [0.0; MAX_INNER_STATES], offset };
        hidden.inner = beginning(&hidden.model(&thing.body), random);
        Ok(hidden)
    }

    /// The object with all that acts on it.
    pub fn model(&self, body: &Body) -> Model {
        model(body, self.effects.clone())
    }

    /// Drag of all viscous wheels together about the object's origin, `[xx, xy, yy, xθ, yθ, θθ]`: all that can be
    /// known of them from motion.
    pub fn drag(&self) -> [f64; 6] {
        let mut sum = GeneralisedForce::zero();
        for effect in self.effects.iter().filter(|e| e.kind == Kind::ViscousWheel) {
            let [x, y, angle, mu_x, mu_y] = [0, 1, 2, 3, 4].map(|k| effect.values[k].unwrap_or(0.0));
            let (sin, cos) = angle.sin_cos();
            let mixed = (mu_x - mu_y) * sin * cos;
            sum.add_damping_at(
                [x, y],
                [mu_x * cos * cos + mu_y * sin * sin, mixed, mu_x * sin * sin + mu_y * cos * cos],
            );
        }
        sum.damping
    }
}

fn model(body: &Body, effects: Vec<Effect>) -> Model {
    let (body, mass) = (body.clone(), Some(body.mass));
    Model { body, mass, dof: [true; 3], effects, priors: Default::default(), discrepancy: None }
}

fn locked(thing: &Thing, random: &mut ChaCha8Rng) -> Effect {
    let at = foot(thing, random);
    let (mu_x, mu_y) = (even_log(LOCKED, random), even_log(LOCKED, random));
    wheel(at, random.random_range(0.0..PI), mu_x, mu_y)
}

/// One wheel that is locked, fixed or a caster; the others roll any way.
fn wheels(thing: &Thing, random: &mut ChaCha8Rng) -> Vec<Effect> {
    let one = random.random_range(0..thing.feet.len().max(1));
    let mut effects = vec![];
    for (k, &at) in thing.feet.iter().enumerate() {
        let rolling = even_log(ROLLING, random);
        if k != one {
            effects.push(wheel(at, 0.0, rolling, rolling));
            continue;
        }
        let angle = random.random_range(0.0..PI);
        effects.push(match random.random_range(0..4) {
            0 | 1 => wheel(at, angle, even_log(LOCKED, random), even_log(LOCKED, random)),
            2 => wheel(at, angle, rolling, even_log(ACROSS, random)),
            _ => caster(at, even_log(TRAIL, random), even_log(LOCKED, random)),
        });
    }
    effects
}

/// One of the object's own, its friction scattered: no two of its kind are alike.
fn configuration(thing: &Thing, random: &mut ChaCha8Rng) -> Vec<Effect> {
    let mut effects = thing.configurations.choose(random).cloned().unwrap_or_default();
    for effect in &mut effects {
        let factor = (SCATTER * random.sample::<f64, _>(StandardNormal)).exp();
        for (value, param) in effect.values.iter_mut().zip(effect.kind.spec().params) {
            if matches!(param.prior, Prior::LogNormal { .. }) && param.refinement.is_none() {
                *value = value.map(|v| (v * factor).clamp(param.lower, param.upper));
            }
        }
    }
    effects
}

/// The same with any one effect of the catalogue, drawn from its prior.
fn with_any(thing: &Thing, effects: Vec<Effect>, random: &mut ChaCha8Rng) -> Result<Vec<Effect>, SimError> {
    let offered = Kind::ALL.get(..OFFERED).unwrap_or(Kind::ALL);
    for _ in 0..TRIES {
        let Some(&kind) = offered.choose(random) else { break };
        let mut model = model(&thing.body, effects.clone()).with(Effect::free(kind));
        let free = model.slots().into_iter().map(|slot| slot.value.unwrap_or_else(|| drawn(&slot, random)));
        let values: Vec<f64> = free.collect();
        // Some effects cannot be together, and the laws' own states are limited.
        if let Ok(filled) = model.with_values(&values) {
            model = filled;
            return Ok(model.effects);
        }
    }
    Ok(effects)
}

fn drawn(slot: &trundle_model::Slot, random: &mut ChaCha8Rng) -> f64 {
    let normal: f64 = random.sample(StandardNormal);
    let value = match slot.prior {
        Prior::Normal { mean, sd } => mean + sd * normal,
        Prior::LogNormal { median, sd } => median * (sd * normal).exp(),
        Prior::Angle(period) => random.random_range(0.0..period),
        Prior::Uniform | Prior::OnBody(_) => random.random_range(slot.lower..=slot.upper),
    };
    value.clamp(slot.lower, slot.upper)
}

fn foot(thing: &Thing, random: &mut ChaCha8Rng) -> [f64; 2] {
    thing.feet.choose(random).copied().unwrap_or_default()
}

fn wheel([x, y]: [f64; 2], angle: f64, mu_x: f64, mu_y: f64) -> Effect {
    Effect { kind: Kind::ViscousWheel, values: [x, y, angle, mu_x, mu_y].map(Some).to_vec() }
}

fn caster([x, y]: [f64; 2], trail: f64, mu_side: f64) -> Effect {
    Effect { kind: Kind::CasterSwivel, values: [x, y, trail, mu_side].map(Some).to_vec() }
}

fn even_log((low, high): (f64, f64), random: &mut ChaCha8Rng) -> f64 {
    random.random_range(low.ln()..=high.ln()).exp()
}
