//! Estimation as users call it: the choice of a likelihood, a fit to one or several recordings with its
//! lack-of-fit test and summary, profiles, draws of posteriors, and online estimation.
//!
//! The crate combines the likelihoods of `trundle-infer`, the searches of `trundle-posterior`, the lack-of-fit
//! test of `trundle-diagnose` and the obstacles of `trundle-sim`.

mod checked_fit;
mod error;
mod fit;
mod identifiability;
mod likelihood;
mod online;
mod profile;
mod recordings;
mod sample;
mod start;
mod summary;

pub use checked_fit::{CheckedFit, LackOfFitSummary};
pub use error::EstimateError;
pub use fit::{FitReport, FitRequest, fit_recordings};
pub use identifiability::IdentifiabilitySummary;
pub use likelihood::{LikelihoodChoice, LikelihoodKind, LikelihoodOptions, loss_named};
pub use online::OnlineEstimator;
pub use profile::{ProfileRequest, ProfileSummary, profile_recording};
pub use recordings::combined;
pub use sample::{SampleRequest, SampleSummary, SampledParameter, SampledPosterior, sample_recording};
pub use summary::{FitSummary, NoiseSummary};
