//! Simulation-based calibration (Talts, Betancourt, Simpson, Vehtari & Gelman 2018).
//!
//! ```text
//! φ* ~ prior,   data ~ p(data | φ*),   φ₁ … φ_L ~ p(φ | data):   the rank of φ* among the φ is uniform
//! ```
//!
//! The data are made as the likelihood believes that data are made, so that a rank that is not uniform
//! is a fault of the inference and of nothing else.

mod config;
mod ranks;
mod replicate;
mod world;

pub use config::Calibration;
pub use ranks::{Line, lines};
pub use replicate::{RANKS, Replicate, replicates};
