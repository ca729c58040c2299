//! Where on the floor a missing wrench acts: cells that drag at what stands on them, and points through which lines
//! of action pass.

use super::body::{LEFT, SHARP, best_places, grid, told};
use super::lines::Lines;
use super::screen::{Column, Screen, force_at, surprise, velocity_at};
use super::{Ranked, Region};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use trundle_infer::Residual;
use trundle_model::{Body, Fixture};

/// Cells along the longer side of what was visited.
const ACROSS: f64 = 18.0;
/// Smallest cell, m.
const SMALLEST: f64 = 0.05;
/// Standard deviations of a cell's own drag from which on it holds residual.
const SIGNIFICANT: f64 = 3.0;
/// Regions that are handed on.
const RANKED: usize = 3;
/// Grid for points in the world along the longer side.
const POINTS: usize = 24;

type Cell = (i64, i64);

/// Where a body touches the floor, object frame, m: as with the floor's patches, its feet or else its corners.
pub(crate) fn touching(body: &Body) -> Vec<[f64; 2]> {
    match &body.feet {
        Some(feet) if !feet.is_empty() => feet.clone(),
        _ => body.fixtures.iter().flat_map(corners).collect(),
    }
}

fn corners(fixture: &Fixture) -> Vec<[f64; 2]> {
    match fixture {
        Fixture::Polygon { vertices, .. } => vertices.clone(),
        Fixture::Disc { center: [x, y], radius: r, .. } => {
            vec![[x - r, *y], [x + r, *y], [*x, y - r], [*x, y + r]]
        }
    }
}

/// A body point in the world.
fn in_world(seen: &Residual, [x, y]: [f64; 2]) -> [f64; 2] {
    let (sin, cos) = seen.pose[2].sin_cos();
    [seen.pose[0] + cos * x - sin * y, seen.pose[1] + sin * x + cos * y]
}

/// A point of the world in the object frame.
fn in_body(seen: &Residual, [x, y]: [f64; 2]) -> [f64; 2] {
    let (sin, cos) = seen.pose[2].sin_cos();
    let (dx, dy) = (x - seen.pose[0], y - seen.pose[1]);
    [cos * dx + sin * dy, cos * dy - sin * dx]
}

/// Smallest and largest coordinates of what was visited.
fn visited(courses: &[Vec<Residual>], points: &[[f64; 2]]) -> [[f64; 2]; 2] {
    let all = courses.iter().flatten().flat_map(|s| points.iter().map(|p| in_world(s, *p)));
    all.fold([[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]], |[low, high], p| {
        [[low[0].min(p[0]), low[1].min(p[1])], [high[0].max(p[0]), high[1].max(p[1])]]
    })
}

/// One viscous drag of 1 N·s/m at each touching point that `inside` holds.
fn dragging(screen: &Screen, points: &[[f64; 2]], inside: impl Fn([f64; 2]) -> bool) -> Column {
    screen.column(&screen.profile(|_, seen| {
        let held = points.iter().filter(|p| inside(in_world(seen, **p)));
        held.fold([0.0; 3], |sum, p| {
            let [vx, vy] = velocity_at(seen, *p);
            let wrench = force_at(*p, [-vx, -vy]);
            [0, 1, 2].map(|k| sum[k] + wrench[k])
        })
    }))
}

/// The scan over the floor.
struct Floor {
    cells: Vec<Cell>,
    size: f64,
    gram: DMatrix<f64>,
    score: DVector<f64>,
}

impl Floor {
    fn new(screen: &Screen, points: &[[f64; 2]]) -> Option<Self> {
        let courses: Vec<Vec<Residual>> = screen.runs.iter().map(|r| r.course.clone()).collect();
        let [low, high] = visited(&courses, points);
        let size = ((high[0] - low[0]).max(high[1] - low[1]) / ACROSS).max(SMALLEST);
        if !size.is_finite() {
            return None;
        }
        let cell = |p: [f64; 2]| ((p[0] / size).floor() as i64, (p[1] / size).floor() as i64);
        let mut seen: BTreeSet<Cell> = BTreeSet::new();
        for course in screen.runs.iter().map(|r| &r.course) {
            seen.extend(course.iter().flat_map(|s| points.iter().map(|p| cell(in_world(s, *p)))));
        }
        let cells: Vec<Cell> = seen.into_iter().collect();
        let columns: Vec<Column> =
            cells.par_iter().map(|own| dragging(screen, points, |p| cell(p) == *own)).collect();
        let n = cells.len();
        let rows: Vec<Vec<f64>> = (0..n)
            .into_par_iter()
            .map(|i| (0..=i).map(|j| columns[i].inner(&columns[j])).collect())
            .collect();
        let gram = DMatrix::from_fn(n, n, |i, j| rows[i.max(j)][i.min(j)]);
        let score = DVector::from_fn(n, |i, _| columns[i].score(&screen.runs));
        Some(Self { cells, size, gram, score })
    }

    /// χ² of one common drag of some cells, if it brakes.
    fn together(&self, members: &[usize]) -> f64 {
        let score: f64 = members.iter().map(|&i| self.score[i]).sum();
        let square: f64 =
            members.iter().flat_map(|&i| members.iter().map(move |&j| (i, j))).map(|ij| self.gram[ij]).sum();
        let whole: f64 = members.iter().map(|&i| self.gram[(i, i)]).sum();
        if score > 0.0 && square > 1e-6 * whole { score * score / square } else { 0.0 }
    }

    /// Cells by place.
    fn index(&self) -> BTreeMap<Cell, usize> {
        self.cells.iter().enumerate().map(|(k, c)| (*c, k)).collect()
    }

    /// Grow and trim a set of cells while their common drag explains more.
    fn grown(&self, seed: usize, banned: &BTreeSet<usize>) -> (Vec<usize>, f64) {
        let index = self.index();
        let mut members = BTreeSet::from([seed]);
        let mut best = self.together(&[seed]);
        loop {
            let mut next: Option<(BTreeSet<usize>, f64)> = None;
            for change in self.changes(&members, &index, banned) {
                let mut tried = members.clone();
                if !tried.remove(&change) {
                    tried.insert(change);
                }
                let own = self.together(&tried.iter().copied().collect::<Vec<_>>());
                if own > next.as_ref().map_or(best + 2.0, |n| n.1) {
                    next = Some((tried, own));
                }
            }
            match next {
                Some((set, own)) => (members, best) = (set, own),
                None => return (members.into_iter().collect(), best),
            }
        }
    }

    /// Members, and neighbours up to two cells away.
    fn changes(
        &self,
        members: &BTreeSet<usize>,
        index: &BTreeMap<Cell, usize>,
        banned: &BTreeSet<usize>,
    ) -> BTreeSet<usize> {
        let mut changes = if members.len() > 1 { members.clone() } else { BTreeSet::new() };
        for &member in members {
            let (i, j) = self.cells[member];
            for (di, dj) in (-2..=2).flat_map(|di| (-2..=2).map(move |dj| (di, dj))) {
                changes.extend(
                    index.get(&(i + di, j + dj)).filter(|k| !members.contains(k) && !banned.contains(k)),
                );
            }
        }
        changes
    }

    /// The convex polygon around some cells, counter-clockwise.
    fn polygon(&self, members: &[usize]) -> Vec<[f64; 2]> {
        let corners = members.iter().flat_map(|&k| {
            let (i, j) = self.cells[k];
            [(0, 0), (1, 0), (0, 1), (1, 1)]
                .map(|(a, b)| [(i + a) as f64 * self.size, (j + b) as f64 * self.size])
        });
        hull(corners.collect())
    }
}

/// Convex hull, counter-clockwise (Andrew 1979).
pub(crate) fn hull(mut points: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    points.dedup();
    if points.len() < 3 {
        return points;
    }
    let half = |points: &mut dyn Iterator<Item = [f64; 2]>| {
        let mut chain: Vec<[f64; 2]> = Vec::new();
        for p in points {
            while let [.., a, b] = chain.as_slice() {
                if (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]) > 0.0 {
                    break;
                }
                chain.pop();
            }
            chain.push(p);
        }
        chain.pop();
        chain
    };
    let mut whole = half(&mut points.iter().copied());
    whole.extend(half(&mut points.iter().rev().copied()));
    whole
}

/// Regions of the floor whose drag explains most, best first.
pub(crate) fn regions(screen: &Screen, body: &Body) -> Vec<Region> {
    let points = touching(body);
    if screen.directions() < 3 || points.is_empty() {
        return vec![];
    }
    let Some(floor) = Floor::new(screen, &points) else { return vec![] };
    let tests = floor.cells.len() as f64;
    let mut banned: BTreeSet<usize> = BTreeSet::new();
    let mut found: Vec<Region> = Vec::new();
    let mut seeds: Vec<usize> = (0..floor.cells.len()).collect();
    seeds.sort_by(|&a, &b| floor.together(&[b]).total_cmp(&floor.together(&[a])));
    for seed in seeds {
        if found.len() == RANKED || floor.together(&[seed]) < SIGNIFICANT * SIGNIFICANT {
            break;
        }
        if banned.contains(&seed) {
            continue;
        }
        let (members, chi_square) = floor.grown(seed, &banned);
        banned.extend(&members);
        // Each cell that was chosen to be in is one more that could have been out.
        let strength =
            surprise(chi_square, 1) - tests.log10() * (1.0 + (members.len() as f64).log2().max(0.0));
        if strength > 2.0 {
            let share = members.len() as f64 / tests;
            found.push(Region { polygon: floor.polygon(&members), chi_square, strength, share });
        }
    }
    found.sort_by(|a, b| b.chi_square.total_cmp(&a.chi_square));
    found
}

/// Points of the world through which lines of action pass, best first, and the one that the data hold.
pub(crate) fn world_points(courses: &[Vec<Residual>], body: &Body) -> (Vec<Ranked>, Option<Ranked>) {
    if body.fixtures.is_empty() || courses.iter().all(Vec::is_empty) {
        return (vec![], None);
    }
    let lines = Lines::new(courses, body.gyration, |_| true);
    let value = |q: [f64; 2]| lines.through(&|s| in_body(s, q)).log_density;
    let [low, high] = visited(courses, &touching(body));
    // An anchor may lie beyond what was visited.
    let beyond = 0.2 * (high[0] - low[0]).max(high[1] - low[1]);
    let reach = [low.map(|v| v - beyond), high.map(|v| v + beyond)];
    let (points, spacing) = grid(reach, POINTS);
    if !(spacing.is_finite() && spacing > 0.0) {
        return (vec![], None);
    }
    let h = spacing / 16.0;
    let told = |&(at, own): &([f64; 2], f64)| told(&lines, at, own, h, reach, &|s| in_body(s, at), value);
    let ranked: Vec<Ranked> = best_places(points, spacing, reach, value).iter().map(told).collect();
    let held = |best: &&Ranked| best.inside && best.left < LEFT && best.sd.iter().all(|s| *s < SHARP);
    let held = ranked.first().filter(held).cloned();
    (ranked, held)
}

#[cfg(test)]
mod tests {
    use super::hull;

    #[test]
    fn a_hull_keeps_corners_alone() {
        let points = vec![[0.0, 0.0], [1.0, 0.0], [0.5, 0.0], [1.0, 1.0], [0.4, 0.6], [0.0, 1.0], [0.0, 0.0]];
        assert_eq!(hull(points), vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
    }
}
