//! Diagnosis of recorded joints: which physics a simulation of a mechanism misses.
//!
//! Efforts are compared along the smoothed measured motion (inverse dynamics). The equation of each joint is nearly
//! linear in its parameters, so that fits take milliseconds, and every effect is tested on left-out parts.

mod answer;
mod backlash;
mod bandwidth;
mod candidates;
mod causal_filter;
mod child_cache;
mod children;
mod competing_models;
mod coupling;
mod cross_validation;
mod deflection;
mod design;
mod drive;
mod dynamics;
mod elimination;
mod equation;
mod error;
mod error_metrics;
mod exchange;
mod fit;
mod fitted_model;
mod gains;
mod intervals;
mod kernel;
mod lack_of_fit;
mod laws;
mod link_motion;
mod location;
mod model;
mod motion;
mod nominal_slots;
mod outcome;
mod payload_statement;
mod periodogram;
mod point_masses;
mod prior;
mod probability_limits;
mod problem;
mod quadratic_cost;
mod refinement;
mod report;
mod resample;
mod residual_scaling;
mod resting_samples;
mod rows;
mod run;
mod search;
mod series;
mod shared_parameters;
mod signals;
mod simulation;
mod simulator;
mod slots;
mod spurious_effects;
mod statement;
mod units;
mod warnings;

pub use answer::{
    JointAlternative, JointAnswer, JointBeforeAfter, JointEffect, JointFit, JointMismatch, JointNominal,
    JointParameter, JointResidual, JointWindow,
};
pub use design::{JointDesigner, JointLimits, NamedEffect, Plan, Separation};
pub use drive::Drive;
pub use dynamics::{AxisLoad, Dynamics, EpisodeDynamics};
pub use error::MechanismError;
pub use error_metrics::{ErrorMetrics, JointErrorMetrics, OpenLoop};
pub use laws::{JointKind, JointSample, JointScales, ParamSpec, Scale, Spec, catalogue};
pub use model::{Effect, Kind};
pub use motion::{EpisodeMotion, Motion, motion};
pub use outcome::{FittedMechanism, JointOutcome};
pub use problem::{AxisSetup, JointSetup, Problem};
pub use run::diagnose_joints;
pub use simulator::{SimulatorParameter, SimulatorSetup};
pub use units::{EffortUnit, Unit};
