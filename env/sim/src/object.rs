//! Object files: a body, the effects of each configuration, and the source of every value.

use std::collections::BTreeMap;
use std::path::Path;

use serde::Deserialize;
use toml::Table;
use trundle_model::Model;

use crate::SimError;
use crate::toml_file::{expect_format, in_file, model, parse};

const OBJECT_FORMAT: &str = "trundle-object/1";

/// An object with its configurations.
#[derive(Clone, Debug)]
pub struct Object {
    /// Name of the object.
    pub name: String,
    /// Size of the object for a planner, m. By convention it is the radius of the largest circle about the mass centre within
    /// the footprint. A final error below it counts as success (section V-B of the paper).
    pub radius: Option<f64>,
    /// Names of the configurations. The first is the default.
    pub configurations: Vec<String>,
    body: Table,
    effects: BTreeMap<String, Vec<Table>>,
    sources: BTreeMap<String, String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    format: String,
    name: String,
    #[serde(default)]
    radius: Option<f64>,
    /// Source of the values: one text, or one for each value.
    #[serde(default)]
    source: Option<Sources>,
    /// Body table, as in `model.toml`.
    body: Table,
    #[serde(default)]
    configuration: Vec<Configuration>,
}

#[derive(Deserialize)]
#[serde(untagged)]
enum Sources {
    Shared(String),
    Each(BTreeMap<String, String>),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Configuration {
    name: String,
    /// Source of the values.
    source: Option<String>,
    #[serde(default)]
    effect: Vec<Table>,
}

/// Key of a source text that applies to the whole object.
const WHOLE_OBJECT: &str = "object";

impl Object {
    /// Read an object file.
    ///
    /// # Errors
    /// If the file cannot be read or a value is invalid. The message names file and key.
    pub fn read(path: &Path) -> Result<Self, SimError> {
        Self::from_checked_file(path, parse(path, OBJECT_FORMAT)?)
    }

    /// Parse the text of an object file. Error messages refer to it as `name`.
    ///
    /// # Errors
    /// As [`Object::read`].
    pub fn parse(name: &str, text: &str) -> Result<Self, SimError> {
        let path = Path::new(name);
        let message = |e: toml::de::Error| SimError::File { path: path.to_owned(), message: e.to_string() };
        Self::from_checked_file(path, toml::from_str(text).map_err(message)?)
    }

    fn from_checked_file(path: &Path, file: File) -> Result<Self, SimError> {
        expect_format(path, &file.format, OBJECT_FORMAT)?;
        let object = Self::from_file(file).map_err(|error| in_file(path, &error))?;
        object.check().map_err(|error| in_file(path, &error))?;
        Ok(object)
    }

    fn from_file(file: File) -> Result<Self, SimError> {
        if let Some(radius) = file.radius.filter(|r| !(r.is_finite() && *r > 0.0)) {
            return Err(SimError::value("radius", radius, "must be positive (m)"));
        }
        let mut sources = match file.source {
            Some(Sources::Shared(text)) => BTreeMap::from([(WHOLE_OBJECT.to_owned(), text)]),
            Some(Sources::Each(each)) => each,
            None => BTreeMap::new(),
        };
        let (mut configurations, mut effects) = (vec![], BTreeMap::new());
        for Configuration { name, source, effect } in file.configuration {
            if effects.insert(name.clone(), effect).is_some() {
                return Err(SimError::value("configuration.name", name, "must differ from all other names"));
            }
            sources.extend(source.map(|text| (format!("configuration.{name}"), text)));
            configurations.push(name);
        }
        let (name, radius, body) = (file.name, file.radius, file.body);
        Ok(Self { name, radius, configurations, body, effects, sources })
    }

    /// Check that every configuration is a valid model and that every source refers to a value.
    fn check(&self) -> Result<(), SimError> {
        for name in self.configurations.iter().map(Some).chain([None]) {
            self.model(name.map(String::as_str))?;
        }
        let values = self.value_names();
        match self.sources.keys().find(|key| *key != WHOLE_OBJECT && !values.contains(key)) {
            Some(key) => Err(SimError::value("source", key, "is not a value of this file")),
            None => Ok(()),
        }
    }

    /// The model in a configuration, or without effects.
    ///
    /// # Errors
    /// If there is no such configuration, or the body or an effect is invalid.
    pub fn model(&self, configuration: Option<&str>) -> Result<Model, SimError> {
        self.model_with(configuration, &[])
    }

    /// [`Object::model`] with additional effects.
    pub(crate) fn model_with(&self, configuration: Option<&str>, extra: &[Table]) -> Result<Model, SimError> {
        let own = match configuration {
            None => &[],
            Some(name) => self.effects.get(name).map(Vec::as_slice).ok_or_else(|| {
                let remedy = "not a [[configuration]] of the object file: give the name of one";
                SimError::value("configuration", name, remedy)
            })?,
        };
        model(self.body.clone(), own.iter().chain(extra).cloned().collect())
    }

    /// Source of a value: `radius`, `body.mass`, …, or `configuration.NAME` for all values of its effects.
    pub fn source(&self, value: &str) -> Option<&str> {
        self.sources.get(value).or_else(|| self.sources.get(WHOLE_OBJECT)).map(String::as_str)
    }

    /// Names of all values of the file, as accepted by [`Object::source`].
    pub fn value_names(&self) -> Vec<String> {
        let body = self.body.keys().map(|key| format!("body.{key}"));
        let configurations = self.configurations.iter().map(|name| format!("configuration.{name}"));
        self.radius.map(|_| "radius".to_owned()).into_iter().chain(body).chain(configurations).collect()
    }
}
