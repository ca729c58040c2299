//! Conversion of [`Metadata`] to and from the text and the table of `recording.toml`.

use toml::{Table, Value};

use crate::error::{Error, Place};
use crate::fault::Fault;
use crate::joints::JOINT_FORMAT;
use crate::metadata::Metadata;

impl Metadata {
    /// Parses the text of `recording.toml`.
    ///
    /// # Errors
    /// If the text is not TOML, a key is unknown or missing, or a value has the wrong type.
    /// [`crate::Recording::validate`] checks the values themselves.
    pub fn from_toml(text: &str) -> Result<Self, Error> {
        Self::from_table(parse(text)?)
    }

    /// Converts the table of `recording.toml`.
    ///
    /// # Errors
    /// As [`Metadata::from_toml`].
    pub fn from_table(mut table: Table) -> Result<Self, Error> {
        let joints = "trundle.read or JointRecording::read";
        let other = Fault::OtherFormat { format: JOINT_FORMAT, what: "recordings of joints", reader: joints };
        refuse_format(&table, other)?;
        lift_at_rest(&mut table)?;
        let notes = take_notes(&mut table)?;
        let metadata: Self = table.try_into().map_err(|error| key(&error))?;
        Ok(Self { notes, ..metadata })
    }

    /// The table that [`Metadata::from_table`] accepts.
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

    /// The text that [`Metadata::from_toml`] accepts. Floats survive the round trip exactly.
    ///
    /// # Errors
    /// If a value cannot be represented in TOML.
    pub fn to_toml(&self) -> Result<String, Error> {
        toml::to_string(self).map_err(|error| unwritable(&error))
    }
}

/// Moves `at_rest` to the top level. The example of the format writes it after the tables of the object, where TOML
/// makes it a key of the last of these tables.
fn lift_at_rest(table: &mut Table) -> Result<(), Error> {
    let mut given: Vec<Value> = table.remove("at_rest").into_iter().collect();
    if let Some(Value::Table(object)) = table.get_mut("object") {
        given.extend(object.remove("at_rest"));
        if let Some(Value::Array(fixtures)) = object.get_mut("fixture") {
            let tables = fixtures.iter_mut().filter_map(Value::as_table_mut);
            given.extend(tables.filter_map(|fixture| fixture.remove("at_rest")));
        }
    }
    given.dedup();
    if given.len() > 1 {
        let message =
            "`at_rest` is set twice, with different values; keep one, at the top of the file".to_owned();
        return Err(Fault::Key { message }.at(Place::field("at_rest")));
    }
    table.extend(given.pop().map(|value| ("at_rest".to_owned(), value)));
    Ok(())
}

/// Removes `[notes]` from the table. Deserialising it through serde would turn dates and times into strings.
pub(crate) fn take_notes(table: &mut Table) -> Result<Table, Error> {
    match table.remove("notes") {
        None => Ok(Table::new()),
        Some(Value::Table(notes)) => Ok(notes),
        Some(other) => {
            let message = format!("`notes` has type {}; make it a table", other.type_str());
            Err(Fault::Key { message }.at(Place::field("notes")))
        }
    }
}

/// Parses the text of a document.
pub(crate) fn parse(text: &str) -> Result<Table, Error> {
    text.parse().map_err(|error| syntax(text, &error))
}

/// Refuses a table whose `format` is that of the error `other`.
pub(crate) fn refuse_format(table: &Table, other: Fault) -> Result<(), Error> {
    let stated = table.get("format").and_then(Value::as_str);
    match &other {
        Fault::OtherFormat { format, .. } if stated == Some(*format) => Err(other.at(Place::field("format"))),
        _ => Ok(()),
    }
}

fn syntax(text: &str, error: &toml::de::Error) -> Error {
    let start = error.span().map_or(0, |span| span.start.min(text.len()));
    let line = 1 + text.as_bytes()[..start].iter().filter(|&&byte| byte == b'\n').count();
    Fault::Syntax { line, message: error.message().to_owned() }.at(Place::field(""))
}

/// The message of the deserialiser at the key that its last line names.
pub(crate) fn key(error: &toml::de::Error) -> Error {
    let shown = error.to_string();
    let path = shown.rsplit_once("\nin `").map_or("", |(_, rest)| rest.trim_end().trim_end_matches('`'));
    let hint = match error.message().starts_with("unknown field") {
        true => "; put custom keys under [notes]",
        false => "",
    };
    Fault::Key { message: format!("{}{hint}", error.message()) }.at(Place::field(path))
}

pub(crate) fn unwritable(error: &toml::ser::Error) -> Error {
    Fault::Key { message: error.to_string() }.at(Place::field(""))
}
