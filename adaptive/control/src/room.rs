//! What is in the way of an object on its way to the goal.

use std::f64::consts::TAU;

use trundle_model::{Body, Fixture};

use crate::ControlError;
use crate::field::Field;
use crate::polygon::Outline;

/// A disc is an outline of so many corners, about it.
const ROUND: usize = 16;
/// Room that a pose on the way must have, m.
const CLEAR: f64 = 0.03;
/// Ways may lead so far beyond start and goal, m.
const BEYOND: f64 = 1.3;
/// Sides beyond which no ways are looked for, m: the grid would not fit into memory.
const WIDEST: f64 = 40.0;

/// An object's outline among fixed obstacles, and the ways to a goal.
#[derive(Clone, Debug, Default)]
pub struct Room {
    outline: Vec<Outline>,
    obstacles: Vec<Outline>,
    field: Option<Field>,
}

impl Room {
    /// A room without obstacles.
    pub fn open() -> Self {
        Self::default()
    }

    /// A room with simple polygons, world, m; `goal` and `from` are where the object should be and where it is, and
    /// `turning` is what a radian on the way costs, m.
    ///
    /// # Errors
    /// When a number is not finite, an obstacle has fewer than three corners, or the goal is tens of metres away.
    pub fn new(
        body: &Body,
        obstacles: &[Vec<[f64; 2]>],
        [goal, from]: [[f64; 3]; 2],
        turning: f64,
    ) -> Result<Self, ControlError> {
        for polygon in obstacles {
            if polygon.len() < 3 || polygon.iter().flatten().any(|v| !v.is_finite()) {
                let remedy = "needs three corners at least, all finite (m)";
                return Err(ControlError::value("obstacle", polygon, remedy));
            }
        }
        if obstacles.is_empty() {
            return Ok(Self::open());
        }
        let outline: Vec<_> = body.fixtures.iter().map(outline).collect();
        let obstacles: Vec<_> = obstacles.iter().cloned().map(Outline::new).collect();
        let mut room = Self { outline, obstacles, field: None };
        let low = [0, 1].map(|k| goal[k].min(from[k]) - BEYOND);
        let high = [0, 1].map(|k| goal[k].max(from[k]) + BEYOND);
        if ![0, 1].iter().all(|&k| high[k] - low[k] <= WIDEST) {
            let remedy = "is too far away to find a way around obstacles: give one within 35 m of the object";
            return Err(ControlError::value("goal", goal, remedy));
        }
        let free = |pose| room.clearance(pose, CLEAR) >= CLEAR;
        room.field = Some(Field::new(goal, [low, high], turning, free));
        Ok(room)
    }

    /// Distance from the object at a pose to the nearest obstacle, negative where they overlap, m; a lower bound where
    /// it is more than `enough`.
    #[inline]
    pub fn clearance(&self, pose: [f64; 3], enough: f64) -> f64 {
        let pairs = self.obstacles.iter().flat_map(|o| self.outline.iter().map(move |part| (o, part)));
        pairs.map(|(obstacle, part)| obstacle.from(part, pose, enough)).fold(f64::INFINITY, f64::min)
    }

    /// How much longer the way from a pose to the goal is than it looks, m.
    #[inline]
    pub(crate) fn detour(&self, pose: [f64; 3]) -> f64 {
        self.field.as_ref().map_or(0.0, |field| field.excess(pose))
    }

    /// Whether there is anything in the way.
    pub fn is_open(&self) -> bool {
        self.obstacles.is_empty()
    }
}

fn outline(fixture: &Fixture) -> Outline {
    match fixture {
        Fixture::Polygon { vertices, .. } => Outline::new(vertices.clone()),
        Fixture::Disc { center: [x, y], radius, .. } => {
            let out = radius / (TAU / (2 * ROUND) as f64).cos();
            let corner = |k: usize| {
                let (sin, cos) = (TAU * k as f64 / ROUND as f64).sin_cos();
                [x + out * cos, y + out * sin]
            };
            Outline::new((0..ROUND).map(corner).collect())
        }
    }
}
