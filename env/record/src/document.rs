//! `recording.toml` as text and as a table, to and from [`Metadata`].

use toml::{Table, Value};

use crate::error::{Error, Place};
use crate::fault::Fault;
use crate::metadata::Metadata;

impl Metadata {
    /// From the text of `recording.toml`.
    ///
    /// # Errors
    /// If it is not TOML, or a key is unknown, missing or of the wrong type. What the values mean is checked
    /// by [`crate::Recording::validate`].
    pub fn from_toml(text: &str) -> Result<Self, Error> {
        let table = text.parse::<Table>().map_err(|error| syntax(text, &error))?;
        Self::from_table(table)
    }

    /// From a table such as `recording.toml` holds.
    ///
    /// # Errors
    /// As [`Metadata::from_toml`].
    pub fn from_table(mut table: Table) -> Result<Self, Error> {
        lift_at_rest(&mut table)?;
        let notes = take_notes(&mut table)?;
        let metadata: Self = table.try_into().map_err(|error| key(&error))?;
        Ok(Self { notes, ..metadata })
    }

    /// As the table that [`Metadata::from_table`] takes.
    ///
    /// # Errors
    /// If a value has no TOML form.
    pub fn to_table(&self) -> Result<Table, Error> {
        let mut table = Table::try_from(self).map_err(|error| unwritable(&error))?;
        if !self.notes.is_empty() {
            table.insert("notes".to_owned(), Value::Table(self.notes.clone()));
        }
        Ok(table)
    }

    /// As the text that [`Metadata::from_toml`] takes; every float is read back exactly.
    ///
    /// # Errors
    /// If a value has no TOML form.
    pub fn to_toml(&self) -> Result<String, Error> {
        toml::to_string(self).map_err(|error| unwritable(&error))
    }
}

/// Moves `at_rest` to the top, where it belongs. The format's own example writes it below the object's
/// tables, where TOML makes it a key of the table above it.
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
        let message = "`at_rest` is given twice, with different values; keep one, at the top".to_owned();
        return Err(Fault::Key { message }.at(Place::field("at_rest")));
    }
    table.extend(given.pop().map(|value| ("at_rest".to_owned(), value)));
    Ok(())
}

/// Takes `[notes]` out as it is: passed on through serde, its dates and times would become strings.
fn take_notes(table: &mut Table) -> Result<Table, Error> {
    match table.remove("notes") {
        None => Ok(Table::new()),
        Some(Value::Table(notes)) => Ok(notes),
        Some(other) => {
            let message = format!("`notes` is of type {}, expected a table", other.type_str());
            Err(Fault::Key { message }.at(Place::field("notes")))
        }
    }
}

fn syntax(text: &str, error: &toml::de::Error) -> Error {
    let start = error.span().map_or(0, |span| span.start.min(text.len()));
    let line = 1 + text.as_bytes()[..start].iter().filter(|&&byte| byte == b'\n').count();
    Fault::Syntax { line, message: error.message().to_owned() }.at(Place::field(""))
}

/// The deserialiser's message, at the key that it names in its last line.
fn key(error: &toml::de::Error) -> Error {
    let shown = error.to_string();
    let path = shown.rsplit_once("\nin `").map_or("", |(_, rest)| rest.trim_end().trim_end_matches('`'));
    let hint = match error.message().starts_with("unknown field") {
        true => "; keys of your own belong under [notes]",
        false => "",
    };
    Fault::Key { message: format!("{}{hint}", error.message()) }.at(Place::field(path))
}

fn unwritable(error: &toml::ser::Error) -> Error {
    Fault::Key { message: error.to_string() }.at(Place::field(""))
}
