//! `recording.toml` as it stands in the file.
//!
//! The format's own example writes `at_rest` below the object's tables, where TOML makes it a key of the table
//! above. So it is understood at the top, under `[object]` and in a fixture, and kept at the top.

use serde::Deserialize;

use crate::metadata::{
    Dof, FixtureMeta, Metadata, NoiseMeta, ObjectMeta, Scene, Split, WrenchMeta,
};

/// Mirrors [`Metadata`], with `at_rest` wherever it was written.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Document {
    format: String,
    name: String,
    at_rest: Option<bool>,
    object: Object,
    wrench: WrenchMeta,
    noise: Option<NoiseMeta>,
    #[serde(default)]
    scene: Scene,
    #[serde(default)]
    split: Split,
    #[serde(default)]
    notes: toml::Table,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Object {
    #[serde(default)]
    footprint: Vec<[f64; 2]>,
    mass: Option<f64>,
    #[serde(default)]
    support: Vec<[f64; 2]>,
    #[serde(default = "Dof::all")]
    dof: Vec<Dof>,
    #[serde(default, rename = "fixture")]
    fixtures: Vec<Fixture>,
    at_rest: Option<bool>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Fixture {
    polygon: Option<Vec<[f64; 2]>>,
    disc: Option<[f64; 3]>,
    #[serde(default = "crate::metadata::one")]
    density: f64,
    at_rest: Option<bool>,
}

impl TryFrom<Document> for Metadata {
    type Error = String;

    fn try_from(document: Document) -> Result<Self, String> {
        let at_rest = document.at_rest()?;
        let Document {
            format,
            name,
            object,
            wrench,
            noise,
            scene,
            split,
            notes,
            ..
        } = document;
        let fixture = |f: Fixture| FixtureMeta {
            polygon: f.polygon,
            disc: f.disc,
            density: f.density,
        };
        Ok(Self {
            format,
            name,
            at_rest,
            object: ObjectMeta {
                footprint: object.footprint,
                mass: object.mass,
                support: object.support,
                dof: object.dof,
                fixtures: object.fixtures.into_iter().map(fixture).collect(),
            },
            wrench,
            noise,
            scene,
            split,
            notes,
        })
    }
}

impl Document {
    fn at_rest(&self) -> Result<bool, String> {
        let inner = self
            .object
            .fixtures
            .iter()
            .filter_map(|fixture| fixture.at_rest);
        let mut given = self
            .at_rest
            .into_iter()
            .chain(self.object.at_rest)
            .chain(inner);
        let first = given.next().unwrap_or(true);
        if given.any(|other| other != first) {
            return Err(
                "`at_rest` is given twice, with different values; keep one, at the top".into(),
            );
        }
        Ok(first)
    }
}
