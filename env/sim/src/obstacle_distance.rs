//! Distances between an object and obstacles.

use trundle_model::{Body, Fixture};

/// Distance to an obstacle below which the engine takes over, m.
pub(crate) const ENGINE_MARGIN_M: f64 = 0.02;

/// Whether an object may touch an obstacle at one of the poses, by its bounding circle and a margin.
pub fn can_touch(
    body: &Body,
    obstacles: &[Vec<[f64; 2]>],
    mut poses: impl Iterator<Item = [f64; 3]>,
) -> bool {
    let radius = outline_radius(body);
    !obstacles.is_empty() && poses.any(|pose| obstacle_distance(obstacles, pose) < radius + ENGINE_MARGIN_M)
}

/// Distance from the object origin to the nearest obstacle, m; zero inside an obstacle.
pub(crate) fn obstacle_distance(obstacles: &[Vec<[f64; 2]>], [x, y, _]: [f64; 3]) -> f64 {
    obstacles.iter().map(|polygon| polygon_distance(polygon, [x, y])).fold(f64::INFINITY, f64::min)
}

/// Largest distance of the outline from the object origin, m.
pub(crate) fn outline_radius(body: &Body) -> f64 {
    let of = |fixture: &Fixture| match fixture {
        Fixture::Polygon { vertices, .. } => vertices.iter().map(|[x, y]| x.hypot(*y)).fold(0.0, f64::max),
        Fixture::Disc { center: [x, y], radius, .. } => x.hypot(*y) + radius,
    };
    body.fixtures.iter().map(of).fold(0.0, f64::max)
}

fn polygon_distance(polygon: &[[f64; 2]], point: [f64; 2]) -> f64 {
    let edges = || polygon.iter().zip(polygon.iter().cycle().skip(1));
    let crosses = |(a, b): (&[f64; 2], &[f64; 2])| {
        (a[1] > point[1]) != (b[1] > point[1])
            && point[0] < a[0] + (point[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
    };
    if edges().filter(|&edge| crosses(edge)).count() % 2 == 1 {
        return 0.0;
    }
    edges().map(|(a, b)| edge_distance(*a, *b, point)).fold(f64::INFINITY, f64::min)
}

fn edge_distance(a: [f64; 2], b: [f64; 2], point: [f64; 2]) -> f64 {
    let (along, from) = ([b[0] - a[0], b[1] - a[1]], [point[0] - a[0], point[1] - a[1]]);
    let square = along[0] * along[0] + along[1] * along[1];
    let share = if square > 0.0 { (along[0] * from[0] + along[1] * from[1]) / square } else { 0.0 };
    let share = share.clamp(0.0, 1.0);
    (from[0] - share * along[0]).hypot(from[1] - share * along[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_are_to_the_outline_and_zero_inside() {
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        assert_eq!(polygon_distance(&square, [0.5, 0.5]), 0.0);
        assert!((polygon_distance(&square, [1.5, 0.5]) - 0.5).abs() < 1e-12);
        assert!((polygon_distance(&square, [2.0, 2.0]) - 2f64.sqrt()).abs() < 1e-12);
    }
}
