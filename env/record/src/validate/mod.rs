//! Validation: the conditions that every recording must satisfy. Validation never changes a recording.

pub(crate) mod cells;
mod metadata;
mod name;
mod polygon;
mod requirements;
mod split;
mod table;

pub(crate) use name::{check_name, is_printable};
pub(crate) use split::{check_names, check_training, known as check_known_episode};

use crate::error::Error;
use crate::recording::Recording;

impl Recording {
    /// Checks metadata and tables against the format.
    ///
    /// # Errors
    /// The first fault found, with its file, row, column, value and remedy.
    pub fn validate(&self) -> Result<(), Error> {
        metadata::check(&self.metadata)?;
        split::check(self)?;
        for episode in &self.episodes {
            table::check(episode, &self.metadata)?;
            requirements::check(episode, &self.metadata)?;
        }
        split::check_precontact(self)
    }
}
