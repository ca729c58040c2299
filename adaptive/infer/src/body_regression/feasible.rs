//! The model of a body regression: the nearest physical parameters.

use std::f64::consts::{PI, SQRT_2};

use nalgebra::{Matrix2, Matrix3, Vector2};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use trundle_model::{Body, Effect, Kind, Model, Posterior, Prior, TruncatedPrior};

use super::equation::mass_matrix;
use super::parameters::{MIN_MASS_RATIO, Parameters, Precision};
use super::prior::BodyPrior;

/// Smallest radius of gyration, as a fraction of that of the outline.
const MIN_GYRATION_RATIO: f64 = 0.15;
/// Smallest damping, N·s/m, of a direction.
const MIN_DAMPING: f64 = 1e-3;
/// Largest coordinate of the equivalent wheel, as a multiple of the radius of gyration of the outline.
const FARTHEST_WHEEL_RATIO: f64 = 5.0;
/// A damping below this multiple of the smallest one is at its bound.
const BOUND_RATIO: f64 = 10.0;
/// Number of draws for the posterior.
const DRAWS: usize = 64;
/// Largest standard deviation of an identified position, as a fraction of half a side; of an angle, rad; and of a damping, as
/// a fraction of its mean.
const MAX_IDENTIFIED_SD: f64 = 0.3;

/// Parameters of the model.
struct Physical {
    mass: f64,
    com: [f64; 2],
    gyration: f64,
    /// `[x, y, angle, mu_x, mu_y]`, with the lower damping first.
    wheel: [f64; 5],
    spin: f64,
}

impl Physical {
    /// The nearest physical parameters: positive mass, inertia and damping, mass centre inside the bounding box. The wheel is
    /// equivalent to all wheels together and may lie outside.
    fn of(body: &Body, prior: &BodyPrior, parameters: &Parameters) -> Self {
        let [low, high] = body.bounds();
        let inside = |[x, y]: [f64; 2]| [x.clamp(low[0], high[0]), y.clamp(low[1], high[1])];
        let mass = parameters[0].max(MIN_MASS_RATIO * body.mass);
        let com = inside([1, 2].map(|k| parameters[k] / mass));
        let least = MIN_GYRATION_RATIO * prior.gyration;
        let square = parameters[3] / mass - com[0] * com[0] - com[1] * com[1];
        let [xx, xy, yy, xt, yt, tt] = positive_damping(prior.gyration, parameters);
        let eigen = Matrix2::new(xx, xy, xy, yy).symmetric_eigen();
        let [a, b] = [eigen.eigenvalues[0], eigen.eigenvalues[1]];
        let axis = eigen.eigenvectors.column(usize::from(b < a)).into_owned();
        // A wheel at (x, y) couples velocity and torque by `matrix · (−y, x)`. Each principal axis is limited by itself,
        // because the lever along an axis with hardly any damping is arbitrary.
        let farthest = farthest_wheel(prior);
        let coupling = eigen.eigenvectors.transpose() * Vector2::new(xt, yt);
        let lever = [0, 1].map(|k| (coupling[k] / eigen.eigenvalues[k]).clamp(-farthest, farthest));
        let spin = tt - lever[0] * lever[0] * a - lever[1] * lever[1] * b;
        let lever = eigen.eigenvectors * Vector2::from(lever);
        let [x, y] = [lever[1], -lever[0]];
        let angle = axis[1].atan2(axis[0]).rem_euclid(PI);
        Self {
            mass,
            com,
            gyration: square.max(least * least).sqrt(),
            wheel: [x, y, angle, a.min(b).max(MIN_DAMPING), a.max(b).max(MIN_DAMPING)],
            spin: spin.max(MIN_DAMPING * prior.gyration * prior.gyration),
        }
    }

    fn model(&self, body: &Body, farthest: f64) -> Model {
        let upper = SQRT_2 * farthest;
        let lower = -upper;
        let body = Body { mass: self.mass, com: self.com, gyration: self.gyration, ..body.clone() };
        let wheel = Effect { kind: Kind::ViscousWheel, values: self.wheel.map(Some).to_vec() };
        let spin = Effect { kind: Kind::SpinDrag, values: vec![Some(self.spin)] };
        let place = |name: &str| (name.to_owned(), TruncatedPrior { prior: Prior::Uniform, lower, upper });
        Model {
            mass: Some(self.mass),
            body,
            dof: [true; 3],
            effects: vec![wheel, spin],
            priors: ["viscous_wheel.x", "viscous_wheel.y"].map(place).into(),
            discrepancy: None,
        }
    }

    /// Values in the order of [`Model::slots`], with the angle nearest to a reference.
    fn values(&self, reference: f64) -> [f64; 7] {
        let [x, y, angle, mu_x, mu_y] = self.wheel;
        let near = angle - PI * ((angle - reference) / PI).round();
        [self.mass, x, y, near, mu_x, mu_y, self.spin]
    }
}

/// Largest coordinate of the equivalent wheel, m.
fn farthest_wheel(prior: &BodyPrior) -> f64 {
    FARTHEST_WHEEL_RATIO * prior.gyration
}

/// The damping matrix without negative eigenvalues, `[xx, xy, yy, xθ, yθ, θθ]`. Lengths are in units of `length`.
fn positive_damping(length: f64, parameters: &Parameters) -> [f64; 6] {
    let [xx, xy, yy, xt, yt, tt] = [4, 5, 6, 7, 8, 9].map(|k| parameters[k]);
    let (xt, yt, tt) = (xt / length, yt / length, tt / (length * length));
    let eigen = Matrix3::new(xx, xy, xt, xy, yy, yt, xt, yt, tt).symmetric_eigen();
    let values = eigen.eigenvalues.map(|value| value.max(MIN_DAMPING));
    let d = eigen.eigenvectors * Matrix3::from_diagonal(&values) * eigen.eigenvectors.transpose();
    [d[(0, 0)], d[(0, 1)], d[(1, 1)], d[(0, 2)] * length, d[(1, 2)] * length, d[(2, 2)] * length * length]
}

/// Matrix `F` with which `before + F (after − before)` is the mean twist of a step of constant wrench.
///
/// Along a mode that decays by `x` during the step, it is `1/(1 − e⁻ˣ) − 1/x`, which is ½ if `x` is small.
pub(super) fn mean_twist(body: &Body, prior: &BodyPrior, parameters: &Parameters, dt: f64) -> Matrix3<f64> {
    let Physical { mass, com: [x, y], gyration, .. } = Physical::of(body, prior, parameters);
    let inertia = mass * (gyration * gyration + x * x + y * y);
    let [xx, xy, yy, xt, yt, tt] = positive_damping(prior.gyration, parameters);
    let damping = Matrix3::new(xx, xy, xt, xy, yy, yt, xt, yt, tt);
    let half = Matrix3::identity() * 0.5;
    let Some(factor) = mass_matrix([mass, mass * x, mass * y, inertia]).cholesky() else { return half };
    let lower = factor.l();
    let Some(inverse) = lower.try_inverse() else { return half };
    let modes = (inverse * damping * inverse.transpose()).symmetric_eigen();
    let shares = modes.eigenvalues.map(|rate| mean_share(rate * dt));
    let from = inverse.transpose() * modes.eigenvectors;
    from * Matrix3::from_diagonal(&shares) * modes.eigenvectors.transpose() * lower.transpose()
}

/// `1/(1 − e⁻ˣ) − 1/x`.
fn mean_share(x: f64) -> f64 {
    if x < 0.01 { 0.5 + x / 12.0 } else { -1.0 / (-x).exp_m1() - 1.0 / x }
}

/// The model of the nearest physical parameters.
pub(super) fn model(body: &Body, prior: &BodyPrior, mean: &Parameters) -> Model {
    Physical::of(body, prior, mean).model(body, farthest_wheel(prior))
}

/// Posterior of the identified parameters of [`model`], from draws.
pub(super) fn posterior(
    body: &Body,
    prior: &BodyPrior,
    mean: &Parameters,
    precision: &Precision,
) -> Option<Posterior> {
    let best = Physical::of(body, prior, mean);
    let centre = best.values(best.wheel[2]);
    let upper = precision.cholesky()?.l().transpose();
    let mut rng = ChaCha8Rng::seed_from_u64(0);
    let mut sum = [[0.0; 7]; 7];
    for _ in 0..DRAWS {
        let normal = Parameters::from_fn(|_, _| rng.sample(StandardNormal));
        let drawn = mean + upper.solve_upper_triangular(&normal)?;
        let values = Physical::of(body, prior, &drawn).values(best.wheel[2]);
        let off: [f64; 7] = std::array::from_fn(|k| values[k] - centre[k]);
        for (row, a) in sum.iter_mut().zip(off) {
            for (entry, b) in row.iter_mut().zip(off) {
                *entry += a * b / DRAWS as f64;
            }
        }
    }
    let slots = best.model(body, farthest_wheel(prior)).slots();
    let [low, high] = body.bounds();
    let scale = |k: usize| match k {
        1 | 2 => 0.5 * (high[k - 1] - low[k - 1]),
        3 => 1.0,
        _ => centre[k],
    };
    // The spread of a damping at its lower bound does not show its uncertainty.
    let is_at_bound = |k: usize| k >= 4 && centre[k] < BOUND_RATIO * MIN_DAMPING;
    let is_identified = |k: usize| sum[k][k].sqrt() < MAX_IDENTIFIED_SD * scale(k) && !is_at_bound(k);
    let kept: Vec<usize> = (0..7).filter(|&k| is_identified(k)).collect();
    (!kept.is_empty()).then(|| Posterior {
        names: kept.iter().map(|&k| slots[k].name.clone()).collect(),
        mean: kept.iter().map(|&k| centre[k]).collect(),
        covariance: kept.iter().map(|&i| kept.iter().map(|&j| sum[i][j]).collect()).collect(),
    })
}
