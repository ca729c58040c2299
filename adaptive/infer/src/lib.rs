//! Physics-based regression: estimation of a model's parameters from recordings.
//!
//! A [`Likelihood`] compares a model with a recording. [`fit`] maximises the posterior density from several
//! seeded starts with gradients of the likelihood. The resulting [`Fit`] holds the estimates, their
//! covariance and the log evidence of the model.

mod bandwidth;
mod baseline;
mod body_regression;
mod brent;
mod comparison;
mod coordinates;
mod covariance;
mod curve;
mod error;
mod error_metrics;
mod filter;
mod fit;
mod fit_options;
mod footprint_prior;
mod identify;
mod inertial;
mod initial_state;
mod joint;
mod lbfgs;
mod levenberg;
mod likelihood;
mod motion;
mod noise;
mod online;
mod optimum;
mod profile;
mod progress;
mod quasi_static;
mod readings;
mod resting_readings;
mod rollout;
mod sandwich;
mod score;
mod search;
mod sensitivity;
mod shooting;
mod simulation;
mod steady_segments;
mod target;
mod timing;
mod track;
mod truncated_normal;
mod unsmoothed;
mod watch;
mod wrench_sample;

pub use baseline::{
    BaselineError, ConstantVelocity, Features, Linear, Local, Predictor, Pushes, SigmaReading, StateVector,
    Transition, hold, noisy, r2, r2_of, transitions, transitions_of,
};
pub use body_regression::{BodyRegression, StepNoise};
pub use comparison::{Comparison, is_quasi_static};
pub use coordinates::{Coordinates, IDENTIFIED_SD, PriorConflict};
pub use error::InferError;
pub use error_metrics::{ErrorMetrics, Score};
pub use filter::{Innovation, Residual, Response};
pub use fit::{Estimate, Fit, fit, transferred_values};
pub use fit_options::{FitOptions, Optimiser};
pub use footprint_prior::{FootprintPenalty, FootprintPrior};
pub use identify::{Combination, Direction, Identifiability, Pair};
pub use inertial::InertialLikelihood;
pub use initial_state::{SETTLING_TIME_S, unscored_time};
pub use joint::Joint;
pub use likelihood::{Evaluation, Likelihood, Linearised};
pub use motion::{FilteredEpisodes, MotionLikelihood};
pub use noise::Channels;
pub use online::{Online, OnlineOptions};
pub use profile::{Profile, Shape, profile};
pub use progress::{Progress, Stage};
pub use quasi_static::WrenchLikelihood;
pub use readings::Readings;
pub use rollout::{PREDICTION_WINDOW_S, Window, open_loop, windows};
pub use sandwich::{Basis, INTERVAL_COVERAGE};
pub use score::{score, score_compared};
pub use shooting::{Cut, Loss, Scatter, Shooting, guided_fit};
pub use steady_segments::wrench_samples;
pub use target::{Density, Target};
pub use track::{Step, Track};
pub use unsmoothed::unsmoothed;
pub use watch::{Quiet, Watch, on_all_cores};
pub use wrench_sample::WrenchSample;
