//! Ridge candidates: lines across the floor at which a force is missing while a support point is on them.
//!
//! A ridge acts on a support point within a few centimetres only, so that randomly drawn lines would miss it. For each
//! direction, the samples of the missing force are divided into those with a support point in a strip and the others.
//! The strips whose likelihood ratio of two variances is the largest become candidates.

use std::collections::BTreeMap;
use trundle_infer::Residual;
use trundle_model::{Body, to_world};

/// A line in the world.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RidgeCandidate {
    /// Direction of the normal, rad.
    pub angle: f64,
    /// Distance from the world origin along the normal, m.
    pub offset: f64,
    /// Gain in log likelihood of a larger missing force on the line, nats.
    gain: f64,
}

/// Directions of the normal, over half a turn.
const DIRECTIONS: usize = 36;
/// Width of a strip, m: the prior median of a ridge's width.
const STRIP_M: f64 = 0.02;
/// Most candidates that are returned, and the least difference of two, in directions and strips.
const MAX_CANDIDATES: usize = 8;
const MIN_SPACING: i64 = 2;

/// Samples of the missing force.
#[derive(Clone, Copy, Default)]
struct Samples {
    count: f64,
    /// Sum of the squared significance of the force.
    sum: f64,
}

impl Samples {
    fn add(&mut self, square: f64) {
        *self = Self { count: self.count + 1.0, sum: self.sum + square };
    }

    /// −log likelihood at the best variance, up to a constant.
    fn cost(self) -> f64 {
        if self.sum > 0.0 { self.count * (self.sum / self.count).ln() } else { 0.0 }
    }
}

/// Ridge candidates from the missing wrenches along the episodes, the best first.
pub(crate) fn ridge_candidates(courses: &[Vec<Residual>], body: &Body) -> Vec<RidgeCandidate> {
    let samples: Vec<(f64, Vec<[f64; 2]>)> = courses
        .iter()
        .flatten()
        .filter_map(|r| Some((squared_significance(r)?, support_points(r, body))))
        .collect();
    let mut all = Samples::default();
    samples.iter().for_each(|(square, _)| all.add(*square));
    let mut found: Vec<(RidgeCandidate, [i64; 2])> = vec![];
    for direction in 0..DIRECTIONS {
        let angle = std::f64::consts::PI * direction as f64 / DIRECTIONS as f64;
        for (strip, inside) in strips(&samples, angle) {
            let outside = Samples { count: all.count - inside.count, sum: all.sum - inside.sum };
            let is_stronger = inside.sum * outside.count > outside.sum * inside.count;
            if inside.count > 1.0 && outside.count > 1.0 && is_stronger {
                let gain = 0.5 * (all.cost() - inside.cost() - outside.cost());
                let offset = (strip as f64 + 0.5) * STRIP_M;
                found.push((RidgeCandidate { angle, offset, gain }, [direction as i64, strip]));
            }
        }
    }
    found.sort_by(|a, b| b.0.gain.total_cmp(&a.0.gain));
    let mut kept: Vec<(RidgeCandidate, [i64; 2])> = vec![];
    for candidate in found {
        let is_apart = |other: &(RidgeCandidate, [i64; 2])| {
            (0..2).any(|k| (candidate.1[k] - other.1[k]).abs() >= MIN_SPACING)
        };
        if kept.len() < MAX_CANDIDATES && kept.iter().all(is_apart) {
            kept.push(candidate);
        }
    }
    kept.into_iter().map(|(candidate, _)| candidate).collect()
}

/// Samples with a support point in each strip of a direction.
fn strips(samples: &[(f64, Vec<[f64; 2]>)], angle: f64) -> BTreeMap<i64, Samples> {
    let (sin, cos) = angle.sin_cos();
    let mut strips = BTreeMap::<i64, Samples>::new();
    let mut touched = vec![];
    for (square, points) in samples {
        touched.clear();
        touched.extend(points.iter().map(|[x, y]| ((cos * x + sin * y) / STRIP_M).floor() as i64));
        touched.sort_unstable();
        touched.dedup();
        for strip in &touched {
            strips.entry(*strip).or_default().add(*square);
        }
    }
    strips
}

/// Squared significance of the missing force.
fn squared_significance(residual: &Residual) -> Option<f64> {
    let inverse = residual.covariance.fixed_view::<2, 2>(0, 0).try_inverse()?;
    let force = nalgebra::Vector2::new(residual.wrench[0], residual.wrench[1]);
    Some(force.dot(&(inverse * force)))
}

/// Support points in the world, m.
fn support_points(residual: &Residual, body: &Body) -> Vec<[f64; 2]> {
    let [x, y, theta] = residual.pose;
    let placed = |[u, v]: [f64; 2]| {
        let [u, v, _]: [f64; 3] = to_world([u, v, 0.0], theta);
        [x + u, y + v]
    };
    body.support.iter().map(|support| placed(support.point)).collect()
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use nalgebra::Matrix3;

    #[test]
    fn a_line_that_the_feet_cross_is_found() {
        let body = Body::from_footprint(&[[-0.3, -0.2], [0.3, -0.2], [0.3, 0.2], [-0.3, 0.2]], 20.0)
            .unwrap()
            .with_feet(&[[-0.28, -0.18], [0.28, -0.18], [0.28, 0.18], [-0.28, 0.18]]);
        let (angle, offset) = (0.35_f64, 0.61);
        let residual = |k: usize, heading: f64| {
            let pose = [0.005 * k as f64, 0.001 * k as f64, heading + 0.002 * k as f64];
            let mut residual =
                Residual { t: 0.0, pose, twist: [0.0; 3], wrench: [0.0; 3], covariance: Matrix3::identity() };
            let ridge =
                |p: &[f64; 2]| (-(angle.cos() * p[0] + angle.sin() * p[1] - offset).powi(2) / 8e-4).exp();
            let climb: f64 = support_points(&residual, &body).iter().map(ridge).sum();
            residual.wrench[0] = 8.0 * climb + if k.is_multiple_of(2) { 1.0 } else { -1.0 };
            residual
        };
        let courses: Vec<Vec<Residual>> =
            [0.0, 0.8, -0.5].map(|heading| (0..200).map(|k| residual(k, heading)).collect()).into();
        let best = ridge_candidates(&courses, &body)[0];
        let sign = if (best.angle - angle).cos() > 0.0 { 1.0 } else { -1.0 };
        assert!((best.angle - angle).sin().abs() < 0.1, "{best:?}");
        assert!((sign * best.offset - offset).abs() < 0.04, "{best:?}");
    }
}
