//! Conversion of [`JointMetadata`] to and from the text and the table of `recording.toml`.

use toml::{Table, Value};

use super::metadata::JointMetadata;
use crate::document::{key, parse, refuse_format, take_notes, unwritable};
use crate::error::Error;
use crate::fault::Fault;
use crate::metadata::FORMAT;

impl JointMetadata {
    /// Parses the text of `recording.toml`.
    ///
    /// # Errors
    /// If the text is not TOML, a key is unknown or missing, or a value has the wrong type.
    /// [`crate::JointRecording::validate`] checks the values themselves.
    pub fn from_toml(text: &str) -> Result<Self, Error> {
        Self::from_table(parse(text)?)
    }

    /// Converts the table of `recording.toml`.
    ///
    /// # Errors
    /// As [`JointMetadata::from_toml`].
    pub fn from_table(mut table: Table) -> Result<Self, Error> {
        let objects = "trundle.read or Recording::read";
        let other =
            Fault::OtherFormat { format: FORMAT, what: "recordings of pushed objects", reader: objects };
        refuse_format(&table, other)?;
        let notes = take_notes(&mut table)?;
        let metadata: Self = table.try_into().map_err(|error| key(&error))?;
        Ok(Self { notes, ..metadata })
    }

    /// The table that [`JointMetadata::from_table`] accepts.
    ///
    /// # Errors
    /// If a value cannot be represented in TOML.
    pub fn to_table(&self) -> Result<Table, Error> {
        let mut table = Table::try_from(self).map_err(|error| unwritable(&error))?;
        if !self.notes.is_empty() {
            table.insert("notes".to_owned(), Value::Table(self.notes.clone()));
        }
        Ok(table)
    }

    /// The text that [`JointMetadata::from_toml`] accepts. Floats survive the round trip exactly.
    ///
    /// # Errors
    /// If a value cannot be represented in TOML.
    pub fn to_toml(&self) -> Result<String, Error> {
        toml::to_string(&self.to_table()?).map_err(|error| unwritable(&error))
    }
}
