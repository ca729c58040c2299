//! Periods of a missing force, in position and in time: a screw's ripple, cogging, a fan.
//!
//! The smoothed missing force is projected on sines of many wavelengths (Lomb 1976), in position with one phase for the
//! whole recording, in time with a phase of each episode. Smoothed samples depend on one another, so that a peak is
//! judged against the spectrum around it: of a background without lines, power is distributed exponentially about its
//! local mean. A line in position must also have the same phase everywhere.

use crate::answer::Period;
use std::f64::consts::{LN_2, PI, TAU};
use trundle_infer::Residual;
use trundle_model::to_world;

/// Chance of one false line among all frequencies of a spectrum.
const FALSE_ALARM: f64 = 1e-3;
/// Trial frequencies per resolution element.
const OVERSAMPLED: f64 = 3.0;
/// Samples times trial frequencies of a spectrum, at most: a twentieth of a second; and trial frequencies.
const WORK: usize = 6_000_000;
const TRIALS: usize = 4000;
/// Fewest periods that a line repeats, and fewest samples of a period.
const REPEATS: f64 = 4.0;
const SAMPLED: f64 = 4.0;
/// Half width of the spectrum around a peak, trial frequencies.
const AROUND: usize = 40;
/// Frequencies of a motion's course in time beyond this many times its root mean square are not the motion's.
const BEYOND: f64 = 5.0;
/// Directions of the floor that are looked along.
const DIRECTIONS: usize = 6;
/// Parts of an episode whose phases are compared, and the share of their power that must add up: of random phases, as
/// much does as one over their number.
const PARTS: usize = 4;
const IN_PHASE: f64 = 0.5;
/// Lines that are reported of each spectrum, at most.
const MOST: usize = 3;

/// A line of a spectrum.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Line {
    /// m or s.
    pub period: f64,
    /// Of the force, N.
    pub amplitude: f64,
    /// Direction in the world along which the position is counted, rad.
    pub angle: f64,
}

/// A coordinate and a force, world axes, at successive samples of one episode.
type Samples = Vec<(f64, [f64; 2])>;

/// Lines in position along the missing wrenches of some episodes; `rail`: only x moves.
pub(crate) fn in_position(courses: &[Vec<Residual>], rail: bool) -> Vec<Line> {
    let directions = if rail { 1 } else { DIRECTIONS };
    let mut found = vec![];
    for k in 0..directions {
        let angle = PI * k as f64 / DIRECTIONS as f64;
        let (sin, cos) = angle.sin_cos();
        let episodes = sampled(courses, rail, |r| cos * r.pose[0] + sin * r.pose[1]);
        let whole = [episodes.concat()];
        let coherent = |frequency: f64| in_phase(&episodes, frequency);
        found.extend(lines(&whole, 0.0, coherent).into_iter().map(|line| Line { angle, ..line }));
    }
    strongest(found)
}

/// Lines in time, of frequencies beyond those of the motion: what depends on the motion repeats with it.
pub(crate) fn in_time(courses: &[Vec<Residual>], rail: bool) -> Vec<Line> {
    let beyond = BEYOND * bandwidth(courses);
    strongest(lines(&sampled(courses, rail, |r| r.t), beyond, |_| true))
}

/// Root mean square frequency of the motion's velocity, by its changes, Hz.
fn bandwidth(courses: &[Vec<Residual>]) -> f64 {
    let size = |v: [f64; 3]| v[0] * v[0] + v[1] * v[1];
    let (mut slopes, mut squares, mut count) = (0.0, 0.0, 0.0);
    for pair in courses.iter().flat_map(|course| course.windows(2)) {
        let dt = (pair[1].t - pair[0].t).max(f64::MIN_POSITIVE);
        slopes += size([0, 1, 2].map(|k| (pair[1].twist[k] - pair[0].twist[k]) / dt));
        squares += size(pair[0].twist);
        count += 1.0;
    }
    if count == 0.0 || squares == 0.0 { 0.0 } else { (slopes / squares).sqrt() / TAU }
}

/// Lines of both kinds, as the answer lists them.
pub(crate) fn for_answer(courses: &[Vec<Residual>], rail: bool) -> Vec<Period> {
    let of = |of: &'static str, unit: &'static str| {
        move |line: Line| Period { of, period: line.period, unit, amplitude: line.amplitude }
    };
    let mut all: Vec<Period> = in_position(courses, rail).into_iter().map(of("position", "m")).collect();
    all.extend(in_time(courses, rail).into_iter().map(of("time", "s")));
    all
}

/// One of several lines of about the same period, which several directions show: the strongest.
fn strongest(mut lines: Vec<Line>) -> Vec<Line> {
    lines.sort_by(|a, b| b.amplitude.total_cmp(&a.amplitude));
    let mut kept: Vec<Line> = vec![];
    for line in lines {
        if kept.len() < MOST && kept.iter().all(|k| (k.period / line.period).ln().abs() > 0.1) {
            kept.push(line);
        }
    }
    kept
}

fn sampled(courses: &[Vec<Residual>], rail: bool, at: impl Fn(&Residual) -> f64) -> Vec<Samples> {
    let force = |r: &Residual| {
        let [x, y, _] = to_world([r.wrench[0], r.wrench[1], 0.0], r.pose[2]);
        if rail { [r.wrench[0], 0.0] } else { [x, y] }
    };
    courses.iter().map(|course| course.iter().map(|r| (at(r), force(r))).collect()).collect()
}

/// Means of so many neighbours: single samples would fold what is faster than their spacing.
fn thinned(groups: &[Samples], every: usize) -> Vec<Samples> {
    let mean = |part: &[(f64, [f64; 2])]| {
        let n = part.len() as f64;
        let add = |(s, [x, y]): (f64, [f64; 2]), (t, f): &(f64, [f64; 2])| (s + t, [x + f[0], y + f[1]]);
        let (at, force) = part.iter().fold((0.0, [0.0; 2]), add);
        (at / n, force.map(|f| f / n))
    };
    groups.iter().map(|group| group.chunks(every).map(mean).collect()).collect()
}

/// Lines of frequencies above `beyond` that stand out of their surroundings, each group of samples with a phase of its own.
fn lines(groups: &[Samples], beyond: f64, agrees: impl Fn(f64) -> bool) -> Vec<Line> {
    let extent = groups.iter().map(extent).fold(0.0, f64::max);
    let count: usize = groups.iter().map(Vec::len).sum();
    let spacing = groups.iter().map(spacing).fold(0.0, f64::max);
    if count < 10 * AROUND || extent <= 0.0 || spacing <= 0.0 {
        return vec![];
    }
    let (first, step) = ((REPEATS / extent).max(beyond), 1.0 / (OVERSAMPLED * extent));
    let trials_of =
        |every: f64| ((1.0 / (SAMPLED * spacing * every) - first) / step).clamp(0.0, TRIALS as f64);
    let every = (count as f64 * trials_of(1.0) / WORK as f64).ceil().max(1.0);
    let trials = trials_of(every) as usize;
    if trials < 2 * AROUND {
        return vec![];
    }
    let groups = &thinned(groups, every as usize);
    let frequency = |k: usize| first + step * k as f64;
    let power: Vec<f64> =
        (0..trials).map(|k| groups.iter().map(|g| squared(projected(g, frequency(k)))).sum()).collect();
    // Trials of an oversampled spectrum depend on one another: fewer are independent.
    let ratio = (trials as f64 / OVERSAMPLED / FALSE_ALARM).ln() / LN_2;
    let mut found: Vec<(f64, usize)> = vec![];
    for (k, &own) in power.iter().enumerate() {
        let peak = power[k.saturating_sub(3)..(k + 4).min(trials)].iter().all(|p| *p <= own);
        if peak && own > ratio * around(&power, k) && agrees(frequency(k)) {
            found.push((own, k));
        }
    }
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    found.truncate(MOST);
    let line = |(own, k): (f64, usize)| {
        let amplitude = 2.0 * (own / groups.len() as f64).sqrt();
        Line { period: 1.0 / frequency(k), amplitude, angle: 0.0 }
    };
    found.into_iter().map(line).collect()
}

/// Median of the power around a peak, the peak itself left out.
fn around(power: &[f64], k: usize) -> f64 {
    let skipped = 2 * OVERSAMPLED as usize;
    let near =
        (k.saturating_sub(AROUND)..(k + AROUND + 1).min(power.len())).filter(|i| i.abs_diff(k) > skipped);
    let mut all: Vec<f64> = near.map(|i| power[i]).collect();
    all.sort_by(f64::total_cmp);
    all.get(all.len() / 2).copied().unwrap_or(f64::INFINITY)
}

/// Mean of `force · exp(−i 2π f s)`, of both components: real and imaginary parts.
fn projected(samples: &[(f64, [f64; 2])], frequency: f64) -> [f64; 4] {
    let mut sum = [0.0; 4];
    for (s, force) in samples {
        let (sin, cos) = (TAU * frequency * s).sin_cos();
        for (k, f) in force.iter().enumerate() {
            sum[2 * k] += f * cos;
            sum[2 * k + 1] -= f * sin;
        }
    }
    sum.map(|v| v / samples.len().max(1) as f64)
}

fn squared(parts: [f64; 4]) -> f64 {
    parts.iter().map(|p| p * p).sum()
}

/// Whether all parts of the recording have the line in the same phase: the share of their power that adds up.
fn in_phase(episodes: &[Samples], frequency: f64) -> bool {
    let parts = episodes.iter().flat_map(|e| e.chunks(e.len().div_ceil(PARTS).max(1)));
    let (mut sum, mut power, mut count) = ([0.0; 4], 0.0, 0.0);
    for part in parts {
        let (n, own) = (part.len() as f64, projected(part, frequency));
        sum = [0, 1, 2, 3].map(|k| sum[k] + n * own[k]);
        power += n * squared(own);
        count += n;
    }
    squared(sum) > IN_PHASE * count * power
}

fn extent(samples: &Samples) -> f64 {
    let all = samples.iter().map(|(s, _)| *s);
    all.clone().fold(f64::NEG_INFINITY, f64::max) - all.fold(f64::INFINITY, f64::min)
}

/// Median distance of neighbours that are apart at all.
fn spacing(samples: &Samples) -> f64 {
    let mut steps: Vec<f64> =
        samples.windows(2).map(|w| (w[1].0 - w[0].0).abs()).filter(|d| *d > 0.0).collect();
    steps.sort_by(f64::total_cmp);
    steps.get(steps.len() / 2).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::{in_position, in_time};
    use nalgebra::Matrix3;
    use rand::{RngExt, SeedableRng};
    use trundle_infer::Residual;

    /// Episodes of a body that moves to and fro on a rail, with a wandering force and another one.
    fn courses(force: impl Fn(f64, f64) -> f64) -> Vec<Vec<Residual>> {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(1);
        let mut episode = |k: usize| {
            let mut wander = 0.0;
            let mut one = |i: usize| {
                let t = 0.01 * i as f64;
                let x = 0.3 * (0.9 * t + k as f64).sin() + 0.05 * t;
                wander = 0.95 * wander + 0.1 * (rng.random::<f64>() - 0.5);
                let wrench = [wander + force(x, t + 0.13 * k as f64), 0.0, 0.0];
                let (pose, twist) = ([x, 0.0, 0.0], [0.0; 3]);
                Residual { t, pose, twist, wrench, covariance: Matrix3::identity() }
            };
            (0..800).map(&mut one).collect()
        };
        (0..4).map(&mut episode).collect()
    }

    #[test]
    fn lines_are_found_where_they_are() {
        let ripple = courses(|x, _| 0.2 * (std::f64::consts::TAU * x / 0.02).sin());
        let found = in_position(&ripple, true);
        assert!(found.len() == 1 && (found[0].period - 0.02).abs() < 2e-4, "{found:?}");
        assert!((found[0].amplitude - 0.2).abs() < 0.05, "{found:?}");
        let fan = courses(|_, t| 0.2 * (std::f64::consts::TAU * t / 0.11).sin());
        let found = in_time(&fan, true);
        assert!(!found.is_empty() && (found[0].period - 0.11).abs() < 2e-3, "{found:?}");
        assert!(in_position(&fan, true).is_empty());
    }

    #[test]
    fn a_wandering_force_has_no_lines() {
        let noise = courses(|_, _| 0.0);
        assert!(in_position(&noise, true).is_empty() && in_time(&noise, true).is_empty());
    }
}
