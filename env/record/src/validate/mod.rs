//! What a recording must satisfy before anything is computed from it. Nothing is repaired.

mod metadata;
mod needs;
mod polygon;
mod split;
mod table;

pub(crate) use split::check_name;

use crate::error::Error;
use crate::recording::Recording;

impl Recording {
    /// Checks everything that the format asks of metadata and tables.
    ///
    /// # Errors
    /// The first fault found, with its file, row, column, value and the remedy.
    pub fn validate(&self) -> Result<(), Error> {
        metadata::check(&self.metadata)?;
        split::check(self)?;
        for episode in &self.episodes {
            table::check(episode, &self.metadata)?;
            needs::check(episode, &self.metadata)?;
        }
        split::check_precontact(self)
    }
}
