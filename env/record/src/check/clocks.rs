//! Whether the wrench and the motion tell the same time.

use nalgebra::{DMatrix, SMatrix, SVector};

use crate::motion::Motion;
use crate::prepare::WrenchSample;

use super::subject::{Look, Subject};
use super::{Finding, Severity};

/// Lags tried, s, in steps of [`STEP`].
const RANGE: f64 = 0.3;
const STEP: f64 = 0.01;
/// A lag below this is left to the estimator, s.
const NOTABLE: f64 = 0.03;
/// Share of the unexplained force that must go when the lag is taken out.
const GAIN: f64 = 0.4;
/// Share of the force's square that the motion must explain then: otherwise nothing is known.
const EXPLAINED: f64 = 0.7;
/// Samples that suffice.
const MOST: usize = 4000;
const FEWEST: usize = 100;
/// Acceleration, velocity and direction in body axes, and a constant.
const TERMS: usize = 10;
/// How many of them, the first, are accelerations.
const ACCELERATIONS: usize = 3;

type Row = SVector<f64, TERMS>;

/// A lag between the wrench and the motion: that at which any damped rigid body (linear in acceleration, velocity
/// and direction of motion, all in body axes) explains the wrench best.
pub(crate) fn lag(subject: &Subject) -> Vec<Finding> {
    let steps = (RANGE / STEP).round() as i32;
    let rows: Vec<(usize, f64, Row)> = rows(subject);
    if rows.len() < FEWEST {
        return vec![];
    }
    let misfit = |step: i32| misfit(subject, &rows, f64::from(step) * STEP, 0);
    let Some((now, total)) = misfit(0) else { return vec![] };
    let tried = (-steps..=steps).filter_map(|step| Some((step, misfit(step)?.0)));
    let Some((best, least)) = tried.min_by(|a, b| a.1.total_cmp(&b.1)) else { return vec![] };
    let lag = f64::from(best) * STEP;
    let inside = best.abs() < steps;
    if !inside || lag.abs() < NOTABLE || least > (1.0 - GAIN) * now || least > (1.0 - EXPLAINED) * total {
        return vec![];
    }
    vec![late(lag)]
}

fn late(lag: f64) -> Finding {
    let direction = if lag > 0.0 { "late" } else { "early" };
    Finding::new(
        "clocks",
        Severity::Warning,
        format!(
            "the wrench fits the motion best when it is taken to run {:.0} ms {direction}",
            1e3 * lag.abs()
        ),
        "synchronise the sensor's clock with the tracker's and correct t, or let the diagnosis estimate the latency",
    )
}

/// Share of the force's square that only acceleration explains; `None` where there is too little motion to tell.
pub(crate) fn inertial_share(subject: &Subject) -> Option<f64> {
    let rows = rows(subject);
    if rows.len() < FEWEST {
        return None;
    }
    let (with, total) = misfit(subject, &rows, 0.0, 0)?;
    let (without, _) = misfit(subject, &rows, 0.0, ACCELERATIONS)?;
    (total > 0.0).then(|| (without - with) / total)
}

/// Moving samples: episode, time and what may explain the wrench, thinned.
fn rows(subject: &Subject) -> Vec<(usize, f64, Row)> {
    let all = subject.episodes.iter().enumerate().flat_map(|(index, look)| {
        let from = look.prepared.contact - RANGE;
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

/// Unexplained and whole sum of squares of the force in body axes, read `lag` later than the motion, without the
/// first `left_out` regressors.
fn misfit(subject: &Subject, rows: &[(usize, f64, Row)], lag: f64, left_out: usize) -> Option<(f64, f64)> {
    let mut normal = SMatrix::<f64, TERMS, TERMS>::zeros();
    let mut right = SMatrix::<f64, TERMS, 2>::zeros();
    let mut total = 0.0;
    for (index, t, row) in rows {
        let Some(force) = force_at(&subject.episodes[*index].prepared.wrench, t + lag) else { continue };
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
    subject.episodes.iter().filter_map(apart).collect()
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
