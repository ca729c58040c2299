//! Stages of a diagnosis, for its progress.

use trundle_infer::Stage;

/// The stages in order. `end` is a rough mean over recordings and only affects the estimate of the remaining
/// time.
pub const STAGES: [Stage; 7] = [
    Stage { name: "the simulation under test", end: 0.3, rounds: 4.0 },
    Stage { name: "single effects", end: 0.65, rounds: 3.0 },
    Stage { name: "several effects", end: 0.85, rounds: 6.0 },
    Stage { name: "left-out episodes", end: 0.92, rounds: 3.0 },
    Stage { name: "error metrics", end: 0.95, rounds: 1.0 },
    Stage { name: "model discrepancy", end: 0.98, rounds: 3.0 },
    Stage { name: "designing pushes", end: 1.0, rounds: 1.0 },
];
