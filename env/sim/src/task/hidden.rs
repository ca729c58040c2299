//! Hidden effects that the agent must identify.

use std::f64::consts::PI;

use rand::RngExt;
use rand::seq::IndexedRandom;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use trundle_model::{Body, Effect, GeneralisedForce, Kind, MAX_INNER_STATES, Model, Prior};

use super::options::{HiddenKind, Options};
use super::task_objects::TaskObject;
use crate::SimError;
use crate::simulate::draw_initial_inner;

/// Range of the friction of a rolling wheel along its rolling direction, N·s/m.
const ROLLING_FRICTION_N_S_PER_M: (f64, f64) = (3.0, 12.0);
/// Range of the lateral friction of a fixed wheel, N·s/m.
const LATERAL_FRICTION_N_S_PER_M: (f64, f64) = (120.0, 400.0);
/// Range of a caster's trail, m.
const CASTER_TRAIL_M: (f64, f64) = (0.03, 0.08);
/// Largest offset of the wrist sensor, `[N, N, N·m]`.
const MAX_SENSOR_OFFSET: [f64; 3] = [2.0, 2.0, 0.2];
/// Standard deviation of the log-normal factor on a configuration's friction.
const FRICTION_LOG_SD: f64 = 0.3;
/// Number of effect kinds that can be drawn, from the start of the catalogue. It is the size of the catalogue when the
/// environments were first published, so that the effects of a seed do not depend on later additions.
const DRAWN_EFFECT_KINDS: usize = 24;
/// Largest number of draws until an effect is compatible with the model.
const MAX_EFFECT_DRAWS: u32 = 50;

/// Hidden effects and the offset of the wrist sensor.
#[derive(Clone, Debug, PartialEq)]
pub struct HiddenEffects {
    /// Effects, with all values given.
    pub effects: Vec<Effect>,
    /// Initial internal states of the laws.
    pub inner: [f64; MAX_INNER_STATES],
    /// Offset of the wrist sensor, `[N, N, N·m]`.
    pub offset: [f64; 3],
}

impl HiddenEffects {
    /// Draw the hidden effects of an object. The effects `extra` are always included.
    pub fn draw(
        task_object: &TaskObject,
        options: &Options,
        extra: &[Effect],
        rng: &mut ChaCha8Rng,
    ) -> Result<Self, SimError> {
        let (kind, friction) = (options.hidden, options.locked_friction());
        let mut effects = match kind {
            HiddenKind::None => vec![],
            HiddenKind::Locked => vec![draw_locked_wheel(task_object, friction, rng)],
            HiddenKind::Configuration => draw_configuration(task_object, rng),
            HiddenKind::Wheels | HiddenKind::Catalogue if task_object.has_directional_wheel() => {
                draw_wheels(task_object, friction, rng)
            }
            HiddenKind::Wheels | HiddenKind::Catalogue => draw_configuration(task_object, rng),
        };
        effects.extend_from_slice(extra);
        if kind == HiddenKind::Catalogue {
            effects = with_catalogue_effect(task_object, effects, rng)?;
        }
        let offset = MAX_SENSOR_OFFSET.map(|most| rng.random_range(-most..=most));
        let mut hidden = Self { effects, inner: [0.0; MAX_INNER_STATES], offset };
        hidden.inner = draw_initial_inner(&hidden.model(&task_object.body), rng);
        Ok(hidden)
    }

    /// The model of the object with all effects.
    pub fn model(&self, body: &Body) -> Model {
        model(body, self.effects.clone())
    }

    /// Total damping matrix of all viscous wheels about the object origin, `[xx, xy, yy, xθ, yθ, θθ]`. Motion determines only
    /// this sum.
    pub fn total_damping(&self) -> [f64; 6] {
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

fn draw_locked_wheel(task_object: &TaskObject, friction: (f64, f64), rng: &mut ChaCha8Rng) -> Effect {
    let at = draw_foot(task_object, rng);
    let (mu_x, mu_y) = (log_uniform(friction, rng), log_uniform(friction, rng));
    wheel(at, rng.random_range(0.0..PI), mu_x, mu_y)
}

/// One wheel is locked, fixed or a caster. The others roll in all directions.
fn draw_wheels(task_object: &TaskObject, friction: (f64, f64), rng: &mut ChaCha8Rng) -> Vec<Effect> {
    let one = rng.random_range(0..task_object.feet.len().max(1));
    let mut effects = vec![];
    for (k, &at) in task_object.feet.iter().enumerate() {
        let rolling = log_uniform(ROLLING_FRICTION_N_S_PER_M, rng);
        if k != one {
            effects.push(wheel(at, 0.0, rolling, rolling));
            continue;
        }
        let angle = rng.random_range(0.0..PI);
        effects.push(match rng.random_range(0..4) {
            0 | 1 => wheel(at, angle, log_uniform(friction, rng), log_uniform(friction, rng)),
            2 => wheel(at, angle, rolling, log_uniform(LATERAL_FRICTION_N_S_PER_M, rng)),
            _ => caster(at, log_uniform(CASTER_TRAIL_M, rng), log_uniform(friction, rng)),
        });
    }
    effects
}

/// A random configuration of the object, with random factors on its friction.
fn draw_configuration(task_object: &TaskObject, rng: &mut ChaCha8Rng) -> Vec<Effect> {
    let mut effects = task_object.configurations.choose(rng).cloned().unwrap_or_default();
    for effect in &mut effects {
        let factor = (FRICTION_LOG_SD * rng.sample::<f64, _>(StandardNormal)).exp();
        for (value, param) in effect.values.iter_mut().zip(effect.kind.spec().params) {
            if matches!(param.prior, Prior::LogNormal { .. }) && param.refinement.is_none() {
                *value = value.map(|v| (v * factor).clamp(param.lower, param.upper));
            }
        }
    }
    effects
}

/// The effects with one random effect of the catalogue, drawn from its prior.
fn with_catalogue_effect(
    task_object: &TaskObject,
    effects: Vec<Effect>,
    rng: &mut ChaCha8Rng,
) -> Result<Vec<Effect>, SimError> {
    let offered = Kind::ALL.get(..DRAWN_EFFECT_KINDS).unwrap_or(Kind::ALL);
    for _ in 0..MAX_EFFECT_DRAWS {
        let Some(&kind) = offered.choose(rng) else { break };
        let mut model = model(&task_object.body, effects.clone()).with(Effect::free(kind));
        let free = model.slots().into_iter().map(|slot| slot.value.unwrap_or_else(|| draw_value(&slot, rng)));
        let values: Vec<f64> = free.collect();
        // Some effects are incompatible, and the number of internal states is limited.
        if let Ok(filled) = model.with_values(&values) {
            model = filled;
            return Ok(model.effects);
        }
    }
    Ok(effects)
}

fn draw_value(slot: &trundle_model::Slot, rng: &mut ChaCha8Rng) -> f64 {
    let normal: f64 = rng.sample(StandardNormal);
    let value = match slot.prior {
        Prior::Normal { mean, sd } => mean + sd * normal,
        Prior::LogNormal { median, sd } => median * (sd * normal).exp(),
        Prior::Angle(period) => rng.random_range(0.0..period),
        Prior::Uniform | Prior::OnBody(_) => rng.random_range(slot.lower..=slot.upper),
    };
    value.clamp(slot.lower, slot.upper)
}

fn draw_foot(task_object: &TaskObject, rng: &mut ChaCha8Rng) -> [f64; 2] {
    task_object.feet.choose(rng).copied().unwrap_or_default()
}

fn wheel([x, y]: [f64; 2], angle: f64, mu_x: f64, mu_y: f64) -> Effect {
    Effect { kind: Kind::ViscousWheel, values: [x, y, angle, mu_x, mu_y].map(Some).to_vec() }
}

fn caster([x, y]: [f64; 2], trail: f64, mu_side: f64) -> Effect {
    Effect { kind: Kind::CasterSwivel, values: [x, y, trail, mu_side].map(Some).to_vec() }
}

fn log_uniform((low, high): (f64, f64), rng: &mut ChaCha8Rng) -> f64 {
    rng.random_range(low.ln()..=high.ln()).exp()
}
