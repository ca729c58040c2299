//! Pressure of a flat face on the floor: a grid of cells, each with its weight at its centroid.

use crate::fixture::{Fixture, Support};
use crate::polygon::moments;

/// Number of cells along the longer side.
const CELLS_ALONG_LONGER_SIDE: usize = 6;

/// Number of corners of the polygon that approximates a disc.
const DISC_CORNERS: usize = 32;

/// Supports of fixtures of uniform density on the floor, one per cell. The shares add up to one, and the centre of
/// pressure is the mass centre.
///
/// `bounds`: smallest and largest coordinates, m. The result is empty for fixtures without area.
pub(crate) fn uniform_pressure(fixtures: &[Fixture], [low, high]: [[f64; 2]; 2]) -> Vec<Support> {
    let step = (high[0] - low[0]).max(high[1] - low[1]) / CELLS_ALONG_LONGER_SIDE as f64;
    let count = [0, 1].map(|k| ((high[k] - low[k]) / step - 1e-9).ceil() as usize);
    let outlines: Vec<_> = fixtures.iter().map(outline).collect();
    let mut found = vec![];
    for i in 0..count[0] {
        for j in 0..count[1] {
            let corner = [low[0] + i as f64 * step, low[1] + j as f64 * step];
            found.extend(cell(&outlines, corner, step));
        }
    }
    let total: f64 = found.iter().map(|s| s.share).sum();
    found.iter_mut().for_each(|s| s.share /= total);
    found
}

/// Outline and density of a fixture. The outline of a disc is a polygon of equal area.
fn outline(fixture: &Fixture) -> (Vec<[f64; 2]>, f64) {
    match fixture {
        Fixture::Polygon { vertices, density } => (vertices.clone(), *density),
        Fixture::Disc { center: [x, y], radius, density } => {
            let turn = std::f64::consts::TAU / DISC_CORNERS as f64;
            let reach = radius * (turn / turn.sin()).sqrt();
            let corner = |k: usize| {
                let (sin, cos) = (turn * k as f64).sin_cos();
                [x + reach * cos, y + reach * sin]
            };
            ((0..DISC_CORNERS).map(corner).collect(), *density)
        }
    }
}

/// Support of the weight within a square cell, at its centroid.
fn cell(outlines: &[(Vec<[f64; 2]>, f64)], corner: [f64; 2], step: f64) -> Option<Support> {
    let (mut weight, mut first) = (0.0, [0.0; 2]);
    for (vertices, density) in outlines {
        let (area, [x, y], _) = moments(&clip_to_cell(vertices, corner, step));
        weight += density * area;
        first = [first[0] + density * x, first[1] + density * y];
    }
    // Skip slivers.
    (weight > 1e-6 * step * step).then(|| Support { point: first.map(|m| m / weight), share: weight })
}

/// Intersection of a polygon and a square cell (Sutherland and Hodgman 1974).
fn clip_to_cell(vertices: &[[f64; 2]], corner: [f64; 2], step: f64) -> Vec<[f64; 2]> {
    let mut part = vertices.to_vec();
    for (axis, low) in corner.into_iter().enumerate() {
        part = clip_half_plane(&part, |p| p[axis] - low);
        part = clip_half_plane(&part, |p| low + step - p[axis]);
    }
    part
}

/// Part of a polygon in the half plane where an affine function is not negative.
fn clip_half_plane(vertices: &[[f64; 2]], inside: impl Fn([f64; 2]) -> f64) -> Vec<[f64; 2]> {
    let mut part = Vec::with_capacity(vertices.len() + 2);
    for (&a, &b) in vertices.iter().zip(vertices.iter().cycle().skip(1)) {
        let (from, to) = (inside(a), inside(b));
        if from >= 0.0 {
            part.push(a);
        }
        if (from >= 0.0) != (to >= 0.0) {
            let share = from / (from - to);
            part.push([a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])]);
        }
    }
    part
}

#[cfg(test)]
mod tests {
    use crate::Body;
    use crate::fixture::Fixture;

    fn centre(body: &Body) -> [f64; 2] {
        [0, 1].map(|k| body.support.iter().map(|s| s.share * s.point[k]).sum())
    }

    #[test]
    fn the_centre_of_pressure_is_the_mass_centre() {
        let triangle = vec![[-0.04, -0.008], [0.042, -0.065], [0.017, 0.074]];
        let l = vec![[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
        let disc = Fixture::Disc { center: [1.5, -0.3], radius: 0.7, density: 3.0 };
        for fixtures in [
            vec![Fixture::Polygon { vertices: triangle, density: 1.0 }],
            vec![Fixture::Polygon { vertices: l, density: 2.0 }, disc],
        ] {
            let body = Body::from_fixtures(fixtures, 2.0).unwrap();
            let seen = centre(&body);
            assert!((0..2).all(|k| (seen[k] - body.com[k]).abs() < 1e-4), "{seen:?} {:?}", body.com);
            assert!((body.support.iter().map(|s| s.share).sum::<f64>() - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn the_pressure_has_the_radius_of_gyration_of_the_face() {
        let body = Body::from_footprint(&[[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]], 22.0).unwrap();
        assert_eq!(body.support.len(), 24);
        let square: f64 =
            body.support.iter().map(|s| s.share * (s.point[0].powi(2) + s.point[1].powi(2))).sum();
        assert!((square.sqrt() / body.gyration - 1.0).abs() < 0.03);
    }
}
