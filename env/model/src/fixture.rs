//! Pieces of a body, and its support points.

use crate::polygon::moments;

/// One piece of a body, of uniform density.
#[derive(Clone, Debug, PartialEq)]
pub enum Fixture {
    /// A simple polygon, vertices in m, object frame.
    Polygon {
        /// Corners in order, either orientation.
        vertices: Vec<[f64; 2]>,
        /// Mass per area relative to the other fixtures.
        density: f64,
    },
    /// A disc, m, object frame.
    Disc {
        /// Its centre.
        center: [f64; 2],
        /// Its radius.
        radius: f64,
        /// Mass per area relative to the other fixtures.
        density: f64,
    },
}

impl Fixture {
    /// Density-weighted area, first moments and polar second moment about the object origin.
    pub(crate) fn moments(&self) -> (f64, [f64; 2], f64) {
        let (density, (area, first, polar)) = match self {
            Self::Polygon { vertices, density } => (*density, moments(vertices)),
            Self::Disc { center: [x, y], radius, density } => {
                let area = std::f64::consts::PI * radius * radius;
                let polar = area * (radius * radius / 2.0 + x * x + y * y);
                (*density, (area, [area * x, area * y], polar))
            }
        };
        (density * area, first.map(|m| density * m), density * polar)
    }

    /// Smallest and largest coordinates, `[[x, y], [x, y]]`, m.
    pub(crate) fn bounds(&self) -> [[f64; 2]; 2] {
        match self {
            Self::Polygon { vertices, .. } => vertices.iter().fold(EMPTY_BOUNDS, |[low, high], p| {
                [[low[0].min(p[0]), low[1].min(p[1])], [high[0].max(p[0]), high[1].max(p[1])]]
            }),
            Self::Disc { center: [x, y], radius: r, .. } => [[x - r, y - r], [x + r, y + r]],
        }
    }
}

/// Bounds of an empty set.
pub(crate) const EMPTY_BOUNDS: [[f64; 2]; 2] = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];

/// A support point of the body on the floor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Support {
    /// Position, object frame, m.
    pub point: [f64; 2],
    /// Share of the weight; all shares add up to one.
    pub share: f64,
}
