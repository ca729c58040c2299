//! Reader and writer of `model.toml` (format `trundle-model/1`).

use crate::fixture::Fixture;
use crate::model::{Effect, Model};
use crate::{Body, Discrepancy, Kind, ModelError, Param};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::sync::Arc;
use toml::{Table, Value};

const FORMAT: &str = "trundle-model/1";

/// Initial guess of a free mass without other information, kg.
const DEFAULT_MASS_KG: f64 = 20.0;

/// Normal approximation of the posterior of the free parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Posterior {
    /// Names as in [`crate::Slot::name`].
    pub names: Vec<String>,
    /// Means, in each parameter's unit.
    pub mean: Vec<f64>,
    /// Covariance, rows in the order of `names`.
    pub covariance: Vec<Vec<f64>>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    format: String,
    /// If omitted, the body of the recording applies.
    #[serde(default)]
    body: BodyTable,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    effect: Vec<Table>,
    #[serde(rename = "unnamed", default, skip_serializing_if = "Option::is_none")]
    discrepancy: Option<Discrepancy>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    posterior: Option<Posterior>,
}

#[derive(Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct BodyTable {
    #[serde(default, skip_serializing_if = "Option::is_none")]
    footprint: Option<Vec<[f64; 2]>>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    mass: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    com: Option<[f64; 2]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    inertia: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    support: Option<Vec<[f64; 2]>>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    fixture: Vec<FixtureTable>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct FixtureTable {
    #[serde(default, skip_serializing_if = "Option::is_none")]
    polygon: Option<Vec<[f64; 2]>>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    disc: Option<[f64; 3]>,
    #[serde(default = "one")]
    density: f64,
}

fn one() -> f64 {
    1.0
}

impl Model {
    /// Read `model.toml`. A parameter without a value is free.
    ///
    /// # Errors
    /// Names the key that is unknown, missing or out of bounds.
    pub fn from_toml(text: &str) -> Result<(Self, Option<Posterior>), ModelError> {
        // Check the format first: the keys of another format would be reported as unknown.
        if let Some(Value::String(found)) =
            text.parse::<Table>().ok().and_then(|mut file| file.remove("format"))
            && found != FORMAT
        {
            return Err(ModelError::Format(format!("format = \"{found}\": must be \"{FORMAT}\"")));
        }
        let file: File = toml::from_str(text).map_err(|e| ModelError::Format(e.to_string()))?;
        let mass = file.body.mass;
        let body = file.body.build()?;
        let effects =
            file.effect.iter().enumerate().map(|(k, t)| read_effect(k + 1, t)).collect::<Result<_, _>>()?;
        if let Some(posterior) = &file.posterior {
            posterior.check()?;
        }
        if let Some(discrepancy) = &file.discrepancy {
            discrepancy.check()?;
        }
        let discrepancy = file.discrepancy.map(Arc::new);
        Ok((
            Self { body, mass, dof: [true; 3], effects, priors: BTreeMap::new(), discrepancy },
            file.posterior,
        ))
    }

    /// Text of `model.toml`.
    ///
    /// # Errors
    /// When the model cannot be serialised.
    pub fn to_toml(&self, posterior: Option<&Posterior>) -> Result<String, ModelError> {
        let file = File {
            format: FORMAT.to_owned(),
            body: BodyTable::of(&self.body, self.mass),
            effect: self.effects.iter().map(write_effect).collect(),
            discrepancy: self.discrepancy.as_deref().cloned(),
            posterior: posterior.cloned(),
        };
        toml::to_string(&file).map_err(|e| ModelError::Format(e.to_string()))
    }
}

impl Posterior {
    fn check(&self) -> Result<(), ModelError> {
        let expected = self.names.len();
        let lengths = self.covariance.iter().map(Vec::len).chain([self.mean.len(), self.covariance.len()]);
        for got in lengths {
            if got != expected {
                return Err(ModelError::Length { what: "posterior", got, expected });
            }
        }
        Ok(())
    }
}

impl BodyTable {
    fn of(body: &Body, mass: Option<f64>) -> Self {
        let mut table = Self { mass, support: body.feet.clone(), ..Self::default() };
        match body.fixtures.as_slice() {
            [Fixture::Polygon { vertices, .. }] => table.footprint = Some(vertices.clone()),
            fixtures => table.fixture = fixtures.iter().map(FixtureTable::of).collect(),
        }
        let uniform = Body::from_fixtures(body.fixtures.clone(), body.mass).ok();
        if uniform.as_ref().is_some_and(|uniform| uniform.com != body.com) {
            table.com = Some(body.com);
        }
        if uniform.is_some_and(|uniform| uniform.gyration != body.gyration) {
            // An inertia without a mass would be refused.
            table.inertia = mass.map(|mass| mass * body.gyration * body.gyration);
        }
        table
    }

    fn build(self) -> Result<Body, ModelError> {
        let mass = self.mass.unwrap_or(DEFAULT_MASS_KG);
        let fixtures: Vec<Fixture> = match (self.footprint, self.fixture) {
            (Some(_), fixtures) if !fixtures.is_empty() => {
                return Err(ModelError::Format("body: give `footprint` or `fixture`, not both".to_owned()));
            }
            (Some(vertices), _) => vec![Fixture::Polygon { vertices, density: 1.0 }],
            (None, fixtures) => fixtures.into_iter().map(FixtureTable::build).collect::<Result<_, _>>()?,
        };
        let mut body =
            if fixtures.is_empty() { Body::point(mass)? } else { Body::from_fixtures(fixtures, mass)? };
        if let Some(com) = self.com {
            body.com = com;
        }
        if let Some(inertia) = self.inertia {
            if !(inertia.is_finite() && inertia > 0.0) {
                return Err(ModelError::Format(format!(
                    "body.inertia = {inertia}: must be positive (kg·m²)"
                )));
            }
            if self.mass.is_none() {
                return Err(ModelError::Format(format!(
                    "body.inertia = {inertia} without body.mass: only the radius of gyration is constant while the mass \
                     is fitted; state the mass, or describe the shape by fixtures with densities"
                )));
            }
            body.gyration = (inertia / mass).sqrt();
        }
        Ok(body.with_feet(&self.support.unwrap_or_default()))
    }
}

impl FixtureTable {
    fn of(fixture: &Fixture) -> Self {
        match fixture {
            Fixture::Polygon { vertices, density } => {
                Self { polygon: Some(vertices.clone()), disc: None, density: *density }
            }
            Fixture::Disc { center, radius, density } => {
                Self { polygon: None, disc: Some([center[0], center[1], *radius]), density: *density }
            }
        }
    }

    fn build(self) -> Result<Fixture, ModelError> {
        let density = self.density;
        match (self.polygon, self.disc) {
            (Some(vertices), None) => Ok(Fixture::Polygon { vertices, density }),
            (None, Some([x, y, radius])) => Ok(Fixture::Disc { center: [x, y], radius, density }),
            _ => Err(ModelError::Format(
                "body.fixture: give either `polygon` or `disc = [x, y, radius]`".to_owned(),
            )),
        }
    }
}

fn read_effect(index: usize, table: &Table) -> Result<Effect, ModelError> {
    let name = table.get("kind").and_then(Value::as_str).unwrap_or_default();
    let kind = Kind::from_name(name).ok_or_else(|| ModelError::UnknownKind {
        index,
        kind: name.to_owned(),
        known: join(Kind::ALL.iter().map(|k| k.spec().kind)),
    })?;
    let spec = kind.spec();
    let mut effect = Effect::free(kind);
    for (key, value) in table.iter().filter(|(key, _)| *key != "kind") {
        let Some(k) = spec.params.iter().position(|p| p.name == key) else {
            let known = join(spec.params.iter().map(|p| p.name));
            return Err(ModelError::UnknownParameter { index, kind: spec.kind, key: key.clone(), known });
        };
        let (param, full) = (&spec.params[k], format!("{}.{key}", spec.kind));
        let number = value.as_float().or_else(|| value.as_integer().map(|n| n as f64));
        let value =
            number.ok_or_else(|| ModelError::Format(format!("{full}: must be a number ({})", param.unit)))?;
        let [lower, upper] = file_bounds(param);
        if !(lower..=upper).contains(&value) {
            return Err(ModelError::OutOfBounds { name: full, value, lower, upper, unit: param.unit });
        }
        effect.values[k] = Some(value);
    }
    Ok(effect)
}

/// Largest factor by which a dimensional value in a file may exceed the bounds of the catalogue. Those bounds are for
/// furniture in SI units; a file may describe other objects or units.
const MAX_UNIT_FACTOR: f64 = (1u64 << 40) as f64;

/// Bounds of a parameter value in a file.
fn file_bounds(param: &Param) -> [f64; 2] {
    let factor = if matches!(param.unit, "1" | "rad") { 1.0 } else { MAX_UNIT_FACTOR };
    let lower = if param.lower < 0.0 { param.lower * factor } else { param.lower / factor };
    [lower, param.upper * factor]
}

fn write_effect(effect: &Effect) -> Table {
    let mut table = Table::new();
    let spec = effect.kind.spec();
    table.insert("kind".to_owned(), Value::String(spec.kind.to_owned()));
    for (param, value) in spec.params.iter().zip(&effect.values) {
        if let Some(value) = value {
            table.insert(param.name.to_owned(), Value::Float(*value));
        }
    }
    table
}

fn join<'a>(names: impl Iterator<Item = &'a str>) -> String {
    names.collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    const TABLE: &str = r#"
format = "trundle-model/1"
[body]
footprint = [[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]]
mass = 21.9
[[effect]]
kind = "viscous_wheel"
x = -0.5
y = -0.3
angle = 0.2
mu_x = 15.0
mu_y = 180
[[effect]]
kind = "coulomb_friction"
x = -0.48
y = 0.31
force = 14.2
[posterior]
names = ["body.mass"]
mean = [21.9]
covariance = [[0.04]]
"#;

    #[test]
    fn the_documented_file_round_trips() {
        let (model, posterior) = Model::from_toml(TABLE).unwrap();
        assert_eq!(model.effects[0].values[4], Some(180.0));
        assert!(model.resolved().is_ok());
        let text = model.to_toml(posterior.as_ref()).unwrap();
        assert_eq!(Model::from_toml(&text).unwrap(), (model, posterior));
    }

    #[test]
    fn mass_centre_and_inertia_round_trip() {
        let text = format!(
            "format = \"{FORMAT}\"\n[body]\nmass = 8.0\ncom = [0.25, -0.5]\ninertia = 3.5\n\
             footprint = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]\n"
        );
        let (model, _) = Model::from_toml(&text).unwrap();
        let (reread, _) = Model::from_toml(&model.to_toml(None).unwrap()).unwrap();
        assert_eq!(reread.body.com, [0.25, -0.5]);
        assert!((reread.body.inertia() - 3.5).abs() < 1e-14);
        let error = Model::from_toml(&text.replace("mass = 8.0", "")).unwrap_err().to_string();
        assert!(error.contains("body.inertia = 3.5 without body.mass"), "{error}");
        let free = Model { mass: None, ..model };
        assert!(Model::from_toml(&free.to_toml(None).unwrap()).is_ok());
    }

    #[test]
    fn an_omitted_value_is_free() {
        for body in ["", "[body]\n"] {
            let text = format!("format = \"trundle-model/1\"\n{body}[[effect]]\nkind = \"viscous_wheel\"\n");
            let (model, _) = Model::from_toml(&text).unwrap();
            assert_eq!(model.mass, None);
            assert_eq!(model.effects[0].values, [None; 5]);
        }
    }

    #[test]
    fn errors_name_key_and_value() {
        for (from, to, words) in [
            ("trundle-model/1", "trundle-model/9", vec!["trundle-model/9", "trundle-model/1"]),
            (
                "trundle-model/1\"",
                "trundle-object/1\"\nname = \"bed\"",
                vec!["format = \"trundle-object/1\"", "must be \"trundle-model/1\""],
            ),
            ("force = 14.2", "force = -1.0", vec!["coulomb_friction.force", "-1", "N"]),
            ("force = 14.2", "farce = 14.2", vec!["effect 2", "farce", "static_force"]),
            ("\"coulomb_friction\"", "\"magic\"", vec!["effect 2", "magic", "viscous_wheel"]),
            ("mass = 21.9", "mass = -3.0", vec!["body.mass", "-3", "kg"]),
            ("mass = 21.9", "mess = 21.9", vec!["mess"]),
            ("mean = [21.9]", "mean = [21.9, 1.0]", vec!["posterior", "2", "1"]),
        ] {
            let message = Model::from_toml(&TABLE.replace(from, to)).unwrap_err().to_string();
            for word in words {
                assert!(message.contains(word), "{message} should contain {word}");
            }
        }
    }
}
