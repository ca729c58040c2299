//! Posterior of a model's parameters after a recording: draws, and simulation-based calibration of their
//! intervals.

#[cfg(test)]
mod bench;
mod calibrate;
mod canonical;
mod chain;
mod draws;
mod error;
mod metropolis;
mod modes;
mod nuts;
mod predictive;
mod sample;
mod whitened;

pub use calibrate::{Calibration, Line, RANKS, Replicate, lines, replicates};
pub use chain::{Chain, Length, Method};
pub use draws::{Draws, Range};
pub use error::PosteriorError;
pub use modes::{Found, Mode, ModeSummary, Search, search_modes};
pub use predictive::{Predicted, predictive};
pub use sample::{Posterior, SampleOptions, sample};
pub use whitened::Whitened;
