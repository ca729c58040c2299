//! Posterior of a model's parameters after a recording: draws, and simulation-based calibration of their
//! intervals.

mod calibrate;
mod canonical;
mod chain;
mod draws;
mod error;
mod metropolis;
mod modes;
mod nuts;
mod pointwise;
mod predictive;
mod sample;
mod sampler;
#[cfg(test)]
mod test_densities;
mod whitened;

pub use calibrate::{
    Calibration, CalibrationTable, ParameterCalibration, RANKS, Replicate, calibrations, replicates,
};
pub use chain::{Chain, ChainSettings, Method};
pub use draws::{Draws, Range};
pub use error::PosteriorError;
pub use modes::{FoundModes, Mode, ModeSummary, SearchExtent, search_modes};
pub use pointwise::PointwiseLogLikelihood;
pub use predictive::{Predicted, predictive};
pub use sample::{Posterior, SampleOptions, sample};
pub use whitened::Whitened;
