//! The `[object]` table.

use serde::{Deserialize, Serialize};
use trundle_model::Fixture;

/// The pushed object: its shape, and its mass if known.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ObjectMeta {
    /// Vertices of a simple polygon, m, object frame, in either orientation. May be empty if there are fixtures, or on a
    /// rail.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub footprint: Vec<[f64; 2]>,
    /// Weighed mass, kg.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mass: Option<f64>,
    /// Contact points of feet or wheels with the floor, m, object frame; empty if unknown.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub support: Vec<[f64; 2]>,
    /// Degrees of freedom.
    #[serde(default = "Dof::all")]
    pub dof: Vec<Dof>,
    /// Several shapes instead of one footprint. They take precedence over `footprint`.
    #[serde(default, rename = "fixture", skip_serializing_if = "Vec::is_empty")]
    pub fixtures: Vec<FixtureMeta>,
}

impl ObjectMeta {
    /// The shape as fixtures of a body: the fixtures if there are any, otherwise the footprint with density 1. Empty on a
    /// rail without a shape.
    pub fn shape(&self) -> Vec<Fixture> {
        if self.footprint.is_empty() || !self.fixtures.is_empty() {
            return self.fixtures.iter().filter_map(FixtureMeta::shape).collect();
        }
        vec![Fixture::Polygon { vertices: self.footprint.clone(), density: 1.0 }]
    }
}

/// A polygon or a disc with its relative density. Exactly one of `polygon` and `disc` is set.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FixtureMeta {
    /// Vertices, m, object frame, in either orientation.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub polygon: Option<Vec<[f64; 2]>>,
    /// Centre x, y and radius, m, object frame.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub disc: Option<[f64; 3]>,
    /// Density relative to the other fixtures.
    #[serde(default = "default_density")]
    pub density: f64,
}

impl FixtureMeta {
    fn shape(&self) -> Option<Fixture> {
        let density = self.density;
        match (&self.polygon, self.disc) {
            (Some(vertices), _) => Some(Fixture::Polygon { vertices: vertices.clone(), density }),
            (None, Some([x, y, radius])) => Some(Fixture::Disc { center: [x, y], radius, density }),
            (None, None) => None,
        }
    }
}

/// One degree of freedom of the object.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Dof {
    /// Translation along the world's x axis.
    X,
    /// Translation along the world's y axis.
    Y,
    /// Rotation about the vertical.
    Theta,
}

impl Dof {
    /// All three: free motion in the plane.
    pub fn all() -> Vec<Self> {
        vec![Self::X, Self::Y, Self::Theta]
    }
}

fn default_density() -> f64 {
    1.0
}
