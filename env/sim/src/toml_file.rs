//! TOML files with a format, and their model tables.

use std::path::Path;

use serde::de::DeserializeOwned;
use toml::{Table, Value};
use trundle_model::{Effect, Model};

use crate::SimError;

/// A model from the body and effect tables of `model.toml`, with the same error messages.
pub(crate) fn model(body: Table, effects: Vec<Table>) -> Result<Model, SimError> {
    let effects = effects.into_iter().map(Value::Table).collect();
    let file = Table::from_iter([
        ("format".to_owned(), Value::String("trundle-model/1".to_owned())),
        ("body".to_owned(), Value::Table(body)),
        ("effect".to_owned(), Value::Array(effects)),
    ]);
    Ok(Model::from_toml(&file.to_string())?.0)
}

/// Effects from tables. All values must be given.
pub(crate) fn effects(tables: &[Table]) -> Result<Vec<Effect>, SimError> {
    let body = Table::from_iter([("mass".to_owned(), Value::Float(1.0))]);
    let model = model(body, tables.to_vec())?;
    model.resolved()?;
    Ok(model.effects)
}

/// Read a file of the format `known`. The format is checked first, because the keys of another format would be reported
/// as unknown.
pub(crate) fn parse<T: DeserializeOwned>(path: &Path, known: &str) -> Result<T, SimError> {
    let text =
        std::fs::read_to_string(path).map_err(|source| SimError::Io { path: path.to_owned(), source })?;
    parse_text(path, &text, known)
}

/// The same for the text of a file.
pub(crate) fn parse_text<T: DeserializeOwned>(path: &Path, text: &str, known: &str) -> Result<T, SimError> {
    if let Some(Value::String(found)) = text.parse::<Table>().ok().and_then(|mut file| file.remove("format"))
    {
        expect_format(path, &found, known)?;
    }
    toml::from_str(text).map_err(|error| SimError::File { path: path.to_owned(), message: error.to_string() })
}

pub(crate) fn expect_format(path: &Path, found: &str, known: &str) -> Result<(), SimError> {
    if found == known {
        return Ok(());
    }
    let message = format!("format = \"{found}\": this reader knows \"{known}\"");
    Err(SimError::File { path: path.to_owned(), message })
}

pub(crate) fn in_file(path: &Path, error: &SimError) -> SimError {
    SimError::File { path: path.to_owned(), message: error.to_string() }
}
