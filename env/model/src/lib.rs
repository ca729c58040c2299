//! The physics of a pushed body.
//!
//! A [`Model`] is a rigid body plus a list of effects. Each effect is a small law with named parameters. Laws are
//! generic over [`Real`]: simulation, planning (`f64`) and estimation with exact gradients ([`Dual`]) use the same
//! code. The crate is pure mathematics without a physics engine, input or output.
//!
//! Units are SI, angles radians; a *wrench* is `[f_x, f_y, τ]`, a *twist* `[v_x, v_y, ω]`.

mod body;
mod boundary;
mod catalogue;
mod discrepancy;
mod divergence;
mod dual;
mod effects;
mod embedded_laws;
mod error;
mod file;
mod fixture;
mod frames;
mod generalised_force;
mod heading;
mod implicit;
mod kinds;
mod law;
mod linear_propagator;
mod model;
mod mount;
mod outline;
mod plant;
mod polygon;
mod pressure;
mod prior;
mod real;
mod rollout;
mod scales;
mod sliding_propagator;
mod state;
mod stepper;
mod symmetric;
mod values;
mod variable_mass;

pub use body::Body;
pub use catalogue::{Kind, Law, catalogue};
pub use discrepancy::{Axes, Discrepancy, Input};
pub use dual::Dual;
pub use effects::obstacle_contact::obstacle_surface;
pub use embedded_laws::{EmbeddedLaws, EmbeddedStep};
pub use error::{ModelError, NotFinite};
pub use file::Posterior;
pub use fixture::{Fixture, Support};
pub use frames::{to_body, to_world, transport};
pub use generalised_force::GeneralisedForce;
pub use kinds::Proposal;
pub use law::{
    BODY_VALUE, Clock, EffectTarget, InnerState, Lags, LawContext, MAX_INNER_STATES, Param, Prior, Rigid,
    Role, Spec,
};
pub use linear_propagator::LinearPropagator;
pub use model::{Effect, Model, Slot};
pub use plant::Plant;
pub use plant::step::Precision;
pub use prior::{PriorFile, TruncatedPrior};
pub use real::Real;
pub use rollout::rollout;
pub use scales::Scales;
pub use sliding_propagator::SlidingPropagator;
pub use state::State;
pub use stepper::{FreeMotion, ModelInstance, StepError, StepInput, Stepper};

/// Standard gravity, m/s².
pub const STANDARD_GRAVITY_M_PER_S2: f64 = 9.80665;
