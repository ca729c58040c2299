//! Object files: a body, the laws that act on it in each of its configurations, and where every value comes from.

use std::collections::BTreeMap;
use std::path::Path;

use serde::Deserialize;
use toml::Table;
use trundle_model::Model;

use crate::SimError;
use crate::scenario::{expect_format, in_file, model, parse};

const OBJECT: &str = "trundle-object/1";

/// An object: what it is made of, and how its wheels may stand.
#[derive(Clone, Debug)]
pub struct Object {
    /// What it is called.
    pub name: String,
    /// Its size for a planner, m: of the largest circle about its mass centre within the footprint, if not stated
    /// otherwise. A final error below it counts as success (section V-B).
    pub radius: Option<f64>,
    /// Names of its configurations, the first of which is the usual one.
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
    /// Where the values come from: a sentence, or one for each.
    #[serde(default)]
    source: Option<Sources>,
    /// As in `model.toml`.
    body: Table,
    #[serde(default)]
    configuration: Vec<Configuration>,
}

#[derive(Deserialize)]
#[serde(untagged)]
enum Sources {
    Whole(String),
    Each(BTreeMap<String, String>),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Configuration {
    name: String,
    /// Where its values come from.
    source: Option<String>,
    #[serde(default)]
    effect: Vec<Table>,
}

/// Key under which a sentence about the whole object is kept.
const WHOLE: &str = "object";

impl Object {
    /// Read an object file.
    ///
    /// # Errors
    /// Names the file, the key and what is wrong with it.
    pub fn read(path: &Path) -> Result<Self, SimError> {
        Self::checked(path, parse(path, OBJECT)?)
    }

    /// The object in the text of an object file, which is called `name` in messages.
    ///
    /// # Errors
    /// As [`Object::read`].
    pub fn parse(name: &str, text: &str) -> Result<Self, SimError> {
        let path = Path::new(name);
        let message = |e: toml::de::Error| SimError::File { path: path.to_owned(), message: e.to_string() };
        Self::checked(path, toml::from_str(text).map_err(message)?)
    }

    fn checked(path: &Path, file: File) -> Result<Self, SimError> {
        expect_format(path, &file.format, OBJECT)?;
        let object = Self::from_file(file).map_err(|error| in_file(path, &error))?;
        object.check().map_err(|error| in_file(path, &error))?;
        Ok(object)
    }

    fn from_file(file: File) -> Result<Self, SimError> {
        if let Some(radius) = file.radius.filter(|r| !(r.is_finite() && *r > 0.0)) {
            return Err(SimError::value("radius", radius, "must be positive (m)"));
        }
        let mut sources = match file.source {
            Some(Sources::Whole(text)) => BTreeMap::from([(WHOLE.to_owned(), text)]),
            Some(Sources::Each(each)) => each,
            None => BTreeMap::new(),
        };
        let (mut configurations, mut effects) = (vec![], BTreeMap::new());
        for Configuration { name, source, effect } in file.configuration {
            if effects.insert(name.clone(), effect).is_some() {
                return Err(SimError::value("configuration.name", name, "must differ from the others"));
            }
            sources.extend(source.map(|text| (format!("configuration.{name}"), text)));
            configurations.push(name);
        }
        let (name, radius, body) = (file.name, file.radius, file.body);
        Ok(Self { name, radius, configurations, body, effects, sources })
    }

    /// Every configuration is a model, and every source is one of a value.
    fn check(&self) -> Result<(), SimError> {
        for name in self.configurations.iter().map(Some).chain([None]) {
            self.model(name.map(String::as_str))?;
        }
        let values = self.valued();
        match self.sources.keys().find(|key| *key != WHOLE && !values.contains(key)) {
            Some(key) => Err(SimError::value("source", key, "is not a value of this file")),
            None => Ok(()),
        }
    }

    /// The model in a configuration, or without any effect.
    ///
    /// # Errors
    /// When there is no such configuration, or the body or an effect is not as in `model.toml`.
    pub fn model(&self, configuration: Option<&str>) -> Result<Model, SimError> {
        self.with(configuration, &[])
    }

    /// The same with more effects.
    pub(crate) fn with(&self, configuration: Option<&str>, more: &[Table]) -> Result<Model, SimError> {
        let own = match configuration {
            None => &[],
            Some(name) => self.effects.get(name).map(Vec::as_slice).ok_or_else(|| {
                let remedy = "is no [[configuration]] of the object's file: give the name of one";
                SimError::value("configuration", name, remedy)
            })?,
        };
        model(self.body.clone(), own.iter().chain(more).cloned().collect())
    }

    /// Where a value comes from: `radius`, `body.mass`, …, or `configuration.NAME` for all values of its effects.
    pub fn source(&self, value: &str) -> Option<&str> {
        self.sources.get(value).or_else(|| self.sources.get(WHOLE)).map(String::as_str)
    }

    /// Every value of the file, by the name under which [`Object::source`] knows it.
    pub fn valued(&self) -> Vec<String> {
        let body = self.body.keys().map(|key| format!("body.{key}"));
        let configurations = self.configurations.iter().map(|name| format!("configuration.{name}"));
        self.radius.map(|_| "radius".to_owned()).into_iter().chain(body).chain(configurations).collect()
    }
}
