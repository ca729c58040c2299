//! Whether the wrench and the motion tell the same time.

use nalgebra::{DMatrix, SMatrix, SVector};

use crate::motion::Motion;
use crate::prepare::{WrenchSample, median, median_step};

use super::dynamics::WINDOWS;
use super::group::grouped;
use super::lags::{HELPS, Lag};
use super::subject::{Look, Subject};
use super::{Finding, Severity};

/// Unexplained share up to which lags are believed.
const EXPLAINS: f64 = 0.3;
/// A constant lag is so many standard deviations long, and leaves less than [`HELPS`] of what is unexplained without it;
/// or it is many more long and a good part of the slower stream's step. Over clean recordings of
/// `tests/record_prepare/varied.py` dry friction feigns up to 22 ms at 5 standard deviations, which explains 8 %.
const LATE: f64 = 10.0;
const SURELY: (f64, f64) = (12.0, 0.3);
/// Where acceleration explains at least this share of the force, so many standard deviations suffice for a reading that
/// runs late: friction and smoothed motion feign early ones only (by up to 7 standard deviations).
const INERTIAL: (f64, f64) = (0.2, 6.5);
/// A jump is at least so many steps of the lags tried long, explains so many times more of its episode, and has so
/// many windows on either side; an episode that differs as a whole explains more.
const JUMP: (f64, f64, usize) = (3.0, 3.0, 2);
const APART: f64 = 5.0;
/// A drift leaves less than this share of what a constant lag leaves, about as little as jumps that are free in each
/// episode, and comes to so many steps of the lags tried over a push.
const DRIFT: (f64, f64, f64) = (0.75, 1.3, 3.0);
/// Time before contact that counts too, s.
const BEFORE: f64 = 0.3;
/// Samples that suffice.
const MOST: usize = 4000;
const FEWEST: usize = 100;
/// Acceleration, velocity and direction in body axes, and a constant.
const TERMS: usize = 10;
/// How many of them, the first, are accelerations.
const ACCELERATIONS: usize = 3;

type Row = SVector<f64, TERMS>;

/// A delay, a drift or a jump between the sensor's clock and the tracker's.
pub(crate) fn lag(subject: &Subject) -> Vec<Finding> {
    let Some(explained) = &subject.explained else { return vec![] };
    let lag = &explained.lag;
    let [none, constant, drift, jumps] = lag.share;
    if jumps.min(drift) > EXPLAINS {
        return vec![];
    }
    let over_push = lag.drift.abs() * WINDOWS as f64 / lag.step;
    if drift < DRIFT.0 * constant && drift < DRIFT.1 * jumps && over_push > DRIFT.2 {
        return vec![drifts(lag.drift / explained.blocks.window(), constant, drift)];
    }
    let jumped = jumping(subject, lag);
    if !jumped.is_empty() {
        return grouped(jumped);
    }
    let (late_by, sd) = lag.constant;
    let deviations = late_by.abs() / sd.max(lag.step / 40.0);
    let explains = deviations > LATE && constant < HELPS * none;
    let inertial = late_by > 0.0 && inertial_share(subject).is_some_and(|share| share > INERTIAL.0);
    let least = if inertial { INERTIAL.1 } else { SURELY.0 };
    if !explains && (deviations < least || late_by.abs() < SURELY.1 * slower_step(subject)) {
        return vec![];
    }
    vec![late(late_by, sd)]
}

/// Usual step of the slower of poses and wrench, s.
fn slower_step(subject: &Subject) -> f64 {
    let steps = |look: &Look| {
        let poses: Vec<f64> = look.prepared.pose.iter().map(|p| p.t).collect();
        let wrench: Vec<f64> = look.prepared.wrench.iter().map(|w| w.t).collect();
        Some(median_step(&poses)?.max(median_step(&wrench)?))
    };
    median(subject.episodes.iter().filter_map(steps)).unwrap_or(0.0)
}

fn late(lag: f64, sd: f64) -> Finding {
    let direction = if lag > 0.0 { "late" } else { "early" };
    Finding::new(
        "clocks",
        Severity::Warning,
        format!(
            "the wrench fits the motion best when it is taken to run {:.1} ± {:.1} ms {direction}",
            1e3 * lag.abs(),
            1e3 * sd
        ),
        "synchronise the sensor's clock with the tracker's and correct t, or let the diagnosis estimate the latency",
    )
}

fn drifts(drift: f64, before: f64, after: f64) -> Finding {
    let (faster, share) = (if drift > 0.0 { "slower" } else { "faster" }, 100.0 * drift.abs());
    let sentence = format!(
        "the clocks of wrench and poses drift apart: the wrench's later and later by {:.1} ms in each second; {:.1} % of \
         the load fits no passive body, {:.1} % without the drift",
        1e3 * drift,
        100.0 * before,
        100.0 * after
    );
    let remedy = format!(
        "stamp both streams with one clock, or correct t: in a table's time the wrench's clock runs about {share:.1} % \
         {faster} than it should"
    );
    Finding::new("clocks", Severity::Warning, sentence, &remedy)
}

/// Episodes whose lag jumps, or differs from that of the others.
fn jumping(subject: &Subject, lag: &Lag) -> Vec<(f64, Finding)> {
    let found = subject.episodes.iter().zip(&lag.jumps).filter_map(|(look, jump)| {
        let size = if jump.window > 0 { jump.after - jump.before } else { jump.before - lag.constant.0 };
        let inside = (JUMP.2..=WINDOWS - JUMP.2).contains(&jump.window);
        let least = if jump.window == 0 { APART } else { JUMP.1 };
        let finest = JUMP.0 * lag.step;
        // Blows that fall between two samples seem to shift by up to a sample, in a single episode too.
        let finest = if jump.window == 0 { finest.max(slower_step(subject)) } else { finest };
        if size.abs() < finest || jump.gain < least || (jump.window > 0 && !inside) {
            return None;
        }
        let words = if jump.window > 0 {
            let share = jump.window as f64 / WINDOWS as f64;
            format!("the clock jumps by {:.0} ms after about {:.0} % of the push", 1e3 * size, 100.0 * share)
        } else {
            format!("the wrench runs {:.0} ms later than in the other episodes", 1e3 * size)
        };
        let remedy = "correct t of the wrench's rows there, or leave the episode out";
        Some((size.abs(), Finding::new("clocks", Severity::Warning, words, remedy).of(look.name())))
    });
    found.collect()
}

/// Share of the force's square that only acceleration explains; `None` where there is too little motion to tell.
pub(crate) fn inertial_share(subject: &Subject) -> Option<f64> {
    let rows = rows(subject);
    if rows.len() < FEWEST {
        return None;
    }
    let (with, total) = misfit(subject, &rows, 0)?;
    let (without, _) = misfit(subject, &rows, ACCELERATIONS)?;
    (total > 0.0).then(|| (without - with) / total)
}

/// Moving samples: episode, time and what may explain the wrench, thinned.
fn rows(subject: &Subject) -> Vec<(usize, f64, Row)> {
    let all = subject.episodes.iter().enumerate().flat_map(|(index, look)| {
        let from = look.prepared.contact - BEFORE;
        look.motion.iter().filter(move |m| m.t >= from).map(move |m| (index, m.t, regressors(m)))
    });
    let all: Vec<(usize, f64, Row)> = all.collect();
    let thin = all.len().div_ceil(MOST).max(1);
    all.into_iter().step_by(thin).collect()
}

fn regressors(motion: &Motion) -> Row {
    let (sin, cos) = motion.pose[2].sin_cos();
    let body = |v: [f64; 3]| [cos * v[0] + sin * v[1], cos * v[1] - sin * v[0], v[2]];
    let (accel, twist) = (body(motion.accel), body(motion.twist));
    let sd = [0, 1, 2].map(|k| motion.cov[k][1][1].sqrt());
    let direction = [0, 1, 2].map(|k| twist[k] / twist[k].hypot(3.0 * sd[k]).max(1e-9));
    let mut row = Row::zeros();
    for k in 0..3 {
        (row[k], row[3 + k], row[6 + k]) = (accel[k], twist[k], direction[k]);
    }
    row[9] = 1.0;
    row
}

/// Unexplained and whole sum of squares of the force in body axes, without the first `left_out` regressors.
fn misfit(subject: &Subject, rows: &[(usize, f64, Row)], left_out: usize) -> Option<(f64, f64)> {
    let mut normal = SMatrix::<f64, TERMS, TERMS>::zeros();
    let mut right = SMatrix::<f64, TERMS, 2>::zeros();
    let mut total = 0.0;
    for (index, t, row) in rows {
        let Some(force) = force_at(&subject.episodes[*index].prepared.wrench, *t) else { continue };
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

/// Force in body axes, linear between samples; `None` outside of the recording.
fn force_at(wrench: &[WrenchSample], t: f64) -> Option<SVector<f64, 2>> {
    let after = wrench.partition_point(|w| w.t <= t);
    let (a, b) = (wrench.get(after.checked_sub(1)?)?, wrench.get(after)?);
    let share = (t - a.t) / (b.t - a.t);
    let [fa, fb] = [a, b].map(|w| w.on_object());
    Some(SVector::from([0, 1].map(|k| fa[k] + share * (fb[k] - fa[k]))))
}

/// Streams that do not share their time.
pub(crate) fn overlap(subject: &Subject) -> Vec<Finding> {
    grouped(subject.episodes.iter().filter_map(|look| Some((0.0, apart(look)?))).collect())
}

fn apart(look: &Look) -> Option<Finding> {
    let (poses, wrench) = (&look.prepared.pose, &look.prepared.wrench);
    let ([first, last], [begin, end]) =
        ([poses.first()?.t, poses.last()?.t], [wrench.first()?.t, wrench.last()?.t]);
    if poses.len() < 2 || (first <= end && begin <= last) {
        return None;
    }
    let sentence = format!(
        "poses run from {first:.2} to {last:.2} s, the wrench from {begin:.2} to {end:.2} s: they never overlap"
    );
    let remedy = "bring both clocks to one zero; a stream in another unit or epoch looks like this";
    Some(Finding::new("clocks", Severity::Error, sentence, remedy).of(look.name()))
}
