//! How long work says where it is, and learns that it should stop.

/// Told of progress, asked whether to go on.
pub trait Watch: Sync {
    /// Work has come to `done` (0 to 1) of `what`.
    fn progress(&self, what: &str, done: f64);
    /// Whether the user wants it to stop; asked often, on the calling thread only.
    fn cancelled(&self) -> bool;
}

/// Says nothing, never stops.
pub struct Quiet;

impl Watch for Quiet {
    fn progress(&self, _what: &str, _done: f64) {}
    fn cancelled(&self) -> bool {
        false
    }
}
