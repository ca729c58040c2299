//! A recording in memory, and the way to and from its folder.

use crate::episode::Episode;
use crate::metadata::Metadata;

/// A whole recording: what the columns mean, and the episodes in the order in which they happened.
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    /// `recording.toml`.
    pub metadata: Metadata,
    /// Sorted by name.
    pub episodes: Vec<Episode>,
}
