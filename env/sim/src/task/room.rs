//! Where an episode takes place: start, goal, obstacles, path.

use std::f64::consts::PI;
use std::sync::Arc;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use rapier2d_f64::parry::query::intersection_test;
use rapier2d_f64::prelude::{Collider, Pose, Vector};
use serde::{Deserialize, Serialize};
use trundle_model::Body;

use super::options::Goal;
use super::rules::*;
use super::things::Thing;
use crate::SimError;
use crate::contact::reach;
use crate::gripper::{compose, wrap};
use crate::object::{hull, obstacle};

/// What [`super::Pushing::reset`] may be told; the rest is drawn.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Reset {
    /// Pose at which the object stands, m and rad.
    pub start: Option<[f64; 3]>,
    /// Pose at which it should be.
    pub goal: Option<[f64; 3]>,
    /// Where the gripper holds it, object frame, m.
    pub grasp: Option<[f64; 2]>,
    /// Keep the object, what is hidden of it, and the obstacles as they are.
    pub same_object: bool,
}

/// Points of a path, and what lies between two, m.
const POINTS: usize = 9;
const STRIDE: f64 = 0.25;
/// Standard deviation of the turn at each point of a path, rad.
const BEND: f64 = 0.3;
/// Draws of a path until one lies in the room.
const TRIES: u32 = 200;
/// Room between the object and an obstacle at the start and at the goal, m.
const GAP: f64 = 0.15;
/// Half the thickness of a wall, m.
const WALL: f64 = 0.05;

/// Where an episode takes place.
#[derive(Clone, Debug, PartialEq)]
pub struct Room {
    /// Pose of the object at the beginning.
    pub start: [f64; 3],
    /// Pose that it should reach in the end.
    pub goal: [f64; 3],
    /// Simple polygons, world, m.
    pub obstacles: Vec<Vec<[f64; 2]>>,
    /// Points and headings that it should pass, if it should follow a path.
    pub path: Vec<[f64; 3]>,
    /// What an observation says of it beside the goal.
    pub seen: Vec<f64>,
}

impl Room {
    /// Draw what is not told: obstacles from `fixed`, the rest from `random`.
    ///
    /// # Errors
    /// When start or goal are outside the arena or within an obstacle, or there is no path to a told goal.
    pub fn draw(
        task: Goal,
        thing: &Thing,
        told: &Reset,
        [fixed, random]: [&mut ChaCha8Rng; 2],
    ) -> Result<Self, SimError> {
        for (key, pose) in [("start", told.start), ("goal", told.goal)] {
            pose.map_or(Ok(()), |pose| in_arena(key, pose))?;
        }
        let room = match task {
            Goal::Pose => open(told, random),
            Goal::Path => path(told, random)?,
            Goal::Around => around(thing, told, fixed, random),
            Goal::Door => door(thing, told, fixed, random),
        };
        for (key, pose) in [("start", room.start), ("goal", room.goal)] {
            room.free(key, &thing.body, pose)?;
        }
        Ok(room)
    }

    /// Entries of [`Room::seen`] for a task.
    pub fn entries(task: Goal) -> usize {
        match task {
            Goal::Pose => 0,
            // The two points after the goal; centre, heading and half the sides; middle, normal and width.
            Goal::Path => 4,
            Goal::Around => 6,
            Goal::Door => 5,
        }
    }

    fn free(&self, key: &str, body: &Body, pose: [f64; 3]) -> Result<(), SimError> {
        let hull = hull(body)?;
        let at = Pose::new(Vector::new(pose[0], pose[1]), pose[2]);
        let hits = |part: &Collider, wall: &Collider| {
            let place = at * *part.position();
            let test = intersection_test(&place, part.shape(), wall.position(), wall.shape());
            test.is_ok_and(|test| test.intersecting)
        };
        for (index, polygon) in self.obstacles.iter().enumerate() {
            let wall = obstacle(polygon, index)?;
            if hull.iter().any(|part| wall.iter().any(|piece| hits(part, piece))) {
                return Err(SimError::value(
                    key,
                    pose,
                    "the object would stand in an obstacle: move it away",
                ));
            }
        }
        Ok(())
    }
}

fn in_arena(key: &str, [x, y, theta]: [f64; 3]) -> Result<(), SimError> {
    if theta.is_finite() && x.abs() <= PLACES && y.abs() <= PLACES {
        return Ok(());
    }
    Err(SimError::value(key, [x, y, theta], "x and y must lie in [-2, 2] m and the heading be finite"))
}

/// The goal is 0.4 to 1.0 m away in any direction that stays in the arena, turned by up to 0.8 rad.
fn open(told: &Reset, random: &mut ChaCha8Rng) -> Room {
    let start = draw_start(random);
    let start = told.start.unwrap_or(start);
    let far = random.random_range(0.4..=1.0);
    let (sin, cos) = random.random_range(-PI..=PI).sin_cos();
    let inside = |value: f64| value.clamp(-PLACES, PLACES);
    let turn = random.random_range(-0.8..=0.8);
    let goal = [inside(start[0] + far * cos), inside(start[1] + far * sin), wrap(start[2] + turn)];
    Room { start, goal: told.goal.unwrap_or(goal), obstacles: vec![], path: vec![], seen: vec![] }
}

fn draw_start(random: &mut ChaCha8Rng) -> [f64; 3] {
    [random.random_range(-0.5..=0.5), random.random_range(-0.5..=0.5), random.random_range(-PI..=PI)]
}

/// A path of 2 m that bends at random; the object turns with it.
fn path(told: &Reset, random: &mut ChaCha8Rng) -> Result<Room, SimError> {
    if let Some(goal) = told.goal {
        return Err(SimError::value("goal", goal, "a path is drawn to its end: leave `goal` out"));
    }
    let start = draw_start(random);
    let start = told.start.unwrap_or(start);
    let mut points = winding(start, random);
    for _ in 0..TRIES {
        if points.iter().all(|[x, y, _]| x.abs() <= PLACES && y.abs() <= PLACES) {
            break;
        }
        points = winding(start, random);
    }
    let inside = |[x, y, theta]: [f64; 3]| [x.clamp(-PLACES, PLACES), y.clamp(-PLACES, PLACES), theta];
    let path: Vec<_> = points.into_iter().map(inside).collect();
    let goal = path.last().copied().unwrap_or(start);
    Ok(Room { start, goal, obstacles: vec![], path, seen: vec![0.0; 4] })
}

fn winding([x, y, theta]: [f64; 3], random: &mut ChaCha8Rng) -> Vec<[f64; 3]> {
    let mut way = random.random_range(-PI..=PI);
    let mut points = vec![[x, y, theta]];
    let [mut x, mut y, mut heading] = [x, y, theta];
    for k in 1..POINTS {
        let turn = if k == 1 { 0.0 } else { BEND * random.sample::<f64, _>(StandardNormal) };
        way += turn;
        heading += turn;
        x += STRIDE * way.cos();
        y += STRIDE * way.sin();
        points.push([x, y, wrap(heading)]);
    }
    points
}

/// A box in the way, with room on both sides.
fn around(thing: &Thing, told: &Reset, fixed: &mut ChaCha8Rng, random: &mut ChaCha8Rng) -> Room {
    let turn = fixed.random_range(-PI..=PI);
    let (hx, hy) = (fixed.random_range(0.1..=0.2), fixed.random_range(0.15..=0.4));
    let middle = compose([0.0, 0.0, turn], [0.0, fixed.random_range(-0.15..=0.15), 0.0]);
    let far = hx + reach(&thing.body) + GAP;
    let corner = |x: f64, y: f64| {
        let [x, y, _] = compose(middle, [x, y, 0.0]);
        [x, y]
    };
    let polygon = vec![corner(-hx, -hy), corner(hx, -hy), corner(hx, hy), corner(-hx, hy)];
    let seen = vec![middle[0], middle[1], middle[2].cos(), middle[2].sin(), hx, hy];
    behind(turn, far, vec![polygon], seen, told, random)
}

/// A wall with an opening somewhat wider than the object.
fn door(thing: &Thing, told: &Reset, fixed: &mut ChaCha8Rng, random: &mut ChaCha8Rng) -> Room {
    let turn = fixed.random_range(-PI..=PI);
    let [low, high] = thing.body.bounds();
    let narrow = (high[0] - low[0]).min(high[1] - low[1]);
    let half = (narrow + fixed.random_range(0.2..=0.5)) / 2.0;
    let at = fixed.random_range(-0.3..=0.3);
    let frame = [0.0, 0.0, turn];
    let wall = |from: f64, to: f64| {
        [[-WALL, from], [WALL, from], [WALL, to], [-WALL, to]]
            .map(|[x, y]| compose(frame, [x, y, 0.0]))
            .map(|[x, y, _]| [x, y])
            .to_vec()
    };
    // Beyond the corners of the arena.
    let end = ROOM * std::f64::consts::SQRT_2;
    let walls = vec![wall(at + half, end), wall(-end, at - half)];
    let [x, y, _] = compose(frame, [0.0, at, 0.0]);
    let seen = vec![x, y, turn.cos(), turn.sin(), 2.0 * half];
    let far = WALL + reach(&thing.body) + GAP;
    behind(turn, far, walls, seen, told, random)
}

/// Start on one side of what is in the way, goal on the other.
fn behind(
    turn: f64,
    far: f64,
    obstacles: Vec<Vec<[f64; 2]>>,
    seen: Vec<f64>,
    told: &Reset,
    random: &mut ChaCha8Rng,
) -> Room {
    let mut place = |side: f64| {
        let (away, along) = (random.random_range(0.0..=0.2), random.random_range(-0.3..=0.3));
        let [x, y, _] = compose([0.0, 0.0, turn], [side * (far + away), along, 0.0]);
        [x.clamp(-PLACES, PLACES), y.clamp(-PLACES, PLACES), wrap(turn + random.random_range(-0.5..=0.5))]
    };
    let (start, goal) = (place(-1.0), place(1.0));
    let (start, goal) = (told.start.unwrap_or(start), told.goal.unwrap_or(goal));
    Room { start, goal, obstacles, path: vec![], seen }
}

/// How far along a path an object has come.
#[derive(Clone, Debug)]
pub struct Progress {
    path: Arc<Vec<[f64; 3]>>,
    /// Length up to each point, m.
    lengths: Arc<Vec<f64>>,
    /// Length behind it, m.
    pub done: f64,
}

/// How far ahead on the path the goal lies, m.
pub const AHEAD: f64 = 0.3;

/// It is sought so far ahead on the path, m.
const WINDOW: f64 = 0.4;

impl Progress {
    /// At the beginning.
    pub fn new(path: Vec<[f64; 3]>) -> Self {
        let mut lengths = vec![0.0];
        for pair in path.windows(2) {
            let [a, b] = [pair[0], pair[1]];
            lengths.push(lengths.last().copied().unwrap_or(0.0) + (a[0] - b[0]).hypot(a[1] - b[1]));
        }
        Self { path: Arc::new(path), lengths: Arc::new(lengths), done: 0.0 }
    }

    /// Length of the path, m.
    pub fn length(&self) -> f64 {
        self.lengths.last().copied().unwrap_or(0.0)
    }

    /// The pose at a length along it.
    pub fn at(&self, length: f64) -> [f64; 3] {
        for (from, a, b, long) in self.segments() {
            if length <= from + long && long > 0.0 {
                let share = ((length - from) / long).max(0.0);
                let turn = wrap(b[2] - a[2]);
                return [
                    a[0] + share * (b[0] - a[0]),
                    a[1] + share * (b[1] - a[1]),
                    wrap(a[2] + share * turn),
                ];
            }
        }
        self.path.last().copied().unwrap_or_default()
    }

    /// Go on to the nearest place of the path ahead; the distance from it, m.
    pub fn follow(&mut self, [x, y, _]: [f64; 3]) -> f64 {
        let [px, py, _] = self.at(self.done);
        let (mut best, mut least) = (self.done, (x - px).hypot(y - py));
        for (from, a, b, long) in self.segments() {
            let (low, high) = (self.done.max(from), (self.done + WINDOW).min(from + long));
            if low >= high {
                continue;
            }
            let way = [(b[0] - a[0]) / long, (b[1] - a[1]) / long];
            let along = (x - a[0]) * way[0] + (y - a[1]) * way[1];
            let length = (from + along).clamp(low, high);
            let [px, py] = [0, 1].map(|k| a[k] + (length - from) * way[k]);
            let distance = (x - px).hypot(y - py);
            if distance < least {
                (best, least) = (length, distance);
            }
        }
        self.done = best;
        least
    }

    /// Length before each piece, its ends, and its own length.
    fn segments(&self) -> impl Iterator<Item = (f64, [f64; 3], [f64; 3], f64)> + '_ {
        let ends = self.path.windows(2).zip(self.lengths.windows(2));
        ends.map(|(pair, lengths)| (lengths[0], pair[0], pair[1], lengths[1] - lengths[0]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn progress_is_the_nearest_place_ahead_and_never_goes_back() {
        let corner = vec![[1.0, 2.0, 0.0], [1.5, 2.0, 0.5], [1.5, 3.0, 1.0]];
        let mut progress = Progress::new(corner);
        assert!((progress.length() - 1.5).abs() < 1e-12);
        assert!(
            (progress.follow([1.3, 2.1, 0.0]) - 0.1).abs() < 1e-12 && (progress.done - 0.3).abs() < 1e-12
        );
        assert!((progress.at(progress.done)[2] - 0.3).abs() < 1e-12);
        // Around the corner, but not farther than the window.
        assert!(
            (progress.follow([1.6, 2.1, 0.0]) - 0.1).abs() < 1e-12 && (progress.done - 0.6).abs() < 1e-12
        );
        progress.follow([1.0, 2.0, 0.0]);
        assert!((progress.done - 0.6).abs() < 1e-12, "it does not go back");
        progress.follow([1.5, 3.0, 0.0]);
        assert!((progress.done - 1.0).abs() < 1e-12, "nor ahead of the window");
    }
}
