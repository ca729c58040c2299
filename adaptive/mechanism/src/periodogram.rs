//! Periods of a residual in the position of a joint.

use crate::problem::{EpisodeData, Problem};
use crate::rows::{JointRows, Place};

/// Periods that are tried as starting points of a fit.
const MAX_PERIODS: usize = 3;

/// The starting points whose first value is the period with the largest share of the residual, with the amplitude and the
/// phase that fit it. Of neighbouring periods only the best is kept.
pub(crate) fn best_periods(problem: &Problem, rows: &JointRows, starts: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let power: Vec<[f64; 3]> = starts
        .iter()
        .map(|start| projection(&waves(problem, rows, start[0]), rows.residual.as_slice()))
        .collect();
    let is_peak = |k: &usize| {
        let neighbour = |other: Option<usize>| other.and_then(|o| power.get(o)).map_or(0.0, |p| p[0]);
        power[*k][0] >= neighbour(k.checked_sub(1)) && power[*k][0] >= neighbour(Some(k + 1))
    };
    let mut peaks: Vec<usize> = (0..starts.len()).filter(is_peak).collect();
    peaks.sort_by(|a, b| power[*b][0].total_cmp(&power[*a][0]));
    let start = |k: &usize| {
        let [_, sine, cosine] = power[*k];
        vec![starts[*k][0], sine.hypot(cosine), cosine.atan2(sine)]
    };
    peaks.iter().take(MAX_PERIODS).map(start).collect()
}

/// Sine and cosine of the position at the compared samples, filtered and weighted like the residuals: where the joint is
/// fast, little of them is left.
fn waves(problem: &Problem, rows: &JointRows, period: f64) -> Vec<[f64; 2]> {
    let of = |episode: &EpisodeData| -> [Vec<f64>; 2] {
        let phase = |q: &f64| std::f64::consts::TAU * q / period;
        let series = &episode.joints[rows.joint];
        [series.q.iter().map(|q| phase(q).sin()).collect(), series.q.iter().map(|q| phase(q).cos()).collect()]
    };
    let all: Vec<[Vec<f64>; 2]> = problem.episodes.iter().map(of).collect();
    let one = |place: &Place| {
        let episode = &problem.episodes[place.episode];
        let weight = episode.joints[rows.joint].weight[place.sample];
        all[place.episode].each_ref().map(|wave| weight * episode.kernel.at(wave, place.sample))
    };
    rows.places.iter().map(one).collect()
}

/// Explained sum of squares, and the coefficients of sine and cosine.
fn projection(waves: &[[f64; 2]], residual: &[f64]) -> [f64; 3] {
    let (mut ss, mut sc, mut cc, mut rs, mut rc) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for ([sin, cos], r) in waves.iter().zip(residual) {
        ss += sin * sin;
        sc += sin * cos;
        cc += cos * cos;
        // A law's effort adds to the residual: it has to cancel it.
        rs -= r * sin;
        rc -= r * cos;
    }
    let determinant = ss * cc - sc * sc;
    if determinant <= 1e-9 * ss * cc || !determinant.is_finite() {
        return [0.0; 3];
    }
    let (a, b) = ((rs * cc - rc * sc) / determinant, (rc * ss - rs * sc) / determinant);
    [a * rs + b * rc, a, b]
}
