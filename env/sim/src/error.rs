//! What can be wrong with a scenario or a world.

use std::path::PathBuf;

use trundle_model::ModelError;

/// Why something cannot be simulated.
#[derive(Debug, thiserror::Error)]
pub enum SimError {
    /// A file that cannot be read.
    #[error("{}: cannot be read: {source}", path.display())]
    Io {
        /// Which file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// A file that is not a scenario or an object.
    #[error("{}: {message}", path.display())]
    File {
        /// Which file.
        path: PathBuf,
        /// The key, the value and the remedy.
        message: String,
    },
    /// A value that makes no sense.
    #[error("{key} = {value}: {remedy}")]
    Value {
        /// Name of the key or argument.
        key: String,
        /// As given.
        value: String,
        /// What to give instead.
        remedy: &'static str,
    },
    /// Options of a task that cannot be understood.
    #[error("options: {0}")]
    Options(String),
    /// What should be a saved state.
    #[error("this is no saved state of such a task: {0}")]
    State(String),
    /// More environments than there is memory for.
    #[error(
        "num_envs = {count}: an environment takes up to {each} KiB and {free} MiB are free, so that {most} is the most"
    )]
    TooMany {
        /// As given.
        count: usize,
        /// Memory of an environment, KiB.
        each: u64,
        /// Memory that is free, MiB.
        free: u64,
        /// So many fit.
        most: usize,
    },
    /// A scenario that would not come to an end.
    #[error(
        "the pushes take {} s in all, which is {} {what}, and {most:.0} is the most: shorten the pushes (the time of `push.knots`, `random.duration`), take fewer, or {remedy}",
        short(*seconds),
        short(*got)
    )]
    TooLong {
        /// Time of all pushes with what is recorded before them, s.
        seconds: f64,
        /// "steps" or "samples".
        what: &'static str,
        /// So many.
        got: f64,
        /// So many there may be.
        most: f64,
        /// What else helps.
        remedy: &'static str,
    },
    /// Something that one environment of a batch refuses.
    #[error("environment {0}: {1}")]
    Environment(usize, Box<SimError>),
    /// Threads that the system does not give.
    #[error("no threads to step on: {0}")]
    Threads(String),
    /// A shape that no collider can be made of.
    #[error("{what}: not a simple polygon that encloses an area; give its corners in order (m)")]
    Shape {
        /// Which shape.
        what: String,
    },
    /// The model is not complete or not sound.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The recording would not be valid.
    #[error(transparent)]
    Record(#[from] trundle_record::Error),
}

/// A number of any size in a few digits.
fn short(value: f64) -> String {
    if value < 1e9 { format!("{value:.0}") } else { format!("{value:.1e}") }
}

impl SimError {
    /// A value that makes no sense, and the remedy.
    pub fn value(key: &str, value: impl std::fmt::Debug, remedy: &'static str) -> Self {
        Self::Value { key: key.to_owned(), value: format!("{value:?}"), remedy }
    }
}
