//! Diagnosis: find where a simulation and a recording differ, name the missing effects, or report that no law
//! of the catalogue explains the difference.
//!
//! [`diagnose`] fits the nominal model, screens every effect of the catalogue, and fits the effects with the
//! largest promised gain. It keeps effects that the model evidence and a block bootstrap on left-out episodes
//! support. The answer has the format `trundle-diagnosis/1`.

mod answer;
mod best_subset;
pub mod black_box;
mod block_bootstrap;
mod candidates;
mod competing_models;
mod contact_candidates;
mod cross_validation;
mod decision;
mod definition;
pub mod design;
mod discrepancy;
mod effect_report;
mod eligibility;
mod engine;
mod fit_check;
mod fitted_model;
mod lack_of_fit;
mod linear_model;
mod linearisation;
mod locate;
mod missing_wrenches;
mod nominal;
mod parameter;
mod periods;
mod place;
mod platt;
mod predictions;
mod predictive_check;
mod proposals;
mod pushing_time;
mod report;
mod ridge_candidates;
mod run;
mod screen;
mod search;
mod selection;
mod series;
mod stages;
mod statements;
mod thresholds;
mod units;
mod verdict;
mod warnings;

pub use answer::{Answer, Quantity, Verdict};
pub use block_bootstrap::{PredictedSample, PredictedSamples, correlation_time, probability_of_gain};
pub use fit_check::{FitCheck, check_fit};
pub use nominal::for_recording;
pub use platt::{calibrated, platt};
pub use predictions::{Predictions, predict, prediction_scores};
pub use report::Outcome;
pub use run::{Options, diagnose, diagnose_recording};
pub use series::Series;
pub use stages::STAGES;
pub use thresholds::{
    MAX_RESIDUAL_GAIN_SHARE, MAX_TIE_DIFFERENCE_NATS, MIN_EFFECT_PROBABILITY, MIN_MATERIAL_ERROR_RATIO,
    NEGLIGIBLE_SHARE, max_given_cost,
};
pub use warnings::{ErrorMetric, harmful_effect, unlike_training, worse_metrics};
