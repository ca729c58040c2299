//! Checks of the clocks of wrench and poses: delay, drift, jumps and overlap.

use crate::inertia::DIRECTION_SCALE_SD;
use nalgebra::{DMatrix, SMatrix, SVector};

use crate::motion::Motion;
use crate::prepare::{WrenchSample, median, median_step};

use super::data::EpisodeData;
use super::dynamics::WINDOWS_PER_EPISODE;
use super::finding::{Finding, Severity};
use super::group::grouped;
use super::input::CheckInput;
use super::lags::{Lag, MAX_CONSTANT_LAG_RATIO};

/// Unexplained share up to which estimated lags are reported.
const MAX_UNEXPLAINED_SHARE: f64 = 0.3;
/// Minimum of a constant lag in its standard deviations, if it also reduces the misfit to [`MAX_CONSTANT_LAG_RATIO`]. In
/// clean recordings of `tests/record_prepare/varied.py`, dry friction mimics lags of up to 22 ms at 5 standard deviations,
/// which reduce the misfit by 8 %.
const MIN_LAG_SD: f64 = 10.0;
/// Minimum of a constant lag in its standard deviations, if it does not reduce the misfit that much.
const MIN_UNSUPPORTED_LAG_SD: f64 = 12.0;
/// Minimum of such a lag in steps of the slower stream.
const MIN_UNSUPPORTED_LAG_STEPS: f64 = 0.3;
/// Minimum of a negative lag in steps of the slower stream. Sampled poses do not show when between two samples an impact
/// occurred, and smoothing spreads its acceleration over them.
const MIN_EARLY_LAG_STEPS: f64 = 0.5;
/// Minimum inertial share of the force for [`MIN_INERTIAL_LAG_SD`].
const MIN_INERTIAL_SHARE: f64 = 0.2;
/// Minimum of a positive lag in its standard deviations, if the force is largely inertial. Friction and smoothing mimic
/// only negative lags (by up to 7 standard deviations).
const MIN_INERTIAL_LAG_SD: f64 = 6.5;
/// Minimum size of a jump in steps of the lag grid.
const MIN_JUMP_STEPS: f64 = 3.0;
/// Minimum factor by which a jump reduces the misfit of its episode.
const MIN_JUMP_GAIN: f64 = 3.0;
/// Minimum size of a jump in its standard deviations: the 99 % quantile of Student's t of three windows, the usual number on
/// either side.
const MIN_JUMP_SD: f64 = 9.9;
/// Minimum number of windows before and after a jump.
const MIN_JUMP_WINDOWS: usize = 2;
/// Minimum factor by which a separate lag reduces the misfit of a whole episode.
const MIN_EPISODE_LAG_GAIN: f64 = 5.0;
/// Maximum misfit with a drift, relative to that with a constant lag.
const MAX_DRIFT_TO_CONSTANT_RATIO: f64 = 0.75;
/// Maximum misfit with a drift, relative to that with a free jump in each episode.
const MAX_DRIFT_TO_JUMPS_RATIO: f64 = 1.3;
/// Minimum drift over a push in steps of the lag grid.
const MIN_DRIFT_STEPS: f64 = 3.0;
/// Time before contact that is included, s.
const MARGIN_BEFORE_CONTACT_S: f64 = 0.3;
/// Maximum number of samples of the regression.
const MAX_SAMPLES: usize = 4000;
/// Minimum number of samples of the regression.
const MIN_SAMPLES: usize = 100;
/// Number of regressors: acceleration, velocity and direction of motion in body axes, and a constant.
const TERMS: usize = 10;
/// Number of acceleration regressors, which come first.
const ACCELERATIONS: usize = 3;

type Row = SVector<f64, TERMS>;

/// Checks for a delay, a drift or a jump between the clocks of sensor and tracker.
pub(crate) fn lag(input: &CheckInput) -> Vec<Finding> {
    let Some(fits) = &input.wrench_fits else { return vec![] };
    let lag = &fits.lag;
    let [without_lag, constant, drift, with_jumps] = lag.unexplained;
    if with_jumps.min(drift) > MAX_UNEXPLAINED_SHARE {
        return vec![];
    }
    let over_push = lag.drift.abs() * WINDOWS_PER_EPISODE as f64 / lag.step;
    if drift < MAX_DRIFT_TO_CONSTANT_RATIO * constant
        && drift < MAX_DRIFT_TO_JUMPS_RATIO * with_jumps
        && over_push > MIN_DRIFT_STEPS
    {
        return vec![clock_drift(lag.drift / fits.blocks.window(), constant, drift)];
    }
    let jumps = clock_jumps(input, lag);
    if !jumps.is_empty() {
        return grouped(jumps);
    }
    let (delay, sd) = lag.constant;
    let deviations = delay.abs() / sd.max(lag.step / 40.0);
    let is_supported = deviations > MIN_LAG_SD && constant < MAX_CONSTANT_LAG_RATIO * without_lag;
    let is_inertial = delay > 0.0 && inertial_share(input).is_some_and(|share| share > MIN_INERTIAL_SHARE);
    let min_deviations = if is_inertial { MIN_INERTIAL_LAG_SD } else { MIN_UNSUPPORTED_LAG_SD };
    let steps = delay.abs() / slower_step(input).max(f64::MIN_POSITIVE);
    if (!is_supported && (deviations < min_deviations || steps < MIN_UNSUPPORTED_LAG_STEPS))
        || (delay < 0.0 && steps < MIN_EARLY_LAG_STEPS)
    {
        return vec![];
    }
    vec![constant_lag(delay, sd)]
}

/// Median step of the slower of poses and wrench, s.
fn slower_step(input: &CheckInput) -> f64 {
    let steps = |episode: &EpisodeData| {
        let poses: Vec<f64> = episode.prepared.pose.iter().map(|p| p.t).collect();
        let wrench: Vec<f64> = episode.prepared.wrench.iter().map(|w| w.t).collect();
        Some(median_step(&poses)?.max(median_step(&wrench)?))
    };
    median(input.data.episodes.iter().filter_map(steps)).unwrap_or(0.0)
}

fn constant_lag(lag: f64, sd: f64) -> Finding {
    let direction = if lag > 0.0 { "late" } else { "early" };
    Finding::new(
        "clocks",
        Severity::Warning,
        format!(
            "the wrench fits the motion best if its clock runs {:.1} ± {:.1} ms {direction}",
            1e3 * lag.abs(),
            1e3 * sd
        ),
        "synchronise the clocks of sensor and tracker and correct t, or let the diagnosis estimate the delay",
    )
}

fn clock_drift(drift: f64, before: f64, after: f64) -> Finding {
    let (change, share) = (if drift > 0.0 { "stretched" } else { "compressed" }, 100.0 * drift.abs());
    let sentence = format!(
        "the clocks of wrench and poses drift apart: the delay of the wrench changes by {:+.1} ms per second; a passive body \
         leaves {:.1} % of the wrench unexplained with a constant delay, and {:.1} % with the drift",
        1e3 * drift,
        100.0 * before,
        100.0 * after
    );
    let remedy = format!(
        "stamp both streams with one clock, or correct t: relative to the poses, the wrench is {change} in time by \
         about {share:.1} %"
    );
    Finding::new("clocks", Severity::Warning, sentence, &remedy)
}

/// Episodes whose lag jumps, or differs from that of the other episodes.
fn clock_jumps(input: &CheckInput, lag: &Lag) -> Vec<(f64, Finding)> {
    let found = input.data.episodes.iter().zip(&lag.jumps).filter_map(|(episode, jump)| {
        let size = if jump.window > 0 { jump.after - jump.before } else { jump.before - lag.constant.0 };
        let is_inside = (MIN_JUMP_WINDOWS..=WINDOWS_PER_EPISODE - MIN_JUMP_WINDOWS).contains(&jump.window);
        let min_gain = if jump.window == 0 { MIN_EPISODE_LAG_GAIN } else { MIN_JUMP_GAIN };
        let min_size = MIN_JUMP_STEPS * lag.step;
        // An impact between two samples can shift the lag of a single episode by up to a sample.
        let min_size = if jump.window == 0 { min_size.max(slower_step(input)) } else { min_size };
        let is_determined = size.abs() > MIN_JUMP_SD * jump.sd;
        if size.abs() < min_size || jump.gain < min_gain || !is_determined || (jump.window > 0 && !is_inside)
        {
            return None;
        }
        let words = if jump.window > 0 {
            let share = jump.window as f64 / WINDOWS_PER_EPISODE as f64;
            format!(
                "the wrench clock jumps by {:+.0} ms after about {:.0} % of the push",
                1e3 * size,
                100.0 * share
            )
        } else {
            let direction = if size > 0.0 { "late" } else { "early" };
            format!(
                "the wrench clock is {:.0} ms {direction} relative to the other episodes",
                1e3 * size.abs()
            )
        };
        let remedy = "correct t of the wrench rows of the episode, or remove the episode";
        Some((
            size.abs(),
            Finding::new("clocks", Severity::Warning, words, remedy).in_episode(episode.name()),
        ))
    });
    found.collect()
}

/// Share of the sum of squares of the force that only acceleration explains; `None` if there is too little motion.
pub(crate) fn inertial_share(input: &CheckInput) -> Option<f64> {
    let rows = rows(input);
    if rows.len() < MIN_SAMPLES {
        return None;
    }
    let (with, total) = misfit(input, &rows, 0)?;
    let (without, _) = misfit(input, &rows, ACCELERATIONS)?;
    (total > 0.0).then(|| (without - with) / total)
}

/// Subsampled rows of the regression: episode, time and regressors.
fn rows(input: &CheckInput) -> Vec<(usize, f64, Row)> {
    let all = input.data.episodes.iter().enumerate().flat_map(|(index, episode)| {
        let from = episode.prepared.contact - MARGIN_BEFORE_CONTACT_S;
        episode.motion.iter().filter(move |m| m.t >= from).map(move |m| (index, m.t, regressors(m)))
    });
    let all: Vec<(usize, f64, Row)> = all.collect();
    let stride = all.len().div_ceil(MAX_SAMPLES).max(1);
    all.into_iter().step_by(stride).collect()
}

fn regressors(motion: &Motion) -> Row {
    let (sin, cos) = motion.pose[2].sin_cos();
    let body = |v: [f64; 3]| [cos * v[0] + sin * v[1], cos * v[1] - sin * v[0], v[2]];
    let (accel, twist) = (body(motion.accel), body(motion.twist));
    let sd = [0, 1, 2].map(|k| motion.cov[k][1][1].sqrt());
    let direction = [0, 1, 2].map(|k| twist[k] / twist[k].hypot(DIRECTION_SCALE_SD * sd[k]).max(1e-9));
    let mut row = Row::zeros();
    for k in 0..3 {
        (row[k], row[3 + k], row[6 + k]) = (accel[k], twist[k], direction[k]);
    }
    row[9] = 1.0;
    row
}

/// Residual and total sum of squares of the force in body axes, without the first `left_out` regressors.
fn misfit(input: &CheckInput, rows: &[(usize, f64, Row)], left_out: usize) -> Option<(f64, f64)> {
    let mut normal = SMatrix::<f64, TERMS, TERMS>::zeros();
    let mut right = SMatrix::<f64, TERMS, 2>::zeros();
    let mut total = 0.0;
    for (index, t, row) in rows {
        let Some(force) = force_at(&input.data.episodes[*index].prepared.wrench, *t) else { continue };
        let mut row = *row;
        row.rows_mut(0, left_out).fill(0.0);
        normal += row * row.transpose();
        right += row * force.transpose();
        total += force.norm_squared();
    }
    let scale = normal.norm();
    let inverse =
        DMatrix::from_column_slice(TERMS, TERMS, normal.as_slice()).pseudo_inverse(1e-10 * scale).ok()?;
    let explained = (right.transpose() * inverse * right).trace();
    Some((total - explained, total))
}

/// Linearly interpolated force in body axes; `None` outside the readings.
fn force_at(wrench: &[WrenchSample], t: f64) -> Option<SVector<f64, 2>> {
    let after = wrench.partition_point(|w| w.t <= t);
    let (a, b) = (wrench.get(after.checked_sub(1)?)?, wrench.get(after)?);
    let share = (t - a.t) / (b.t - a.t);
    let [fa, fb] = [a, b].map(|w| w.on_object());
    Some(SVector::from([0, 1].map(|k| fa[k] + share * (fb[k] - fa[k]))))
}

/// Checks that poses and wrench overlap in time.
pub(crate) fn overlap(input: &CheckInput) -> Vec<Finding> {
    grouped(input.data.episodes.iter().filter_map(|episode| Some((0.0, disjoint(episode)?))).collect())
}

fn disjoint(episode: &EpisodeData) -> Option<Finding> {
    let (poses, wrench) = (&episode.prepared.pose, &episode.prepared.wrench);
    let ([first, last], [begin, end]) =
        ([poses.first()?.t, poses.last()?.t], [wrench.first()?.t, wrench.last()?.t]);
    if poses.len() < 2 || (first <= end && begin <= last) {
        return None;
    }
    let sentence = format!(
        "the poses cover {first:.2} to {last:.2} s and the wrench {begin:.2} to {end:.2} s: they do not overlap"
    );
    let remedy = "give both streams the same time origin and unit (seconds)";
    Some(Finding::new("clocks", Severity::Error, sentence, remedy).in_episode(episode.name()))
}
