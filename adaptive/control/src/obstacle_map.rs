//! Obstacle map: clearance to obstacles and detours to the goal.

use std::f64::consts::TAU;

use trundle_model::{Body, Fixture};

use crate::ControlError;
use crate::distance_field::DistanceField;
use crate::polygon::Outline;

/// Number of corners of the polygon that circumscribes a disc.
const DISC_CORNERS: usize = 16;
/// Smallest clearance of a pose on a path, m.
const MIN_PATH_CLEARANCE_M: f64 = 0.03;
/// Margin of the map around start and goal, m.
const MAP_MARGIN_M: f64 = 1.3;
/// Largest side of the map, m, limited by memory.
const MAX_MAP_SIDE_M: f64 = 40.0;

/// Outline of an object among fixed obstacles, with the detours to a goal.
#[derive(Clone, Debug, Default)]
pub struct ObstacleMap {
    outlines: Vec<Outline>,
    obstacles: Vec<Outline>,
    distance_field: Option<DistanceField>,
}

impl ObstacleMap {
    /// A map without obstacles.
    pub fn empty() -> Self {
        Self::default()
    }

    /// A map of obstacles, which are simple polygons, world, m. `goal` and `from` are the goal pose and the current pose of the
    /// object. `turn_cost` is the cost of a turn, m/rad.
    ///
    /// # Errors
    /// If a number is not finite, an obstacle has fewer than three corners, or the map exceeds its largest side.
    pub fn new(
        body: &Body,
        obstacles: &[Vec<[f64; 2]>],
        [goal, from]: [[f64; 3]; 2],
        turn_cost: f64,
    ) -> Result<Self, ControlError> {
        for polygon in obstacles {
            if polygon.len() < 3 || polygon.iter().flatten().any(|v| !v.is_finite()) {
                let remedy = "must have at least three corners, all finite (m)";
                return Err(ControlError::value("obstacle", polygon, remedy));
            }
        }
        if obstacles.is_empty() {
            return Ok(Self::empty());
        }
        let outlines: Vec<_> = body.fixtures.iter().map(outline).collect();
        let obstacles: Vec<_> = obstacles.iter().cloned().map(Outline::new).collect();
        let mut obstacle_map = Self { outlines, obstacles, distance_field: None };
        let low = [0, 1].map(|k| goal[k].min(from[k]) - MAP_MARGIN_M);
        let high = [0, 1].map(|k| goal[k].max(from[k]) + MAP_MARGIN_M);
        if ![0, 1].iter().all(|&k| high[k] - low[k] <= MAX_MAP_SIDE_M) {
            let remedy = "too far away for a path around obstacles: must be within 35 m of the object";
            return Err(ControlError::value("goal", goal, remedy));
        }
        let free = |position, heading| {
            obstacle_map.clearance_at(position, heading, MIN_PATH_CLEARANCE_M) >= MIN_PATH_CLEARANCE_M
        };
        obstacle_map.distance_field = Some(DistanceField::new(goal, [low, high], turn_cost, free));
        Ok(obstacle_map)
    }

    /// Distance from the object at a pose to the nearest obstacle, negative where they overlap, m; a lower bound where
    /// it is more than `enough`.
    #[inline]
    pub fn clearance(&self, [x, y, theta]: [f64; 3], enough: f64) -> f64 {
        self.clearance_at([x, y], theta.sin_cos(), enough)
    }

    /// [`ObstacleMap::clearance`] for sine and cosine of the heading.
    #[inline]
    fn clearance_at(&self, position: [f64; 2], heading: (f64, f64), enough: f64) -> f64 {
        let pairs = self.obstacles.iter().flat_map(|o| self.outlines.iter().map(move |part| (o, part)));
        let distances = pairs.map(|(obstacle, part)| obstacle.distance_from(part, position, heading, enough));
        distances.fold(f64::INFINITY, f64::min)
    }

    /// Detour from a pose to the goal due to obstacles, m.
    #[inline]
    pub fn detour(&self, pose: [f64; 3]) -> f64 {
        self.distance_field.as_ref().map_or(0.0, |distance_field| distance_field.detour(pose))
    }

    /// Whether there are no obstacles.
    pub fn is_empty(&self) -> bool {
        self.obstacles.is_empty()
    }
}

fn outline(fixture: &Fixture) -> Outline {
    match fixture {
        Fixture::Polygon { vertices, .. } => Outline::new(vertices.clone()),
        Fixture::Disc { center: [x, y], radius, .. } => {
            let out = radius / (TAU / (2 * DISC_CORNERS) as f64).cos();
            let corner = |k: usize| {
                let (sin, cos) = (TAU * k as f64 / DISC_CORNERS as f64).sin_cos();
                [x + out * cos, y + out * sin]
            };
            Outline::new((0..DISC_CORNERS).map(corner).collect())
        }
    }
}
