//! Errors of scenarios, worlds and tasks.

use std::path::PathBuf;

use trundle_model::ModelError;

/// Error of a simulation or of its input.
#[derive(Debug, thiserror::Error)]
pub enum SimError {
    /// A file cannot be read.
    #[error("{}: cannot be read: {source}", path.display())]
    Io {
        /// Path of the file.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// A file is not a valid scenario or object.
    #[error("{}: {message}", path.display())]
    File {
        /// Path of the file.
        path: PathBuf,
        /// Key, value and remedy.
        message: String,
    },
    /// A value is out of its range.
    #[error("{key} = {value}: {remedy}")]
    Value {
        /// Name of the key or argument.
        key: String,
        /// The given value.
        value: String,
        /// Valid values.
        remedy: &'static str,
    },
    /// The options of a task cannot be parsed.
    #[error("options: {0}")]
    Options(String),
    /// Bytes are not a saved state.
    #[error("not a saved state of this task: {0}")]
    State(String),
    /// The environments do not fit into memory.
    #[error(
        "num_envs = {count}: must not exceed {max_count}; an environment takes up to {each_kib} KiB and {free_mib} MiB are free"
    )]
    TooManyEnvironments {
        /// Requested number of environments.
        count: usize,
        /// Memory of an environment, KiB.
        each_kib: u64,
        /// Available memory, MiB.
        free_mib: u64,
        /// Largest number of environments.
        max_count: usize,
    },
    /// A scenario takes too long or too much memory.
    #[error(
        "the pushes take {} s in total, which is {} {what}; the limit is {limit:.0}: shorten the pushes (times of `push.knots`, `random.duration`), reduce their number, or {remedy}",
        short(*seconds),
        short(*requested)
    )]
    ScenarioTooLong {
        /// Duration of all pushes and their pre-contact intervals, s.
        seconds: f64,
        /// Counted quantity: "steps" or "samples".
        what: &'static str,
        /// Requested number.
        requested: f64,
        /// Largest number.
        limit: f64,
        /// Further remedy.
        remedy: &'static str,
    },
    /// An error in one environment of a batch.
    #[error("environment {0}: {1}")]
    Environment(usize, Box<SimError>),
    /// The thread pool cannot be created.
    #[error("cannot create the thread pool: {0}")]
    Threads(String),
    /// A shape cannot become a collider.
    #[error("{what}: not a simple polygon that encloses an area; list its corners in order (m)")]
    Shape {
        /// Name of the shape.
        what: String,
    },
    /// The model is incomplete or invalid.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The recording is invalid.
    #[error(transparent)]
    Record(#[from] trundle_record::Error),
}

/// A number of any magnitude in a few digits.
fn short(value: f64) -> String {
    if value < 1e9 { format!("{value:.0}") } else { format!("{value:.1e}") }
}

impl SimError {
    /// An out-of-range value with its remedy.
    pub fn value(key: &str, value: impl std::fmt::Debug, remedy: &'static str) -> Self {
        Self::Value { key: key.to_owned(), value: format!("{value:?}"), remedy }
    }
}
