//! Where on the object a missing force acts.

use super::Ranked;
use super::lines::Lines;
use super::screen::{Column, Screen, force_at, velocity_at};
use rayon::prelude::*;
use trundle_infer::Residual;
use trundle_model::Body;

/// Points of the first grid along the longer side.
const ACROSS: usize = 12;
/// Distance at which the search ends, as a share of the first grid's.
const FINEST: f64 = 1.0 / 32.0;
/// Log likelihood by which a place must beat none.
pub(crate) const MARGIN: f64 = 5.0;
/// A point known worse than this is not told, m.
pub(crate) const SHARP: f64 = 0.07;
/// Share of the missing force's moment, squared, that may be left about a point.
pub(crate) const LEFT: f64 = 0.15;
/// How far outside of the footprint a point may seem to lie, m.
const OUTSIDE: f64 = 0.1;
/// Candidates that are handed on.
const RANKED: usize = 4;
/// Speed below which dry friction turns smoothly, m/s.
const CREEP: f64 = 0.005;

/// Lowest and highest coordinates of a search.
pub(crate) type Reach = [[f64; 2]; 2];

/// Where a point may lie.
fn reach(body: &Body) -> Reach {
    let [low, high] = body.bounds();
    [low.map(|v| v - OUTSIDE), high.map(|v| v + OUTSIDE)]
}

/// A square grid over a box, with so many points along its longer side, and its spacing.
pub(crate) fn grid([low, high]: Reach, across: usize) -> (Vec<[f64; 2]>, f64) {
    let spacing = (high[0] - low[0]).max(high[1] - low[1]) / (across.max(2) - 1) as f64;
    let count = |k: usize| ((high[k] - low[k]) / spacing + 1e-9).floor() as usize;
    let at = |i: usize, j: usize| [low[0] + i as f64 * spacing, low[1] + j as f64 * spacing];
    let points = (0..=count(0)).flat_map(|i| (0..=count(1)).map(move |j| at(i, j)));
    (points.collect(), spacing)
}

/// Eight neighbours.
const AROUND: [[f64; 2]; 8] =
    [[-1.0, -1.0], [-1.0, 0.0], [-1.0, 1.0], [0.0, -1.0], [0.0, 1.0], [1.0, -1.0], [1.0, 0.0], [1.0, 1.0]];

/// The largest `value` near a start, by ever smaller steps.
pub(crate) fn climb(
    start: ([f64; 2], f64),
    spacing: f64,
    [low, high]: Reach,
    value: impl Fn([f64; 2]) -> f64 + Sync,
) -> ([f64; 2], f64) {
    let (mut best, mut step) = (start, spacing / 2.0);
    while step > spacing * FINEST {
        let from = best.0;
        let tried: Vec<([f64; 2], f64)> = AROUND
            .par_iter()
            .map(|d| [0, 1].map(|k| (from[k] + d[k] * step).clamp(low[k], high[k])))
            .map(|p| (p, value(p)))
            .collect();
        let next = tried.into_iter().fold(best, |best, own| if own.1 > best.1 { own } else { best });
        if next.0 == best.0 {
            step /= 2.0;
        }
        best = next;
    }
    best
}

/// Standard deviations of the place of a maximum of a log likelihood, from its curvature; infinite where it has none.
pub(crate) fn spread([x, y]: [f64; 2], h: f64, value: impl Fn([f64; 2]) -> f64) -> [f64; 2] {
    let v = |i: f64, j: f64| value([x + i * h, y + j * h]);
    let middle = v(0.0, 0.0);
    let xx = (v(1.0, 0.0) + v(-1.0, 0.0) - 2.0 * middle) / (h * h);
    let yy = (v(0.0, 1.0) + v(0.0, -1.0) - 2.0 * middle) / (h * h);
    let xy = (v(1.0, 1.0) + v(-1.0, -1.0) - v(1.0, -1.0) - v(-1.0, 1.0)) / (4.0 * h * h);
    let determinant = xx * yy - xy * xy;
    let held = xx < 0.0 && yy < 0.0 && determinant > 0.0;
    if held { [(-yy / determinant).sqrt(), (-xx / determinant).sqrt()] } else { [f64::INFINITY; 2] }
}

/// Local maxima of values on a grid, largest first, no two at one place.
pub(crate) fn peaks(points: &[([f64; 2], f64)], spacing: f64) -> Vec<([f64; 2], f64)> {
    let near = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]) < 1.5 * spacing;
    let highest = |own: &&([f64; 2], f64)| {
        own.1.is_finite() && points.iter().all(|other| !near(own.0, other.0) || other.1 <= own.1)
    };
    let mut peaks: Vec<_> = points.iter().filter(highest).copied().collect();
    peaks.sort_by(|a, b| b.1.total_cmp(&a.1));
    peaks
}

/// The best places of a grid, each followed to its peak, best first: place, value.
pub(crate) fn best_places(
    points: Vec<[f64; 2]>,
    spacing: f64,
    reach: Reach,
    value: impl Fn([f64; 2]) -> f64 + Sync,
) -> Vec<([f64; 2], f64)> {
    let values: Vec<([f64; 2], f64)> = points.into_par_iter().map(|p| (p, value(p))).collect();
    let starts = peaks(&values, spacing).into_iter().take(RANKED);
    let mut places: Vec<([f64; 2], f64)> = Vec::new();
    for start in starts {
        let (at, own) = climb(start, spacing, reach, &value);
        if places.iter().all(|(p, _)| (p[0] - at[0]).hypot(p[1] - at[1]) > spacing / 4.0) {
            places.push((at, own));
        }
    }
    places.sort_by(|a, b| b.1.total_cmp(&a.1));
    places
}

/// Body points through which lines of action of smoothed residuals pass, best first, and the one that the data hold.
pub(crate) fn action(courses: &[Vec<Residual>], body: &Body) -> (Vec<Ranked>, Option<Ranked>) {
    if body.fixtures.is_empty() || courses.iter().all(Vec::is_empty) {
        return (vec![], None);
    }
    let lines = Lines::new(courses, body.gyration, |_| true);
    let value = |p: [f64; 2]| lines.through(&|_| p).log_density;
    let (points, spacing) = grid(body.bounds(), ACROSS);
    let places = best_places(points, spacing, reach(body), value);
    let ranked: Vec<Ranked> = places
        .iter()
        .map(|&(at, own)| told(&lines, at, own, spacing / 8.0, reach(body), &|_| at, value))
        .collect();
    let held = ranked.first().filter(|best| holds(courses, body, best)).cloned();
    (ranked, held)
}

/// A place with its standard deviations, which neighbours that say the same widen.
pub(crate) fn told(
    lines: &Lines<'_>,
    at: [f64; 2],
    own: f64,
    h: f64,
    reach: Reach,
    point: &impl Fn(&Residual) -> [f64; 2],
    value: impl Fn([f64; 2]) -> f64,
) -> Ranked {
    let through = lines.through(point);
    let dependent = ((1.0 + through.correlation) / (1.0 - through.correlation)).sqrt();
    let sd = spread(at, h, value).map(|s| s * dependent);
    Ranked { at, sd, strength: own, left: through.left, inside: within(at, reach) }
}

/// Whether the data hold a point: sharp, within the body, with little moment left, and not by one episode alone.
fn holds(courses: &[Vec<Residual>], body: &Body, best: &Ranked) -> bool {
    if !(best.inside && best.left < LEFT && best.sd.iter().all(|s| *s < SHARP)) {
        return false;
    }
    // Without any one episode the point must stay where it is (a jackknife).
    (0..courses.len()).into_par_iter().all(|out| {
        let lines = Lines::new(courses, body.gyration, |e| e != out);
        let value = |p: [f64; 2]| lines.through(&|_| p).log_density;
        let (at, _) = climb((best.at, value(best.at)), SHARP, reach(body), value);
        courses.len() < 3 || (0..2).all(|k| (at[k] - best.at[k]).abs() < SHARP.max(3.0 * best.sd[k]))
    })
}

/// Whether a place is not where a search was stopped.
fn within(at: [f64; 2], [low, high]: Reach) -> bool {
    (0..2).all(|k| low[k] + 1e-6 < at[k] && at[k] < high[k] - 1e-6)
}

/// Points at which dry friction would explain most, best first; the strength is half the χ² of one degree of freedom.
pub(crate) fn rubbing(screen: &Screen, body: &Body) -> Vec<Ranked> {
    if body.fixtures.is_empty() || screen.directions() < 3 {
        return vec![];
    }
    let value = |p: [f64; 2]| {
        let test = screen.test(&[&friction(screen, p)]);
        if test.coefficients[0] > 0.0 { test.chi_square / 2.0 } else { 0.0 }
    };
    let (points, spacing) = grid(body.bounds(), ACROSS);
    let places = best_places(points, spacing, reach(body), value);
    let told = |(at, strength): ([f64; 2], f64)| {
        let sd = spread(at, spacing / 4.0, value);
        Ranked { at, sd, strength, left: 1.0, inside: within(at, reach(body)) }
    };
    places.into_iter().filter(|p| p.1 > MARGIN).map(told).collect()
}

/// One newton of dry friction at a body point.
fn friction(screen: &Screen, point: [f64; 2]) -> Column {
    screen.column(&screen.profile(|_, seen| {
        let [vx, vy] = velocity_at(seen, point);
        let speed = vx.hypot(vy).hypot(CREEP);
        force_at(point, [-vx / speed, -vy / speed])
    }))
}
