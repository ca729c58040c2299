//! Inner loops of the experiments of Scholz et al., "Learning Non-Holonomic Object Models for Mobile Manipulation".
//!
//! [`learning_curves`] scores models learned from noisy pushes (Figs. 6 and 8). [`OpenLoopTrial`] executes plans
//! made with a wrong model without feedback.

mod error;
mod learner;
mod learning_curves;
mod observations;
mod open_loop;
mod path_task;

pub use error::PaperError;
pub use learner::{Learner, PbrSettings, fit_physics};
pub use learning_curves::{LearningCurves, learning_curves};
pub use observations::{ObservationNoise, Observations};
pub use open_loop::{ModelError, OpenLoopOutcome, OpenLoopTrial};
pub use path_task::{PathTask, Plan, WrenchAxes};
