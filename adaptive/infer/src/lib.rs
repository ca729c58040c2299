//! Physics-based regression: estimation of a model's parameters from recordings.
//!
//! A [`Likelihood`] compares a model with a recording. [`fit`] maximises the posterior density from several
//! seeded starts with gradients of the likelihood. The resulting [`Fit`] holds the estimates, their
//! covariance and the log evidence of the model.

mod bandwidth;
mod baseline;
mod beginning;
mod brent;
mod comparison;
mod coordinates;
mod covariance;
mod curve;
mod error;
mod filter;
mod fit;
mod footing;
mod identify;
mod inertial;
mod joint;
mod lbfgs;
mod levenberg;
mod likelihood;
mod motion;
mod noise;
mod online;
mod profile;
mod progress;
mod quasi;
mod readings;
mod rest;
mod rollout;
mod sandwich;
mod score;
mod search;
mod sensitivity;
mod shooting;
mod stretches;
mod tally;
mod target;
mod timing;
mod track;
mod truncated;
mod unsmoothed;
mod watch;

pub use baseline::{
    BaselineError, Coasting, Features, Linear, Local, Predictor, Pushes, SigmaReading, StateVector,
    Transition, hold, noisy, r2, r2_of, transitions, transitions_of,
};
pub use beginning::{SETTLING, unjudged};
pub use comparison::{Comparison, MAX_QUASI_STATIC_SHARE, quasi_static};
pub use coordinates::{Coordinates, Strain};
pub use error::InferError;
pub use filter::{Innovation, Residual, Response};
pub use fit::{Estimate, Fit, FitOptions, Optimiser, carried, fit};
pub use footing::{Footing, Pull};
pub use identify::{Combination, Direction, Identifiability, Pair};
pub use inertial::InertialLikelihood;
pub use joint::Joint;
pub use likelihood::{Likelihood, Linearised, Look};
pub use motion::{MotionLikelihood, Seen};
pub use noise::Channels;
pub use online::{Online, OnlineOptions};
pub use profile::{Profile, Shape, profile};
pub use progress::{Progress, Stage};
pub use quasi::{WrenchLikelihood, WrenchSample};
pub use readings::Readings;
pub use rollout::{Window, open_loop, windows};
pub use sandwich::Basis;
pub use score::{Score, score, score_beside};
pub use shooting::{Cut, Loss, Scatter, Shooting, guided_fit};
pub use stretches::wrench_samples;
pub use tally::Tally;
pub use target::{Density, Target};
pub use track::{Step, Track};
pub use unsmoothed::unsmoothed;
pub use watch::{Quiet, Watch, on_all_cores};
