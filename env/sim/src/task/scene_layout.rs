//! Scene layout of an episode: start, goal, obstacles and path.

use std::f64::consts::PI;
use std::sync::Arc;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use rapier2d_f64::parry::query::intersection_test;
use rapier2d_f64::prelude::{Collider, Pose, Vector};
use serde::{Deserialize, Serialize};
use trundle_model::Body;

use super::constants::*;
use super::options::TaskKind;
use super::task_objects::TaskObject;
use crate::SimError;
use crate::colliders::{object_colliders, obstacle_colliders};
use crate::gripper::{compose, wrap_angle};
use crate::obstacle_distance::outline_radius;

/// Options of [`super::PushTask::reset`]. Missing options are drawn at random.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ResetOptions {
    /// Initial pose of the object, m and rad.
    pub start: Option<[f64; 3]>,
    /// Goal pose of the object, m and rad.
    pub goal: Option<[f64; 3]>,
    /// Position of the grasp, object frame, m.
    pub grasp: Option<[f64; 2]>,
    /// Keep the object, its hidden effects and the obstacles.
    pub same_object: bool,
}

/// Number of points of a path.
const PATH_POINTS: usize = 9;
/// Distance between two points of a path, m.
const PATH_SPACING_M: f64 = 0.25;
/// Standard deviation of the turn at each point of a path, rad.
const PATH_TURN_SD_RAD: f64 = 0.3;
/// Largest number of draws until a path lies in the workspace.
const MAX_PATH_DRAWS: u32 = 200;
/// Smallest distance between the object's circle and an obstacle at start and goal, m.
const MIN_OBSTACLE_GAP_M: f64 = 0.15;
/// Half the thickness of a wall, m.
const WALL_HALF_THICKNESS_M: f64 = 0.05;

/// Scene of an episode.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneLayout {
    /// Initial pose of the object.
    pub start: [f64; 3],
    /// Goal pose of the object.
    pub goal: [f64; 3],
    /// Obstacles: simple polygons, world, m.
    pub obstacles: Vec<Vec<[f64; 2]>>,
    /// Poses along the path; empty without a path.
    pub path: Vec<[f64; 3]>,
    /// Additional observation entries that describe the scene.
    pub features: Vec<f64>,
}

impl SceneLayout {
    /// Draw a layout. Obstacles come from the generator `fixed`, everything else from `rng`.
    ///
    /// # Errors
    /// If start or goal are outside the workspace or in an obstacle, or a goal is given for a path task.
    pub fn draw(
        task: TaskKind,
        task_object: &TaskObject,
        reset: &ResetOptions,
        [fixed, rng]: [&mut ChaCha8Rng; 2],
    ) -> Result<Self, SimError> {
        for (key, pose) in [("start", reset.start), ("goal", reset.goal)] {
            pose.map_or(Ok(()), |pose| in_arena(key, pose))?;
        }
        let layout = match task {
            TaskKind::Pose => pose_layout(reset, rng),
            TaskKind::Path => path_layout(reset, rng)?,
            TaskKind::Around => obstacle_layout(task_object, reset, fixed, rng),
            TaskKind::Door => door_layout(task_object, reset, fixed, rng),
        };
        for (key, pose) in [("start", layout.start), ("goal", layout.goal)] {
            layout.check_clear(key, &task_object.body, pose)?;
        }
        Ok(layout)
    }

    fn check_clear(&self, key: &str, body: &Body, pose: [f64; 3]) -> Result<(), SimError> {
        let parts = object_colliders(body)?;
        let object = Pose::new(Vector::new(pose[0], pose[1]), pose[2]);
        let hits = |part: &Collider, wall: &Collider| {
            let place = object * *part.position();
            let test = intersection_test(&place, part.shape(), wall.position(), wall.shape());
            test.is_ok_and(|test| test.intersecting)
        };
        for (index, polygon) in self.obstacles.iter().enumerate() {
            let wall = obstacle_colliders(polygon, index)?;
            if parts.iter().any(|part| wall.iter().any(|piece| hits(part, piece))) {
                return Err(SimError::value(key, pose, "the object overlaps an obstacle: move it away"));
            }
        }
        Ok(())
    }
}

fn in_arena(key: &str, [x, y, theta]: [f64; 3]) -> Result<(), SimError> {
    if theta.is_finite() && x.abs() <= MAX_PLACEMENT_M && y.abs() <= MAX_PLACEMENT_M {
        return Ok(());
    }
    Err(SimError::value(key, [x, y, theta], "x and y must lie in [-2, 2] m and the heading be finite"))
}

/// A goal 0.4 to 1.0 m away in any direction, clipped to the workspace, and turned by up to 0.8 rad.
fn pose_layout(reset: &ResetOptions, rng: &mut ChaCha8Rng) -> SceneLayout {
    let start = draw_start(rng);
    let start = reset.start.unwrap_or(start);
    let distance = rng.random_range(0.4..=1.0);
    let (sin, cos) = rng.random_range(-PI..=PI).sin_cos();
    let inside = |value: f64| value.clamp(-MAX_PLACEMENT_M, MAX_PLACEMENT_M);
    let turn = rng.random_range(-0.8..=0.8);
    let goal =
        [inside(start[0] + distance * cos), inside(start[1] + distance * sin), wrap_angle(start[2] + turn)];
    SceneLayout { start, goal: reset.goal.unwrap_or(goal), obstacles: vec![], path: vec![], features: vec![] }
}

fn draw_start(rng: &mut ChaCha8Rng) -> [f64; 3] {
    [rng.random_range(-0.5..=0.5), rng.random_range(-0.5..=0.5), rng.random_range(-PI..=PI)]
}

/// A random path of 2 m. The heading of the object follows its turns.
fn path_layout(reset: &ResetOptions, rng: &mut ChaCha8Rng) -> Result<SceneLayout, SimError> {
    if let Some(goal) = reset.goal {
        return Err(SimError::value("goal", goal, "not supported by path tasks: remove `goal`"));
    }
    let start = draw_start(rng);
    let start = reset.start.unwrap_or(start);
    let mut points = draw_path(start, rng);
    for _ in 0..MAX_PATH_DRAWS {
        if points.iter().all(|[x, y, _]| x.abs() <= MAX_PLACEMENT_M && y.abs() <= MAX_PLACEMENT_M) {
            break;
        }
        points = draw_path(start, rng);
    }
    let inside = |[x, y, theta]: [f64; 3]| {
        [x.clamp(-MAX_PLACEMENT_M, MAX_PLACEMENT_M), y.clamp(-MAX_PLACEMENT_M, MAX_PLACEMENT_M), theta]
    };
    let path: Vec<_> = points.into_iter().map(inside).collect();
    let goal = path.last().copied().unwrap_or(start);
    Ok(SceneLayout { start, goal, obstacles: vec![], path, features: vec![0.0; 4] })
}

fn draw_path([x, y, theta]: [f64; 3], rng: &mut ChaCha8Rng) -> Vec<[f64; 3]> {
    let mut direction = rng.random_range(-PI..=PI);
    let mut points = vec![[x, y, theta]];
    let [mut x, mut y, mut heading] = [x, y, theta];
    for k in 1..PATH_POINTS {
        let turn = if k == 1 { 0.0 } else { PATH_TURN_SD_RAD * rng.sample::<f64, _>(StandardNormal) };
        direction += turn;
        heading += turn;
        x += PATH_SPACING_M * direction.cos();
        y += PATH_SPACING_M * direction.sin();
        points.push([x, y, wrap_angle(heading)]);
    }
    points
}

/// A box between start and goal.
fn obstacle_layout(
    task_object: &TaskObject,
    reset: &ResetOptions,
    fixed: &mut ChaCha8Rng,
    rng: &mut ChaCha8Rng,
) -> SceneLayout {
    let turn = fixed.random_range(-PI..=PI);
    let (hx, hy) = (fixed.random_range(0.1..=0.2), fixed.random_range(0.15..=0.4));
    let center = compose([0.0, 0.0, turn], [0.0, fixed.random_range(-0.15..=0.15), 0.0]);
    let min_distance = hx + outline_radius(&task_object.body) + MIN_OBSTACLE_GAP_M;
    let corner = |x: f64, y: f64| {
        let [x, y, _] = compose(center, [x, y, 0.0]);
        [x, y]
    };
    let polygon = vec![corner(-hx, -hy), corner(hx, -hy), corner(hx, hy), corner(-hx, hy)];
    let features = vec![center[0], center[1], center[2].cos(), center[2].sin(), hx, hy];
    layout_across(turn, min_distance, vec![polygon], features, reset, rng)
}

/// A wall with a doorway 0.2 to 0.5 m wider than the object.
fn door_layout(
    task_object: &TaskObject,
    reset: &ResetOptions,
    fixed: &mut ChaCha8Rng,
    rng: &mut ChaCha8Rng,
) -> SceneLayout {
    let turn = fixed.random_range(-PI..=PI);
    let [low, high] = task_object.body.bounds();
    let shorter_side = (high[0] - low[0]).min(high[1] - low[1]);
    let half_width = (shorter_side + fixed.random_range(0.2..=0.5)) / 2.0;
    let offset = fixed.random_range(-0.3..=0.3);
    let frame = [0.0, 0.0, turn];
    let wall = |from: f64, to: f64| {
        [
            [-WALL_HALF_THICKNESS_M, from],
            [WALL_HALF_THICKNESS_M, from],
            [WALL_HALF_THICKNESS_M, to],
            [-WALL_HALF_THICKNESS_M, to],
        ]
        .map(|[x, y]| compose(frame, [x, y, 0.0]))
        .map(|[x, y, _]| [x, y])
        .to_vec()
    };
    // Walls extend beyond the corners of the workspace.
    let end = MAX_FEATURE_M * std::f64::consts::SQRT_2;
    let walls = vec![wall(offset + half_width, end), wall(-end, offset - half_width)];
    let [x, y, _] = compose(frame, [0.0, offset, 0.0]);
    let features = vec![x, y, turn.cos(), turn.sin(), 2.0 * half_width];
    let min_distance = WALL_HALF_THICKNESS_M + outline_radius(&task_object.body) + MIN_OBSTACLE_GAP_M;
    layout_across(turn, min_distance, walls, features, reset, rng)
}

/// Start and goal on opposite sides of the obstacles.
fn layout_across(
    turn: f64,
    min_distance: f64,
    obstacles: Vec<Vec<[f64; 2]>>,
    features: Vec<f64>,
    reset: &ResetOptions,
    rng: &mut ChaCha8Rng,
) -> SceneLayout {
    let mut place = |side: f64| {
        let (away, along) = (rng.random_range(0.0..=0.2), rng.random_range(-0.3..=0.3));
        let [x, y, _] = compose([0.0, 0.0, turn], [side * (min_distance + away), along, 0.0]);
        [
            x.clamp(-MAX_PLACEMENT_M, MAX_PLACEMENT_M),
            y.clamp(-MAX_PLACEMENT_M, MAX_PLACEMENT_M),
            wrap_angle(turn + rng.random_range(-0.5..=0.5)),
        ]
    };
    let (start, goal) = (place(-1.0), place(1.0));
    let (start, goal) = (reset.start.unwrap_or(start), reset.goal.unwrap_or(goal));
    SceneLayout { start, goal, obstacles, path: vec![], features }
}

/// Progress along a path.
#[derive(Clone, Debug)]
pub struct PathProgress {
    path: Arc<Vec<[f64; 3]>>,
    /// Arc length at each point, m.
    lengths: Arc<Vec<f64>>,
    /// Arc length reached so far, m.
    pub arc_length: f64,
}

/// Distance of the target ahead on the path, m.
pub const PATH_LOOKAHEAD_M: f64 = 0.3;

/// Distance ahead on the path in which the nearest point is searched, m.
const PATH_SEARCH_WINDOW_M: f64 = 0.4;

impl PathProgress {
    /// Progress at the start of a path.
    pub fn new(path: Vec<[f64; 3]>) -> Self {
        let mut lengths = vec![0.0];
        for pair in path.windows(2) {
            let [a, b] = [pair[0], pair[1]];
            lengths.push(lengths.last().copied().unwrap_or(0.0) + (a[0] - b[0]).hypot(a[1] - b[1]));
        }
        Self { path: Arc::new(path), lengths: Arc::new(lengths), arc_length: 0.0 }
    }

    /// Length of the path, m.
    pub fn length(&self) -> f64 {
        self.lengths.last().copied().unwrap_or(0.0)
    }

    /// Pose at an arc length, m.
    pub fn pose_at(&self, length: f64) -> [f64; 3] {
        for (from, a, b, segment_length) in self.segments() {
            if length <= from + segment_length && segment_length > 0.0 {
                let share = ((length - from) / segment_length).max(0.0);
                let turn = wrap_angle(b[2] - a[2]);
                return [
                    a[0] + share * (b[0] - a[0]),
                    a[1] + share * (b[1] - a[1]),
                    wrap_angle(a[2] + share * turn),
                ];
            }
        }
        self.path.last().copied().unwrap_or_default()
    }

    /// Advance to the nearest point of the path ahead. Returns the distance to it, m.
    pub fn advance_to(&mut self, [x, y, _]: [f64; 3]) -> f64 {
        let [px, py, _] = self.pose_at(self.arc_length);
        let (mut nearest, mut min_distance) = (self.arc_length, (x - px).hypot(y - py));
        for (from, a, b, segment_length) in self.segments() {
            let (low, high) = (
                self.arc_length.max(from),
                (self.arc_length + PATH_SEARCH_WINDOW_M).min(from + segment_length),
            );
            if low >= high {
                continue;
            }
            let direction = [(b[0] - a[0]) / segment_length, (b[1] - a[1]) / segment_length];
            let along = (x - a[0]) * direction[0] + (y - a[1]) * direction[1];
            let length = (from + along).clamp(low, high);
            let [px, py] = [0, 1].map(|k| a[k] + (length - from) * direction[k]);
            let distance = (x - px).hypot(y - py);
            if distance < min_distance {
                (nearest, min_distance) = (length, distance);
            }
        }
        self.arc_length = nearest;
        min_distance
    }

    /// Segments of the path: arc length at the start, end poses and length, m.
    fn segments(&self) -> impl Iterator<Item = (f64, [f64; 3], [f64; 3], f64)> + '_ {
        let ends = self.path.windows(2).zip(self.lengths.windows(2));
        ends.map(|(pair, lengths)| (lengths[0], pair[0], pair[1], lengths[1] - lengths[0]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn progress_is_the_nearest_point_ahead_and_never_decreases() {
        let corner = vec![[1.0, 2.0, 0.0], [1.5, 2.0, 0.5], [1.5, 3.0, 1.0]];
        let mut progress = PathProgress::new(corner);
        assert!((progress.length() - 1.5).abs() < 1e-12);
        assert!(
            (progress.advance_to([1.3, 2.1, 0.0]) - 0.1).abs() < 1e-12
                && (progress.arc_length - 0.3).abs() < 1e-12
        );
        assert!((progress.pose_at(progress.arc_length)[2] - 0.3).abs() < 1e-12);
        // Around the corner, limited by the window.
        assert!(
            (progress.advance_to([1.6, 2.1, 0.0]) - 0.1).abs() < 1e-12
                && (progress.arc_length - 0.6).abs() < 1e-12
        );
        progress.advance_to([1.0, 2.0, 0.0]);
        assert!((progress.arc_length - 0.6).abs() < 1e-12, "progress never decreases");
        progress.advance_to([1.5, 3.0, 0.0]);
        assert!((progress.arc_length - 1.0).abs() < 1e-12, "progress stays within the window");
    }
}
