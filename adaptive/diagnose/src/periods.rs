//! Periodic components of a missing force in position and in time, such as the ripple of a screw, cogging, or
//! a fan.
//!
//! A Lomb periodogram (Lomb 1976) projects the missing force on sines of many wavelengths. Periods in
//! position have one phase for the whole recording, and periods in time one phase for each episode.
//! Successive samples are correlated, so that a peak is judged against the spectrum around it: without lines,
//! power is distributed exponentially about its local mean. A line in position must also have the same phase
//! throughout the recording.
//!
//! Integrals over position weight each sample by its speed. Otherwise a force at almost zero speed, such as
//! friction at a reversal, would dominate a single position. A ripple that is passed fast oscillates faster
//! than a smoother follows. Periods in position are therefore also sought in the missing force before
//! smoothing.

use crate::answer::Period;
use std::collections::BTreeMap;
use std::f64::consts::{LN_2, PI, TAU};
use trundle_infer::Residual;
use trundle_model::to_world;

/// Probability of one false line in a whole spectrum.
const FALSE_ALARM: f64 = 1e-3;
/// Trial frequencies per resolution element.
const OVERSAMPLING: f64 = 3.0;
/// Approximate limit of samples times trial frequencies of a spectrum, about 0.05 s of computing; and most
/// trial frequencies.
const MAX_TERMS: usize = 6_000_000;
const MAX_TRIAL_FREQUENCIES: usize = 4000;
/// Least number of periods in the data, and of samples in a period.
const MIN_REPEATS: f64 = 4.0;
const MIN_SAMPLES_PER_PERIOD: f64 = 4.0;
/// A peak is a maximum over this many trial frequencies on either side.
const PEAK_HALF_WIDTH: usize = 3;
/// Half width of the spectrum around a peak that serves as background, trial frequencies.
const BACKGROUND_HALF_WIDTH: usize = 40;
/// Periods in time need a frequency above this multiple of the motion's root mean square frequency.
const MIN_BANDWIDTH_RATIO: f64 = 5.0;
/// Directions in the plane along which position is measured.
const DIRECTIONS: usize = 6;
/// Parts of an episode whose phases are compared, and the least coherent share of their power. With random
/// phases, the share is one over the number of parts.
const PARTS_PER_EPISODE: usize = 4;
const MIN_COHERENCE: f64 = 0.5;
/// Most lines that are reported of each spectrum.
const MAX_LINES: usize = 3;

/// A line of a spectrum.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Line {
    /// Period, m or s.
    pub period: f64,
    /// Amplitude of the force, N.
    pub amplitude: f64,
    /// World direction along which position is measured, rad.
    pub angle: f64,
}

/// A force at a position or time.
#[derive(Clone, Copy, Debug, Default)]
struct Sample {
    /// Position or time, m or s.
    at: f64,
    /// Force, world axes, N.
    force: [f64; 2],
    /// Weight in sums over samples.
    weight: f64,
}

/// Successive samples of one episode.
type Samples = Vec<Sample>;

/// Periods in position of the missing wrenches; `rail`: only x moves.
pub(crate) fn in_position(courses: &[Vec<Residual>], rail: bool) -> Vec<Line> {
    let directions = if rail { 1 } else { DIRECTIONS };
    let mut found = vec![];
    for k in 0..directions {
        let angle = PI * k as f64 / DIRECTIONS as f64;
        let (sin, cos) = angle.sin_cos();
        let along = |of: [f64; 3]| cos * of[0] + sin * of[1];
        let episodes = sampled(courses, rail, |r| (along(r.pose), along(r.twist).abs()));
        let all_episodes = [episodes.concat()];
        let coherent = |frequency: f64| in_phase(&episodes, frequency);
        found.extend(lines(&all_episodes, 0.0, coherent).into_iter().map(|line| Line { angle, ..line }));
    }
    strongest(found)
}

/// Periods in time of the missing wrenches. Frequencies must be above those of the motion and absent from the
/// direction of motion, because a force that depends on the motion repeats with it.
pub(crate) fn in_time(courses: &[Vec<Residual>], rail: bool) -> Vec<Line> {
    let min_frequency = MIN_BANDWIDTH_RATIO * bandwidth(courses);
    let headings = headings(courses);
    let is_not_of_motion = |frequency: f64| !has_line(&headings, frequency);
    strongest(lines(&sampled(courses, rail, |r| (r.t, 1.0)), min_frequency, is_not_of_motion))
}

/// Direction of the velocity, as samples of a force.
fn headings(courses: &[Vec<Residual>]) -> Vec<Samples> {
    let one = |r: &Residual| {
        let speed = r.twist[0].hypot(r.twist[1]).max(f64::MIN_POSITIVE);
        Sample { at: r.t, force: [r.twist[0] / speed, r.twist[1] / speed], weight: 1.0 }
    };
    courses.iter().map(|course| course.iter().map(one).collect()).collect()
}

/// Whether a spectrum has a line within a resolution element of a frequency.
fn has_line(groups: &[Samples], frequency: f64) -> bool {
    let step = step(groups);
    let first = (frequency / step - BACKGROUND_HALF_WIDTH as f64).max(1.0).ceil() as usize;
    let middle = (frequency / step).round() as usize;
    let power: Vec<f64> =
        (first..=middle + BACKGROUND_HALF_WIDTH).map(|k| power(groups, step * k as f64)).collect();
    let at = middle.saturating_sub(first);
    let own = near_peak(&power, at).iter().copied().fold(0.0, f64::max);
    own > ratio(2 * PEAK_HALF_WIDTH + 1) * background(&power, at)
}

/// Distance of the trial frequencies.
fn step(groups: &[Samples]) -> f64 {
    1.0 / (OVERSAMPLING * groups.iter().map(extent).fold(0.0, f64::max))
}

/// Total power of all groups at a frequency.
fn power(groups: &[Samples], frequency: f64) -> f64 {
    groups.iter().map(|g| squared(projected(g, frequency))).sum()
}

/// Ratio of the largest of `trials` trial powers to the median around it that chance exceeds with probability
/// [`FALSE_ALARM`]. Neighbouring trials of an oversampled spectrum are not independent.
fn ratio(trials: usize) -> f64 {
    (trials as f64 / OVERSAMPLING / FALSE_ALARM).ln() / LN_2
}

/// Root mean square frequency of the motion's velocity, Hz.
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

/// Periods in position and time for the answer, from smoothed and unsmoothed missing wrenches.
pub(crate) fn for_answer([smoothed, raw]: [&[Vec<Residual>]; 2], rail: bool) -> Vec<Period> {
    let of = |of: &'static str, unit: &'static str| {
        move |line: Line| Period { of, period: line.period, unit, amplitude: line.amplitude }
    };
    let by_position = [in_position(smoothed, rail), in_position(raw, rail)].concat();
    let mut all: Vec<Period> = strongest(by_position).into_iter().map(of("position", "m")).collect();
    all.extend(in_time(smoothed, rail).into_iter().map(of("time", "s")));
    all
}

/// The strongest of the lines that have about the same period, which several directions show.
fn strongest(mut lines: Vec<Line>) -> Vec<Line> {
    lines.sort_by(|a, b| b.amplitude.total_cmp(&a.amplitude));
    let mut kept: Vec<Line> = vec![];
    for line in lines {
        if kept.len() < MAX_LINES && kept.iter().all(|k| (k.period / line.period).ln().abs() > 0.1) {
            kept.push(line);
        }
    }
    kept
}

/// Samples of each episode; `at` returns coordinate and weight.
fn sampled(courses: &[Vec<Residual>], rail: bool, at: impl Fn(&Residual) -> (f64, f64)) -> Vec<Samples> {
    let one = |r: &Residual| {
        let [x, y, _] = to_world([r.wrench[0], r.wrench[1], 0.0], r.pose[2]);
        let force = if rail { [r.wrench[0], 0.0] } else { [x, y] };
        let (at, weight) = at(r);
        Sample { at, force, weight }
    };
    courses.iter().map(|course| course.iter().map(one).collect()).collect()
}

/// Means of the samples in bins of a width. Single samples would alias frequencies above their sampling rate.
fn binned(samples: &Samples, width: f64) -> Samples {
    let mut bins: BTreeMap<i64, Sample> = BTreeMap::new();
    for s in samples {
        let bin = bins.entry((s.at / width).floor() as i64).or_default();
        bin.at += s.weight * s.at;
        bin.force = [0, 1].map(|k| bin.force[k] + s.weight * s.force[k]);
        bin.weight += s.weight;
    }
    let mean = |sum: Sample| Sample {
        at: sum.at / sum.weight,
        force: sum.force.map(|f| f / sum.weight),
        weight: sum.weight,
    };
    bins.into_values().filter(|sum| sum.weight > 0.0).map(mean).collect()
}

/// Lines above `min_frequency` that exceed the background. Each group of samples has its own phase.
fn lines(groups: &[Samples], min_frequency: f64, agrees: impl Fn(f64) -> bool) -> Vec<Line> {
    let longest = groups.iter().map(extent).fold(0.0, f64::max);
    let count: usize = groups.iter().map(Vec::len).sum();
    let spacing = groups.iter().map(spacing).fold(0.0, f64::max);
    if count < 10 * BACKGROUND_HALF_WIDTH || longest <= 0.0 || spacing <= 0.0 {
        return vec![];
    }
    let (first, step) = ((MIN_REPEATS / longest).max(min_frequency), step(groups));
    let bins = |width: f64| groups.iter().map(|g| (extent(g) / width).min(g.len() as f64)).sum::<f64>();
    let trials = |width: f64| {
        ((1.0 / (MIN_SAMPLES_PER_PERIOD * width) - first) / step).clamp(0.0, MAX_TRIAL_FREQUENCIES as f64)
    };
    let excess = (bins(spacing) * trials(spacing) / MAX_TERMS as f64).max(1.0);
    let width = spacing * excess;
    let trials = trials(width) as usize;
    if trials < 2 * BACKGROUND_HALF_WIDTH {
        return vec![];
    }
    let groups: Vec<Samples> = groups.iter().map(|g| binned(g, width)).collect();
    let frequency = |k: usize| first + step * k as f64;
    let power: Vec<f64> = (0..trials).map(|k| power(&groups, frequency(k))).collect();
    let ratio = ratio(trials);
    let mut found: Vec<(f64, usize)> = vec![];
    for (k, &own) in power.iter().enumerate() {
        let peak = near_peak(&power, k).iter().all(|p| *p <= own);
        if peak && own > ratio * background(&power, k) {
            found.push((own, k));
        }
    }
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    let line = |(own, k): (f64, usize)| {
        let amplitude = 2.0 * (own / groups.len() as f64).sqrt();
        Line { period: 1.0 / frequency(k), amplitude, angle: 0.0 }
    };
    found.into_iter().filter(|(_, k)| agrees(frequency(*k))).take(MAX_LINES).map(line).collect()
}

/// Powers at the trial frequencies among which `k` is a peak.
fn near_peak(power: &[f64], k: usize) -> &[f64] {
    let end = (k + PEAK_HALF_WIDTH + 1).min(power.len());
    &power[k.saturating_sub(PEAK_HALF_WIDTH).min(end)..end]
}

/// Median of the power around a peak, without the peak.
fn background(power: &[f64], k: usize) -> f64 {
    let skipped = 2 * OVERSAMPLING as usize;
    let near = (k.saturating_sub(BACKGROUND_HALF_WIDTH)..(k + BACKGROUND_HALF_WIDTH + 1).min(power.len()))
        .filter(|i| i.abs_diff(k) > skipped);
    let mut all: Vec<f64> = near.map(|i| power[i]).collect();
    all.sort_by(f64::total_cmp);
    all.get(all.len() / 2).copied().unwrap_or(f64::INFINITY)
}

/// Mean of `force · exp(−i 2π f s)` of both components: real and imaginary parts.
fn projected(samples: &[Sample], frequency: f64) -> [f64; 4] {
    let mut sum = [0.0; 4];
    for Sample { at, force, weight } in samples {
        let (sin, cos) = (TAU * frequency * at).sin_cos();
        for (k, f) in force.iter().enumerate() {
            sum[2 * k] += weight * f * cos;
            sum[2 * k + 1] -= weight * f * sin;
        }
    }
    let all = weight(samples);
    sum.map(|v| if all > 0.0 { v / all } else { 0.0 })
}

fn weight(samples: &[Sample]) -> f64 {
    samples.iter().map(|s| s.weight).sum()
}

fn squared(parts: [f64; 4]) -> f64 {
    parts.iter().map(|p| p * p).sum()
}

/// Whether a line has the same phase in all parts of the recording: the coherent share of the power.
fn in_phase(episodes: &[Samples], frequency: f64) -> bool {
    let parts = episodes.iter().flat_map(|e| e.chunks(e.len().div_ceil(PARTS_PER_EPISODE).max(1)));
    let (mut sum, mut power, mut count) = ([0.0; 4], 0.0, 0.0);
    for part in parts {
        let (n, own) = (weight(part), projected(part, frequency));
        sum = [0, 1, 2, 3].map(|k| sum[k] + n * own[k]);
        power += n * squared(own);
        count += n;
    }
    squared(sum) > MIN_COHERENCE * count * power
}

fn extent(samples: &Samples) -> f64 {
    let all = samples.iter().map(|s| s.at);
    all.clone().fold(f64::NEG_INFINITY, f64::max) - all.fold(f64::INFINITY, f64::min)
}

/// Median distance of neighbouring samples that differ.
fn spacing(samples: &Samples) -> f64 {
    let mut steps: Vec<f64> =
        samples.windows(2).map(|w| (w[1].at - w[0].at).abs()).filter(|d| *d > 0.0).collect();
    steps.sort_by(f64::total_cmp);
    steps.get(steps.len() / 2).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::{for_answer, in_position, in_time};
    use nalgebra::Matrix3;
    use rand::{RngExt, SeedableRng};
    use std::f64::consts::TAU;
    use trundle_infer::Residual;

    /// Episodes of a body that moves to and fro on a rail, with a random-walk force and a given force of
    /// position, speed and time.
    fn courses(force: impl Fn(f64, f64, f64) -> f64) -> Vec<Vec<Residual>> {
        courses_at(0.9, force)
    }

    /// The same for a motion of `rate` rad/s.
    fn courses_at(rate: f64, force: impl Fn(f64, f64, f64) -> f64) -> Vec<Vec<Residual>> {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(1);
        let mut episode = |k: usize| {
            let mut walk = 0.0;
            let mut one = |i: usize| {
                let t = 0.01 * i as f64;
                let phase = rate * t + k as f64;
                let (x, v) = (0.27 / rate * phase.sin() + 0.05 * t, 0.27 * phase.cos() + 0.05);
                walk = 0.95 * walk + 0.1 * (rng.random::<f64>() - 0.5);
                let wrench = [walk + force(x, v, t + 0.13 * k as f64), 0.0, 0.0];
                let (pose, twist) = ([x, 0.0, 0.0], [v, 0.0, 0.0]);
                Residual { t, pose, twist, wrench, covariance: Matrix3::identity() }
            };
            (0..800).map(&mut one).collect()
        };
        (0..4).map(&mut episode).collect()
    }

    /// 0.2 N with a period of 20 mm.
    fn ripple(x: f64) -> f64 {
        0.2 * (TAU * x / 0.02).sin()
    }

    #[test]
    fn periods_are_found() {
        let found = in_position(&courses(|x, _, _| ripple(x)), true);
        assert!(found.len() == 1 && (found[0].period - 0.02).abs() < 2e-4, "{found:?}");
        assert!((found[0].amplitude - 0.2).abs() < 0.05, "{found:?}");
        let fan = courses(|_, _, t| 0.2 * (TAU * t / 0.11).sin());
        let found = in_time(&fan, true);
        assert!(!found.is_empty() && (found[0].period - 0.11).abs() < 2e-3, "{found:?}");
        assert!(in_position(&fan, true).is_empty());
    }

    #[test]
    fn friction_at_reversals_masks_no_line() {
        let stuck = |v: f64| if v.abs() < 0.03 { 5.0 } else { 0.0 };
        let found = in_position(&courses(|x, v, _| ripple(x) + stuck(v)), true);
        assert!(found.iter().any(|line| (line.period - 0.02).abs() < 2e-4), "{found:?}");
    }

    #[test]
    fn a_force_of_the_motion_is_no_line_in_time() {
        let stuck = |v: f64| if v.abs() < 0.05 { v.signum() } else { 0.0 };
        assert!(in_time(&courses_at(7.1, |_, v, _| stuck(v)), true).is_empty());
        let fan = courses_at(7.1, |_, v, t| stuck(v) + 0.4 * (TAU * t / 0.0537).sin());
        let found = in_time(&fan, true);
        assert!(found.len() == 1 && (found[0].period - 0.0537).abs() < 1e-3, "{found:?}");
    }

    #[test]
    fn a_line_that_smoothing_removes_is_found_in_unsmoothed_forces() {
        let (smoothed, raw) = (courses(|_, _, _| 0.0), courses(|x, _, _| ripple(x)));
        let of_position = |courses| {
            let found = for_answer(courses, true);
            found.into_iter().filter(|period| period.of == "position").collect::<Vec<_>>()
        };
        let found = of_position([&smoothed, &raw]);
        assert!(found.len() == 1 && (found[0].period - 0.02).abs() < 2e-4, "{found:?}");
        // A line that both spectra show counts once.
        assert_eq!(of_position([&raw, &raw]).len(), 1);
        assert!(of_position([&smoothed, &[]]).is_empty());
    }

    /// Noise like that of second differences of poses.
    #[test]
    fn noise_that_grows_with_frequency_has_no_lines() {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(2);
        let mut noisy = courses(|_, _, _| 0.0);
        for course in &mut noisy {
            let white: Vec<f64> = (0..course.len() + 2).map(|_| rng.random::<f64>() - 0.5).collect();
            for (residual, w) in course.iter_mut().zip(white.windows(3)) {
                residual.wrench[0] += 20.0 * (w[0] - 2.0 * w[1] + w[2]);
            }
        }
        assert!(in_position(&noisy, true).is_empty() && in_time(&noisy, true).is_empty());
    }

    #[test]
    fn a_random_walk_force_has_no_lines() {
        let noise = courses(|_, _, _| 0.0);
        assert!(in_position(&noise, true).is_empty() && in_time(&noise, true).is_empty());
    }
}
