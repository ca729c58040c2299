//! Regions of the floor that exert a drag on the object's contact points.

use super::places::Region;
use super::score_test::{Column, ScoreTest, force_at, minus_log10_p, velocity_at};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use trundle_infer::Residual;
use trundle_model::{Body, Fixture};

/// Number of cells along the longer side of the visited area.
const GRID_CELLS: f64 = 18.0;
/// Minimum size of a cell, m.
const MIN_CELL_SIZE_M: f64 = 0.05;
/// Minimum drag of a single cell to start a region, in standard deviations.
const MIN_CELL_DRAG_SD: f64 = 3.0;
/// Maximum number of regions.
const MAX_REGIONS: usize = 3;

type Cell = (i64, i64);

/// Points at which a body touches the floor, object frame, m: its feet, or else the corners of its footprint.
pub(crate) fn contact_points(body: &Body) -> Vec<[f64; 2]> {
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

/// World coordinates of a body point.
fn in_world(residual: &Residual, [x, y]: [f64; 2]) -> [f64; 2] {
    let (sin, cos) = residual.pose[2].sin_cos();
    [residual.pose[0] + cos * x - sin * y, residual.pose[1] + sin * x + cos * y]
}

/// Lowest and highest coordinates that the points of the body visit.
fn visited_bounds(residuals: &[Vec<Residual>], points: &[[f64; 2]]) -> [[f64; 2]; 2] {
    let all = residuals.iter().flatten().flat_map(|s| points.iter().map(|p| in_world(s, *p)));
    all.fold([[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]], |[low, high], p| {
        [[low[0].min(p[0]), low[1].min(p[1])], [high[0].max(p[0]), high[1].max(p[1])]]
    })
}

/// Response to a viscous drag of 1 N·s/m at each contact point that lies `inside`.
fn drag_column(score_test: &ScoreTest, points: &[[f64; 2]], contains: impl Fn([f64; 2]) -> bool) -> Column {
    score_test.column(&score_test.profile(|_, residual| {
        let inside = points.iter().filter(|p| contains(in_world(residual, **p)));
        inside.fold([0.0; 3], |sum, p| {
            let [vx, vy] = velocity_at(residual, *p);
            let wrench = force_at(*p, [-vx, -vy]);
            [0, 1, 2].map(|k| sum[k] + wrench[k])
        })
    }))
}

/// Score tests of a drag in each cell of the floor.
struct FloorGrid {
    cells: Vec<Cell>,
    size: f64,
    gram: DMatrix<f64>,
    score: DVector<f64>,
}

impl FloorGrid {
    fn new(score_test: &ScoreTest, points: &[[f64; 2]]) -> Option<Self> {
        let residuals: Vec<Vec<Residual>> = score_test.episodes.iter().map(|r| r.residuals.clone()).collect();
        let [low, high] = visited_bounds(&residuals, points);
        let size = ((high[0] - low[0]).max(high[1] - low[1]) / GRID_CELLS).max(MIN_CELL_SIZE_M);
        if !size.is_finite() {
            return None;
        }
        let cell = |p: [f64; 2]| ((p[0] / size).floor() as i64, (p[1] / size).floor() as i64);
        let mut visited: BTreeSet<Cell> = BTreeSet::new();
        for residuals in score_test.episodes.iter().map(|r| &r.residuals) {
            visited.extend(residuals.iter().flat_map(|s| points.iter().map(|p| cell(in_world(s, *p)))));
        }
        let cells: Vec<Cell> = visited.into_iter().collect();
        let columns: Vec<Column> =
            cells.par_iter().map(|own| drag_column(score_test, points, |p| cell(p) == *own)).collect();
        let n = cells.len();
        let rows: Vec<Vec<f64>> = (0..n)
            .into_par_iter()
            .map(|i| (0..=i).map(|j| columns[i].inner(&columns[j])).collect())
            .collect();
        let gram = DMatrix::from_fn(n, n, |i, j| rows[i.max(j)][i.min(j)]);
        let score = DVector::from_fn(n, |i, _| columns[i].score(&score_test.episodes));
        Some(Self { cells, size, gram, score })
    }

    /// χ² of a common drag of some cells; zero if it would accelerate the object.
    fn common_drag_chi_square(&self, members: &[usize]) -> f64 {
        let score: f64 = members.iter().map(|&i| self.score[i]).sum();
        let square: f64 =
            members.iter().flat_map(|&i| members.iter().map(move |&j| (i, j))).map(|ij| self.gram[ij]).sum();
        let trace: f64 = members.iter().map(|&i| self.gram[(i, i)]).sum();
        if score > 0.0 && square > 1e-6 * trace { score * score / square } else { 0.0 }
    }

    /// Index of each cell.
    fn index(&self) -> BTreeMap<Cell, usize> {
        self.cells.iter().enumerate().map(|(k, c)| (*c, k)).collect()
    }

    /// Adds and removes cells of a set while the χ² of their common drag increases.
    fn grow(&self, seed: usize, excluded: &BTreeSet<usize>) -> (Vec<usize>, f64) {
        let index = self.index();
        let mut members = BTreeSet::from([seed]);
        let mut best = self.common_drag_chi_square(&[seed]);
        loop {
            let mut next: Option<(BTreeSet<usize>, f64)> = None;
            for change in self.candidate_changes(&members, &index, excluded) {
                let mut tried = members.clone();
                if !tried.remove(&change) {
                    tried.insert(change);
                }
                let chi_square = self.common_drag_chi_square(&tried.iter().copied().collect::<Vec<_>>());
                if chi_square > next.as_ref().map_or(best + 2.0, |n| n.1) {
                    next = Some((tried, chi_square));
                }
            }
            match next {
                Some((set, chi_square)) => (members, best) = (set, chi_square),
                None => return (members.into_iter().collect(), best),
            }
        }
    }

    /// Cells that may be added or removed: members, and neighbours up to two cells away.
    fn candidate_changes(
        &self,
        members: &BTreeSet<usize>,
        index: &BTreeMap<Cell, usize>,
        excluded: &BTreeSet<usize>,
    ) -> BTreeSet<usize> {
        let mut changes = if members.len() > 1 { members.clone() } else { BTreeSet::new() };
        for &member in members {
            let (i, j) = self.cells[member];
            for (di, dj) in (-2..=2).flat_map(|di| (-2..=2).map(move |dj| (di, dj))) {
                changes.extend(
                    index.get(&(i + di, j + dj)).filter(|k| !members.contains(k) && !excluded.contains(k)),
                );
            }
        }
        changes
    }

    /// Convex hull of some cells, counter-clockwise.
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
    let mut hull = half(&mut points.iter().copied());
    hull.extend(half(&mut points.iter().rev().copied()));
    hull
}

/// Regions of the floor whose drag explains most, best first.
pub(crate) fn regions(score_test: &ScoreTest, body: &Body) -> Vec<Region> {
    let points = contact_points(body);
    if score_test.free_directions() < 3 || points.is_empty() {
        return vec![];
    }
    let Some(floor) = FloorGrid::new(score_test, &points) else { return vec![] };
    let tests = floor.cells.len() as f64;
    let mut excluded: BTreeSet<usize> = BTreeSet::new();
    let mut found: Vec<Region> = Vec::new();
    let mut seeds: Vec<usize> = (0..floor.cells.len()).collect();
    seeds.sort_by(|&a, &b| floor.common_drag_chi_square(&[b]).total_cmp(&floor.common_drag_chi_square(&[a])));
    for seed in seeds {
        if found.len() == MAX_REGIONS
            || floor.common_drag_chi_square(&[seed]) < MIN_CELL_DRAG_SD * MIN_CELL_DRAG_SD
        {
            break;
        }
        if excluded.contains(&seed) {
            continue;
        }
        let (members, chi_square) = floor.grow(seed, &excluded);
        excluded.extend(&members);
        // Correct for the selection of cells: each member is one more choice.
        let strength =
            minus_log10_p(chi_square, 1) - tests.log10() * (1.0 + (members.len() as f64).log2().max(0.0));
        if strength > 2.0 {
            let share = members.len() as f64 / tests;
            found.push(Region { polygon: floor.polygon(&members), chi_square, share });
        }
    }
    found.sort_by(|a, b| b.chi_square.total_cmp(&a.chi_square));
    found
}

#[cfg(test)]
mod tests {
    use super::hull;

    #[test]
    fn a_hull_has_corners_only() {
        let points = vec![[0.0, 0.0], [1.0, 0.0], [0.5, 0.0], [1.0, 1.0], [0.4, 0.6], [0.0, 1.0], [0.0, 0.0]];
        assert_eq!(hull(points), vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
    }
}
