//! Distance field to a goal pose among obstacles.
//!
//! Dijkstra's algorithm over a grid of poses with steps in eight directions and turns. Without obstacles the path length
//! has a closed form. The field stores the difference to it, the detour, which is exactly zero far from obstacles.
//!
//! The queue is a list of buckets of path lengths (Dial 1969), which is faster than a heap. A cell whose length decreases
//! within a bucket is visited again, so that the lengths are those of Dijkstra's algorithm.

use std::collections::VecDeque;
use std::f64::consts::{SQRT_2, TAU};

use rayon::prelude::*;

/// Side of a cell, m.
const CELL_M: f64 = 0.08;
/// Number of headings.
const HEADINGS: usize = 40;
/// Angle between two headings, rad.
const HEADING_STEP_RAD: f64 = TAU / HEADINGS as f64;
/// Range of path lengths in a bucket of the queue, m. It is less than the length of a move to a neighbouring cell.
const BUCKET_M: f32 = 0.04;
/// Largest number of buckets, limited by memory.
const MAX_BUCKETS: usize = 100_000;
/// Factor on the cost of moves at blocked poses. A finite factor makes the field decrease towards free poses.
const BLOCKED_COST_FACTOR: f64 = 12.0;

/// Detours on a grid of poses: path lengths to the goal minus those without obstacles.
#[derive(Clone, Debug)]
pub(crate) struct DistanceField {
    low: [f64; 2],
    size: [usize; 2],
    /// Detours, m. The column index varies fastest, then row, then heading.
    detour: Vec<f32>,
}

impl DistanceField {
    /// The field for a goal within bounds `[[x, y], [x, y]]`, m. `turn_cost` is the cost of a turn, m/rad, and
    /// `is_free_pose` tests a position with the sine and cosine of a heading for collisions.
    pub fn new(
        goal: [f64; 3],
        [low, high]: [[f64; 2]; 2],
        turn_cost: f64,
        is_free_pose: impl Fn([f64; 2], (f64, f64)) -> bool + Sync,
    ) -> Self {
        let size = [0, 1].map(|k| ((high[k] - low[k]) / CELL_M).ceil() as usize + 2);
        let mut field = Self { low, size, detour: vec![] };
        let plane = size[0] * size[1];
        let mut is_free = vec![false; plane * HEADINGS];
        is_free.par_chunks_exact_mut(plane).enumerate().for_each(|(heading, is_free)| {
            let heading = (heading as f64 * HEADING_STEP_RAD).sin_cos();
            for (cell, is_free) in is_free.iter_mut().enumerate() {
                *is_free = is_free_pose(field.position(cell), heading);
            }
        });
        let start = field.cell(goal);
        let lengths = field.path_lengths(start, turn_cost, &is_free);
        let detour =
            |(cell, length): (usize, f32)| (length - field.free_length(cell, start, turn_cost)).max(0.0);
        field.detour = lengths.into_iter().enumerate().map(detour).collect();
        field
    }

    /// Path lengths from all cells to `start`.
    fn path_lengths(&self, start: usize, turn_cost: f64, is_free: &[bool]) -> Vec<f32> {
        let mut lengths = vec![f32::INFINITY; is_free.len()];
        let mut buckets = vec![VecDeque::from([start])];
        lengths[start] = 0.0;
        let mut current = 0;
        while current < buckets.len() {
            let Some(cell) = buckets[current].pop_front() else {
                current += 1;
                continue;
            };
            if bucket(lengths[cell]) < current {
                continue;
            }
            self.neighbours(cell, turn_cost, |next, step| {
                let factor = if is_free[next] && is_free[cell] { 1.0 } else { BLOCKED_COST_FACTOR };
                let length = lengths[cell] + (step * factor) as f32;
                if length < lengths[next] {
                    lengths[next] = length;
                    let number = bucket(length);
                    if number >= buckets.len() {
                        buckets.resize_with(number + 1, VecDeque::new);
                    }
                    buckets[number].push_back(next);
                }
            });
        }
        lengths
    }

    fn neighbours(&self, cell: usize, turn_cost: f64, mut visit: impl FnMut(usize, f64)) {
        let (column, row, heading) = self.cell_indices(cell);
        for (dx, dy, step) in NEIGHBOUR_MOVES {
            let (Some(x), Some(y)) = (column.checked_add_signed(dx), row.checked_add_signed(dy)) else {
                continue;
            };
            if x < self.size[0] && y < self.size[1] {
                visit(self.index(x, y, heading), step * CELL_M);
            }
        }
        for turned in [heading + 1, heading + HEADINGS - 1] {
            visit(self.index(column, row, turned % HEADINGS), turn_cost * HEADING_STEP_RAD);
        }
    }

    /// Path length between two cells without obstacles.
    fn free_length(&self, from: usize, to: usize, turn_cost: f64) -> f32 {
        let ((a, b, c), (x, y, z)) = (self.cell_indices(from), self.cell_indices(to));
        let (dx, dy, turns) = (a.abs_diff(x), b.abs_diff(y), c.abs_diff(z));
        let diagonal = dx.min(dy) as f64 * SQRT_2 + (dx.max(dy) - dx.min(dy)) as f64;
        (diagonal * CELL_M + turns.min(HEADINGS - turns) as f64 * HEADING_STEP_RAD * turn_cost) as f32
    }

    /// Detour from a pose, m, by trilinear interpolation.
    #[inline]
    pub fn detour(&self, [x, y, theta]: [f64; 3]) -> f64 {
        let clip = |k: usize, value: f64| {
            ((value - self.low[k]) / CELL_M).clamp(0.0, (self.size[k] - 1) as f64 - 1e-9)
        };
        let (gx, gy) = (clip(0, x), clip(1, y));
        let turn = theta * (1.0 / HEADING_STEP_RAD);
        let floor = turn.floor();
        let below = (floor as i64).rem_euclid(HEADINGS as i64) as usize;
        let (cx, cy) = (gx as usize, gy as usize);
        let (sx, sy, st) = (gx - cx as f64, gy - cy as f64, turn - floor);
        let value = |dx: usize, dy: usize, heading: usize| {
            f64::from(self.detour.get(self.index(cx + dx, cy + dy, heading)).copied().unwrap_or(0.0))
        };
        let plane = |heading: usize| {
            let low = value(0, 0, heading) * (1.0 - sx) + value(1, 0, heading) * sx;
            let high = value(0, 1, heading) * (1.0 - sx) + value(1, 1, heading) * sx;
            low * (1.0 - sy) + high * sy
        };
        plane(below) * (1.0 - st) + plane((below + 1) % HEADINGS) * st
    }

    fn index(&self, column: usize, row: usize, heading: usize) -> usize {
        (heading * self.size[1] + row) * self.size[0] + column
    }

    fn cell_indices(&self, cell: usize) -> (usize, usize, usize) {
        let plane = self.size[0] * self.size[1];
        (cell % self.size[0], cell % plane / self.size[0], cell / plane)
    }

    fn position(&self, cell: usize) -> [f64; 2] {
        let (column, row, _) = self.cell_indices(cell);
        [self.low[0] + column as f64 * CELL_M, self.low[1] + row as f64 * CELL_M]
    }

    fn cell(&self, [x, y, theta]: [f64; 3]) -> usize {
        let near = |k: usize, value: f64| {
            ((value - self.low[k]) / CELL_M).round().clamp(0.0, (self.size[k] - 1) as f64) as usize
        };
        let heading = ((theta / HEADING_STEP_RAD).round() as i64).rem_euclid(HEADINGS as i64) as usize;
        self.index(near(0, x), near(1, y), heading)
    }
}

/// Number of the bucket of a path length, m. The last one contains all greater lengths.
fn bucket(length: f32) -> usize {
    ((length * (1.0 / BUCKET_M)) as usize).min(MAX_BUCKETS - 1)
}

const NEIGHBOUR_MOVES: [(isize, isize, f64); 8] = [
    (1, 0, 1.0),
    (-1, 0, 1.0),
    (0, 1, 1.0),
    (0, -1, 1.0),
    (1, 1, SQRT_2),
    (1, -1, SQRT_2),
    (-1, 1, SQRT_2),
    (-1, -1, SQRT_2),
];

#[cfg(test)]
mod tests {
    use super::*;

    const BOUNDS: [[f64; 2]; 2] = [[-2.0, -2.0], [2.0, 2.0]];

    #[test]
    fn without_obstacles_there_is_no_detour() {
        let field = DistanceField::new([1.0, 0.5, 0.3], BOUNDS, 0.3, |_, _| true);
        assert!(field.detour.iter().all(|e| *e < 1e-4));
    }

    #[test]
    fn any_cost_of_turning_gives_the_shortest_paths() {
        let free = |[x, y]: [f64; 2], _: (f64, f64)| !(x.abs() < 0.1 && y < 1.0);
        for turn_cost in [0.0, 0.01, 1e4, 1e9] {
            let field = DistanceField::new([1.5, 0.0, 0.0], [[-2.0, -1.0], [2.0, 2.0]], turn_cost, free);
            // The number of turns does not change the way around the wall.
            let around = field.detour([-1.5, 0.0, 0.0]);
            assert!((0.4..0.9).contains(&around), "{turn_cost}: {around}");
        }
    }

    #[test]
    fn detours_lead_around_walls_and_out_of_corridors_too_narrow_to_turn() {
        // A wall, and a strip behind it in which only some headings are free.
        let is_free_pose = |[x, y]: [f64; 2], (sin, _): (f64, f64)| {
            let wall = x.abs() < 0.1 && y < 1.0;
            let strip = x > 0.5 && (sin.abs() > 0.3);
            !wall && !strip
        };
        let field = DistanceField::new([1.5, 0.0, 0.0], BOUNDS, 0.3, is_free_pose);
        let around = 2.0 * 1.0f64.hypot(1.5) - 3.0;
        let detour = field.detour([-1.5, 0.0, 0.0]);
        assert!((around - 0.1..around + 0.5).contains(&detour), "{detour} {around}");
        let (left, right) = (field.detour([-1.5, 0.0, 0.3]), field.detour([-1.5, 0.0, -0.3]));
        assert!((left - right).abs() < 1e-3 && left > 0.3, "both directions are equal: {left} {right}");
        // At the goal with the opposite heading: leave the strip, turn, and return.
        let turned = field.detour([1.5, 0.0, 3.1]);
        assert!((1.6..2.6).contains(&turned), "{turned}");
        assert!(field.detour([0.3, 0.0, 0.0]) < 1e-3, "no obstacle ahead");
    }
}
