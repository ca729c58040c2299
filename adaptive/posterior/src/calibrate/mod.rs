//! Simulation-based calibration (Talts, Betancourt, Simpson, Vehtari & Gelman 2018).
//!
//! ```text
//! φ* ~ prior,   data ~ p(data | φ*),   φ₁ … φ_L ~ p(φ | data):   the rank of φ* among the φ is uniform
//! ```
//!
//! The data are simulated from the model that the likelihood assumes, so a rank that is not uniform shows an
//! error of the inference.

mod config;
mod ranks;
mod replicate;
mod world;

pub use config::Calibration;
pub use ranks::{CalibrationTable, ParameterCalibration, calibrations};
pub use replicate::{RANKS, Replicate, replicates};
