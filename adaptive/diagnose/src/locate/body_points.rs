//! Points on the object at which a missing force acts.

use super::lines_of_action::LinesOfAction;
use super::places::RankedPlace;
use super::score_test::{Column, ScoreTest, force_at, velocity_at};
use rayon::prelude::*;
use trundle_infer::Residual;
use trundle_model::Body;

/// Number of points along the longer side of the first grid.
const GRID_POINTS: usize = 12;
/// Step at which the search ends, as a share of the first grid's spacing.
const MIN_STEP_SHARE: f64 = 1.0 / 32.0;
/// Minimum gain in log likelihood of a place over no place, nats.
pub(crate) const MIN_GAIN_NATS: f64 = 5.0;
/// Maximum standard deviation of a reported point, m.
pub(crate) const MAX_POINT_SD_M: f64 = 0.07;
/// Maximum share of the missing force's moment, squared, that remains about a reported point.
pub(crate) const MAX_MOMENT_SHARE: f64 = 0.15;
/// Maximum distance of a point from the footprint, m.
const MAX_DISTANCE_OUTSIDE_M: f64 = 0.1;
/// Maximum number of candidates.
const MAX_CANDIDATES: usize = 4;
/// Speed below which dry friction is smoothed, m/s.
const SMOOTHING_SPEED_M_PER_S: f64 = 0.005;

/// Lowest and highest coordinates of a search.
pub(crate) type Bounds = [[f64; 2]; 2];

/// Bounds of the search for a point.
fn bounds(body: &Body) -> Bounds {
    let [low, high] = body.bounds();
    [low.map(|v| v - MAX_DISTANCE_OUTSIDE_M), high.map(|v| v + MAX_DISTANCE_OUTSIDE_M)]
}

/// Points of a square grid over a box, with `across` points along its longer side, and their spacing.
pub(crate) fn grid([low, high]: Bounds, across: usize) -> (Vec<[f64; 2]>, f64) {
    let spacing = (high[0] - low[0]).max(high[1] - low[1]) / (across.max(2) - 1) as f64;
    let count = |k: usize| ((high[k] - low[k]) / spacing + 1e-9).floor() as usize;
    let at = |i: usize, j: usize| [low[0] + i as f64 * spacing, low[1] + j as f64 * spacing];
    let points = (0..=count(0)).flat_map(|i| (0..=count(1)).map(move |j| at(i, j)));
    (points.collect(), spacing)
}

/// Offsets of the eight neighbours.
const NEIGHBOURS: [[f64; 2]; 8] =
    [[-1.0, -1.0], [-1.0, 0.0], [-1.0, 1.0], [0.0, -1.0], [0.0, 1.0], [1.0, -1.0], [1.0, 0.0], [1.0, 1.0]];

/// Maximises `value` from a start by pattern search with decreasing steps.
pub(crate) fn pattern_search(
    start: ([f64; 2], f64),
    spacing: f64,
    [low, high]: Bounds,
    value: impl Fn([f64; 2]) -> f64 + Sync,
) -> ([f64; 2], f64) {
    let (mut best, mut step) = (start, spacing / 2.0);
    while step > spacing * MIN_STEP_SHARE {
        let from = best.0;
        let tried: Vec<([f64; 2], f64)> = NEIGHBOURS
            .par_iter()
            .map(|d| [0, 1].map(|k| (from[k] + d[k] * step).clamp(low[k], high[k])))
            .map(|p| (p, value(p)))
            .collect();
        let next = tried
            .into_iter()
            .fold(best, |best, candidate| if candidate.1 > best.1 { candidate } else { best });
        if next.0 == best.0 {
            step /= 2.0;
        }
        best = next;
    }
    best
}

/// Standard deviations of the maximum of a log likelihood, from its curvature; infinite where it is not a
/// maximum.
pub(crate) fn curvature_sd([x, y]: [f64; 2], h: f64, value: impl Fn([f64; 2]) -> f64) -> [f64; 2] {
    let v = |i: f64, j: f64| value([x + i * h, y + j * h]);
    let middle = v(0.0, 0.0);
    let xx = (v(1.0, 0.0) + v(-1.0, 0.0) - 2.0 * middle) / (h * h);
    let yy = (v(0.0, 1.0) + v(0.0, -1.0) - 2.0 * middle) / (h * h);
    let xy = (v(1.0, 1.0) + v(-1.0, -1.0) - v(1.0, -1.0) - v(-1.0, 1.0)) / (4.0 * h * h);
    let determinant = xx * yy - xy * xy;
    let is_maximum = xx < 0.0 && yy < 0.0 && determinant > 0.0;
    if is_maximum { [(-yy / determinant).sqrt(), (-xx / determinant).sqrt()] } else { [f64::INFINITY; 2] }
}

/// Local maxima of values on a grid, largest first, with a minimum spacing.
pub(crate) fn peaks(points: &[([f64; 2], f64)], spacing: f64) -> Vec<([f64; 2], f64)> {
    let near = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]) < 1.5 * spacing;
    let highest = |point: &&([f64; 2], f64)| {
        point.1.is_finite() && points.iter().all(|other| !near(point.0, other.0) || other.1 <= point.1)
    };
    let mut peaks: Vec<_> = points.iter().filter(highest).copied().collect();
    peaks.sort_by(|a, b| b.1.total_cmp(&a.1));
    peaks
}

/// Places and values of the largest maxima of a grid after a pattern search, best first.
pub(crate) fn best_maxima(
    points: Vec<[f64; 2]>,
    spacing: f64,
    bounds: Bounds,
    value: impl Fn([f64; 2]) -> f64 + Sync,
) -> Vec<([f64; 2], f64)> {
    let values: Vec<([f64; 2], f64)> = points.into_par_iter().map(|p| (p, value(p))).collect();
    let starts = peaks(&values, spacing).into_iter().take(MAX_CANDIDATES);
    let mut places: Vec<([f64; 2], f64)> = Vec::new();
    for start in starts {
        let (at, maximum) = pattern_search(start, spacing, bounds, &value);
        if places.iter().all(|(p, _)| (p[0] - at[0]).hypot(p[1] - at[1]) > spacing / 4.0) {
            places.push((at, maximum));
        }
    }
    places.sort_by(|a, b| b.1.total_cmp(&a.1));
    places
}

/// Body points through which the lines of action of the smoothed residuals pass, best first, and the best one if
/// it is identifiable.
pub(crate) fn action_points(
    residuals: &[Vec<Residual>],
    body: &Body,
) -> (Vec<RankedPlace>, Option<RankedPlace>) {
    if body.fixtures.is_empty() || residuals.iter().all(Vec::is_empty) {
        return (vec![], None);
    }
    let lines = LinesOfAction::new(residuals, body.gyration, |_| true);
    let value = |p: [f64; 2]| lines.fit_point(&|_| p).log_density;
    let (points, spacing) = grid(body.bounds(), GRID_POINTS);
    let places = best_maxima(points, spacing, bounds(body), value);
    let ranked: Vec<RankedPlace> = places
        .iter()
        .map(|&(at, maximum)| {
            with_uncertainty(&lines, at, maximum, spacing / 8.0, bounds(body), &|_| at, value)
        })
        .collect();
    let identifiable = ranked.first().filter(|best| is_identifiable(residuals, body, best)).cloned();
    (ranked, identifiable)
}

/// A place with its standard deviations, widened for the correlation of neighbouring samples.
pub(crate) fn with_uncertainty(
    lines: &LinesOfAction<'_>,
    at: [f64; 2],
    maximum: f64,
    h: f64,
    bounds: Bounds,
    point: &impl Fn(&Residual) -> [f64; 2],
    value: impl Fn([f64; 2]) -> f64,
) -> RankedPlace {
    let point_fit = lines.fit_point(point);
    let widening = ((1.0 + point_fit.correlation) / (1.0 - point_fit.correlation)).sqrt();
    let sd = curvature_sd(at, h, value).map(|s| s * widening);
    RankedPlace {
        at,
        sd,
        strength: maximum,
        residual_share: point_fit.residual_share,
        is_inside: is_off_bounds(at, bounds),
    }
}

/// Whether a point is identifiable: precise, within the bounds, with a small residual moment, and not due to one
/// episode alone.
fn is_identifiable(residuals: &[Vec<Residual>], body: &Body, best: &RankedPlace) -> bool {
    if !(best.is_inside
        && best.residual_share < MAX_MOMENT_SHARE
        && best.sd.iter().all(|s| *s < MAX_POINT_SD_M))
    {
        return false;
    }
    // The point must stay the same if any one episode is left out (jackknife).
    (0..residuals.len()).into_par_iter().all(|out| {
        let lines = LinesOfAction::new(residuals, body.gyration, |e| e != out);
        let value = |p: [f64; 2]| lines.fit_point(&|_| p).log_density;
        let (at, _) = pattern_search((best.at, value(best.at)), MAX_POINT_SD_M, bounds(body), value);
        residuals.len() < 3
            || (0..2).all(|k| (at[k] - best.at[k]).abs() < MAX_POINT_SD_M.max(3.0 * best.sd[k]))
    })
}

/// Whether a place is not on the bounds of the search.
fn is_off_bounds(at: [f64; 2], [low, high]: Bounds) -> bool {
    (0..2).all(|k| low[k] + 1e-6 < at[k] && at[k] < high[k] - 1e-6)
}

/// Points at which dry friction explains most, best first. The strength is half the χ² with one degree of
/// freedom.
pub(crate) fn friction_points(score_test: &ScoreTest, body: &Body) -> Vec<RankedPlace> {
    if body.fixtures.is_empty() || score_test.free_directions() < 3 {
        return vec![];
    }
    let value = |p: [f64; 2]| {
        let test = score_test.test(&[&friction_column(score_test, p)]);
        if test.coefficients[0] > 0.0 { test.chi_square / 2.0 } else { 0.0 }
    };
    let (points, spacing) = grid(body.bounds(), GRID_POINTS);
    let places = best_maxima(points, spacing, bounds(body), value);
    let ranked = |(at, strength): ([f64; 2], f64)| {
        let sd = curvature_sd(at, spacing / 4.0, value);
        RankedPlace { at, sd, strength, residual_share: 1.0, is_inside: is_off_bounds(at, bounds(body)) }
    };
    places.into_iter().filter(|p| p.1 > MIN_GAIN_NATS).map(ranked).collect()
}

/// Response to 1 N of dry friction at a body point.
fn friction_column(score_test: &ScoreTest, point: [f64; 2]) -> Column {
    score_test.column(&score_test.profile(|_, residual| {
        let [vx, vy] = velocity_at(residual, point);
        let speed = vx.hypot(vy).hypot(SMOOTHING_SPEED_M_PER_S);
        force_at(point, [-vx / speed, -vy / speed])
    }))
}
