//! Inertial share of the force. It decides whether a recording is compared by its motion or by its wrench.

use nalgebra::{DMatrix, DVector};

use crate::motion::Motion;
use crate::prepare::{Dataset, Prepared, WrenchSample};

/// Share of the sum of squares of the force that acceleration explains, in addition to velocity, direction of motion and a
/// constant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InertialShare {
    /// The share, 0 to 1.
    pub mean: f64,
    /// Standard deviation of the share, by a jackknife over parts of episodes.
    pub sd: f64,
}

/// Maximum share of inertia in the force's sum of squares for a quasi-static recording. Without inertia, the
/// wrench is then wrong by less than a tenth of the force (root mean square), which is the variation of
/// friction over a floor.
pub const MAX_QUASI_STATIC_SHARE: f64 = 0.01;
/// Speed, in its standard deviations, that scales the smooth sign function of the direction of motion.
pub(crate) const DIRECTION_SCALE_SD: f64 = 3.0;
/// Minimum number of parts for the jackknife. Episodes are split into halves, or into smaller parts if there are few long
/// episodes.
const MIN_PARTS: usize = 4;
/// Minimum number of rows in parts that are smaller than half an episode.
const MIN_ROWS_PER_PART: usize = 100;
/// Maximum number of rows per episode. More rows add no information, because accelerations are smoothed over many samples.
const MAX_ROWS_PER_EPISODE: usize = 500;

impl InertialShare {
    /// Inertial share of the training episodes from contact on. `None` if there are no rows with motion and force, or too few
    /// parts for a standard deviation.
    pub fn of(data: &Dataset) -> Option<Self> {
        let axes: &[usize] = if data.dof[1] { &[0, 1] } else { &[0] };
        let turns = data.dof[2];
        let pieces = MIN_PARTS.div_ceil(data.training.len().max(1)).max(2);
        let parts: Vec<Normal> = data
            .training
            .iter()
            .flat_map(|episode| rows(data, episode, pieces))
            .map(|rows| Normal::of(&rows, axes, turns))
            .collect();
        if parts.len() < MIN_PARTS {
            return None;
        }
        let whole = Normal::sum(&parts, usize::MAX)?;
        let mean = whole.share()?;
        let left_out: Vec<f64> = (0..parts.len()).filter_map(|k| Normal::sum(&parts, k)?.share()).collect();
        let n = left_out.len() as f64;
        let middle = left_out.iter().sum::<f64>() / n.max(1.0);
        let variance =
            left_out.iter().map(|s| (s - middle).powi(2)).sum::<f64>() * (n - 1.0).max(0.0) / n.max(1.0);
        Some(Self { mean, sd: variance.sqrt() })
    }
}

/// Motion and force in object axes at one time.
type Row = (Motion, [f64; 2]);

/// Rows of the parts of an episode: `pieces` parts if the episode is long enough, otherwise two.
fn rows(data: &Dataset, episode: &Prepared, pieces: usize) -> Vec<Vec<Row>> {
    let motion = episode.motion(&data.noise);
    let moving: Vec<&Motion> = motion.iter().filter(|m| m.t >= episode.contact).collect();
    let thin = moving.len().div_ceil(MAX_ROWS_PER_EPISODE).max(1);
    let all: Vec<Row> = moving
        .into_iter()
        .step_by(thin)
        .filter_map(|m| Some((m.clone(), force(&episode.wrench, m.t)?)))
        .collect();
    let pieces = if all.len() >= pieces * MIN_ROWS_PER_PART { pieces } else { 2 };
    all.chunks(all.len().div_ceil(pieces).max(1)).map(<[Row]>::to_vec).collect()
}

/// Interpolated force on the object at time `t`, object axes, N; `None` outside the readings.
fn force(wrench: &[WrenchSample], t: f64) -> Option<[f64; 2]> {
    let after = wrench.partition_point(|w| w.t <= t);
    let (a, b) = (wrench.get(after.checked_sub(1)?)?, wrench.get(after)?);
    let share = (t - a.t) / (b.t - a.t);
    let ([ax, ay, _], [bx, by, _]) = (a.on_object(), b.on_object());
    Some([ax + share * (bx - ax), ay + share * (by - ay)])
}

/// Regressors of the force: accelerations, velocities and directions of motion of the used axes, and a constant.
fn regressors(motion: &Motion, axes: &[usize], turns: bool) -> Vec<f64> {
    let (sin, cos) = motion.pose[2].sin_cos();
    let body = |[x, y, w]: [f64; 3]| [cos * x + sin * y, cos * y - sin * x, w];
    let (accel, twist) = (body(motion.accel), body(motion.twist));
    let sure = |k: usize| DIRECTION_SCALE_SD * motion.cov[k][1][1].sqrt();
    let direction = |k: usize| twist[k] / twist[k].hypot(sure(k)).max(f64::MIN_POSITIVE);
    let used: Vec<usize> = axes.iter().copied().chain(turns.then_some(2)).collect();
    let of = |value: &dyn Fn(usize) -> f64| used.iter().map(|&k| value(k)).collect::<Vec<_>>();
    [of(&|k| accel[k]), of(&|k| twist[k]), of(&direction), vec![1.0]].concat()
}

/// Normal equations of a regression of the force on its [`regressors`].
struct Normal {
    left: DMatrix<f64>,
    right: DMatrix<f64>,
    total: f64,
    accelerations: usize,
}

impl Normal {
    fn of(rows: &[Row], axes: &[usize], turns: bool) -> Self {
        let accelerations = axes.len() + usize::from(turns);
        let terms = 3 * accelerations + 1;
        let (mut left, mut right) = (DMatrix::zeros(terms, terms), DMatrix::zeros(terms, axes.len()));
        let mut total = 0.0;
        for (motion, force) in rows {
            let row = DVector::from_vec(regressors(motion, axes, turns));
            left += &row * row.transpose();
            for (column, &k) in axes.iter().enumerate() {
                right.column_mut(column).axpy(force[k], &row, 1.0);
                total += force[k] * force[k];
            }
        }
        Self { left, right, total, accelerations }
    }

    /// The sum of all parts except `but`.
    fn sum(parts: &[Self], but: usize) -> Option<Self> {
        let kept = parts.iter().enumerate().filter(|(k, _)| *k != but).map(|(_, part)| part);
        kept.fold(None, |sum: Option<Self>, part| {
            let (left, right, total) = match sum {
                None => (part.left.clone(), part.right.clone(), part.total),
                Some(sum) => (sum.left + &part.left, sum.right + &part.right, sum.total + part.total),
            };
            Some(Self { left, right, total, accelerations: part.accelerations })
        })
    }

    /// Sum of squares that the regressors from index `first` on explain.
    fn explained(&self, first: usize) -> Option<f64> {
        let n = self.left.nrows() - first;
        let (left, right) = (self.left.view((first, first), (n, n)), self.right.rows(first, n));
        // Scale the columns, because the pseudo-inverse drops small singular values.
        let scale = DVector::from_fn(n, |k, _| left[(k, k)].sqrt());
        let scale = scale.map(|s| if s > 0.0 { s.recip() } else { 0.0 });
        let scaled = DMatrix::from_fn(n, n, |i, j| left[(i, j)] * scale[i] * scale[j]);
        let right = DMatrix::from_fn(n, right.ncols(), |i, j| right[(i, j)] * scale[i]);
        Some((right.transpose() * scaled.pseudo_inverse(1e-9).ok()? * &right).trace())
    }

    fn share(&self) -> Option<f64> {
        let gained = self.explained(0)? - self.explained(self.accelerations)?;
        let share = gained / self.total;
        share.is_finite().then_some(share.max(0.0))
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::prepare::{Noise, PoseSample};
    use trundle_model::Body;

    /// A cart on a rail with dry friction of 5 N, which oscillates at `rate` rad/s with speeds up to 0.2 m/s.
    fn oscillating(mass: f64, rate: f64) -> Dataset {
        let (x, v, a) = (
            |t: f64| -0.2 / rate * (rate * t).cos(),
            |t: f64| 0.2 * (rate * t).sin(),
            |t: f64| 0.2 * rate * (rate * t).cos(),
        );
        let times = || (0..800).map(|k| 0.01 * f64::from(k));
        let episode = |ordinal: usize| Prepared {
            name: format!("push_{ordinal}"),
            ordinal,
            pose: times().map(|t| PoseSample { t, pose: [x(t), 0.0, 0.0] }).collect(),
            wrench: times()
                .map(|t| {
                    let reading = [mass * a(t) + 5.0 * v(t).signum(), 0.0, 0.0];
                    WrenchSample { t, reading, ..Default::default() }
                })
                .collect(),
            ..Default::default()
        };
        Dataset {
            name: "oscillating".to_owned(),
            body: Body::point(mass).unwrap(),
            dof: [true, false, false],
            noise: Noise { pose: [1e-5; 3], force: 0.1, torque: 0.1, time: 0.0, stated: true },
            point_contact: false,
            commanded: false,
            wrench_pose: Default::default(),
            mass_given: None,
            training: (0..3).map(episode).collect(),
            held_out: vec![],
            obstacles: vec![],
        }
    }

    #[test]
    fn share_matches_the_analytic_value() {
        // 4 kg at 2 rad/s: 1.6 N against 5 N, mean square 1.28 / (25 + 1.28).
        let fast = InertialShare::of(&oscillating(4.0, 2.0)).unwrap();
        assert!((fast.mean - 0.0487).abs() < 0.01 && fast.sd < 0.01, "{fast:?}");
        let slow = InertialShare::of(&oscillating(4.0, 0.4)).unwrap();
        assert!(slow.mean + 2.0 * slow.sd < 0.01, "{slow:?}");
    }

    #[test]
    fn one_long_episode_suffices_and_one_push_does_not() {
        let mut log = oscillating(4.0, 0.4);
        log.training.truncate(1);
        let share = InertialShare::of(&log).unwrap();
        assert!(share.mean + 2.0 * share.sd < 0.01, "{share:?}");
        log.training[0].pose.truncate(300);
        assert!(InertialShare::of(&log).is_none());
    }

    #[test]
    fn share_is_independent_of_units() {
        let share = |scale: f64| {
            let mut data = oscillating(4.0, 2.0);
            for episode in &mut data.training {
                episode.pose.iter_mut().for_each(|p| p.pose[0] *= scale);
                episode.wrench.iter_mut().for_each(|w| w.reading[0] *= 64.0 * scale);
                episode.motion_cache = Default::default();
            }
            data.noise.pose = data.noise.pose.map(|sd| sd * scale);
            InertialShare::of(&data).unwrap().mean
        };
        assert!((share(1024.0) / share(1.0) - 1.0).abs() < 0.02);
    }
}
