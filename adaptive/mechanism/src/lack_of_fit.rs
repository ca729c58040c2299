//! Lack of fit: the part of a residual that a flexible regression on the joint's state predicts in left-out parts.
//!
//! Noise cannot be predicted. What a regression on position, velocity, acceleration and effort predicts is physics that
//! the model misses. The regression uses random Fourier features (Rahimi and Recht 2007) and a ridge penalty. A residual
//! that is larger than the noise of positions and efforts allows, or correlated in time, is not noise either.

use crate::drive::Drive;
use crate::fitted_model::FittedModel;
use crate::problem::Problem;
use crate::rows::noise_floor;
use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use trundle_diagnose::{
    MIN_EFFECT_PROBABILITY, MIN_MATERIAL_ERROR_RATIO, NEGLIGIBLE_SHARE, PredictedSample, PredictedSamples,
    correlation_time, probability_of_gain,
};

/// Most random features of the regression, and fewest samples for each.
const MAX_FEATURES: usize = 60;
const MIN_SAMPLES_PER_FEATURE: usize = 4;
/// Ridge penalty, as a share of the number of samples.
const RIDGE: f64 = 0.01;
/// Autocorrelation of neighbouring samples above which a residual is no white noise. Filtered noise has 0.1.
const MAX_AUTOCORRELATION: f64 = 0.5;

/// Factor of the variance that the noise of positions and efforts gives a residual, for what the estimates neglect: the
/// other joints' accelerations, and noise that is not quite white.
const NOISE_MARGIN: f64 = 4.0;

/// Reduction of the misfit, see [`explanation`], from which names can be certain. On the tuning range of the benchmark all
/// correct answers are above it, and ten of 13 wrong names below.
pub(crate) const CERTAIN_EXPLANATION: f64 = 0.5;

/// Lack of fit that is negligible, in standard deviations of the noise. Clean recordings of the benchmark's tuning range stay
/// below.
const NEGLIGIBLE_NOISES: f64 = 10.0;

/// Lack of fit of one joint.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct LackOfFit {
    /// Mean square of the residual that the regression predicts, or that is correlated in time, squared effort.
    pub mean_square: f64,
    /// Whether it is more than chance, and more than a negligible multiple of the noise or share of the effort.
    pub exceeds_noise: bool,
    /// Whether it is more than chance and more than a negligible share of the effort.
    pub is_material: bool,
}

/// Lack of fit of a joint under a model.
pub(crate) fn lack_of_fit(problem: &Problem, model: &FittedModel, joint: usize) -> LackOfFit {
    let residuals = &model.left_out.residuals[joint];
    let rows = crate::rows::evaluate(
        problem,
        &model.fit.effects,
        &model.fit.slots,
        &model.fit.values,
        crate::rows::Scope::Training,
        false,
    );
    let Some(own) = rows.iter().find(|rows| rows.joint == joint).filter(|own| !own.places.is_empty()) else {
        return LackOfFit::default();
    };
    let sd = model.fit.sd[joint];
    let limit = 4.0 * sd;
    let inputs: Vec<Vec<f64>> =
        own.places.iter().map(|p| input(problem, joint, p.episode, p.sample)).collect();
    let features = features(&inputs);
    let folds: Vec<usize> = own.places.iter().map(|place| place.fold).collect();
    // Rows are in the order of the folds within each episode, as are the left-out residuals.
    let flat: Vec<f64> = residuals.iter().flatten().map(|r| r.clamp(-limit, limit)).collect();
    let predicted = left_out_predictions(&features, &flat, &folds);
    let cost = |r: f64, sd: f64| PredictedSample {
        cost: sd.ln() + 0.5 * (r / sd).powi(2),
        residual: [r / sd, 0.0, 0.0],
    };
    let mean_square = |values: &dyn Fn(usize) -> f64| {
        (0..flat.len()).map(|k| values(k).powi(2)).sum::<f64>() / flat.len().max(1) as f64
    };
    let before = mean_square(&|k| flat[k]);
    let after = mean_square(&|k| flat[k] - predicted[k]);
    let count = folds.iter().max().map_or(0, |most| most + 1);
    let by_fold = |value: &dyn Fn(usize) -> f64, sd: f64| -> PredictedSamples {
        let of =
            |fold: usize| (0..flat.len()).filter(|k| folds[*k] == fold).map(|k| cost(value(k), sd)).collect();
        (0..count).map(of).collect()
    };
    let without = by_fold(&|k| flat[k], before.sqrt().max(f64::MIN_POSITIVE));
    let with = by_fold(&|k| flat[k] - predicted[k], after.sqrt().max(f64::MIN_POSITIVE));
    let time = correlation_time(&with).max(1.0);
    let is_predicted = probability_of_gain(time, &with, &without) >= MIN_EFFECT_PROBABILITY
        && before >= MIN_MATERIAL_ERROR_RATIO * after;
    let correlation = autocorrelation(residuals);
    let correlated = if correlation > MAX_AUTOCORRELATION { before * correlation } else { 0.0 };
    let [readings, accelerations] = problem.joints[joint].sensor_noise;
    let size = own.per_effort.iter().map(|x| x * x).sum::<f64>() / own.per_effort.len() as f64;
    let excess = before - NOISE_MARGIN * (readings * readings + size * accelerations * accelerations);
    let found = correlated.max(excess).max(if is_predicted { before - after } else { 0.0 });
    let share = NEGLIGIBLE_SHARE.sqrt() * problem.joints[joint].scales.effort;
    let noise = share.min(NEGLIGIBLE_NOISES * noise_floor(problem, joint));
    LackOfFit { mean_square: found, exceeds_noise: found > noise * noise, is_material: found > share * share }
}

/// How far a model reduces a misfit towards the noise: 0 not at all, 1 to the noise; logarithmic.
pub(crate) fn explanation([before, after]: [f64; 2], floor: f64) -> f64 {
    let possible = (before / floor).ln();
    if possible > 0.0 { ((before / after).ln() / possible).clamp(0.0, 1.0) } else { 1.0 }
}

/// Whether a reduction of a misfit may be one of noise: the misfit is within the uncertainty of the noise, and a good part of
/// it remains.
pub(crate) fn may_be_noise([before, after]: [f64; 2], floor: f64) -> bool {
    !exceeds_noise(before, floor) && explanation([before, after], floor) < CERTAIN_EXPLANATION
}

/// Whether a misfit exceeds the uncertainty of the noise.
pub(crate) fn exceeds_noise(misfit: f64, floor: f64) -> bool {
    misfit * misfit >= NOISE_MARGIN * floor * floor
}

/// State of a joint in units of its scales.
fn input(problem: &Problem, joint: usize, episode: usize, k: usize) -> Vec<f64> {
    let (setup, series) = (&problem.joints[joint], &problem.episodes[episode].joints[joint]);
    let scales = &setup.scales;
    let middle = f64::midpoint(scales.range[0], scales.range[1]);
    let drive = match setup.drive {
        Drive::None => 0.0,
        drive => series.command_error(drive, k),
    };
    let size = setup.largest_command / 2.0;
    let needed = problem.episodes[episode].dynamics.as_ref().map(|dynamics| dynamics.effort[joint][k]);
    let mut found = vec![
        4.0 * (series.q[k] - middle) / scales.span(),
        series.v[k] / scales.velocity,
        (4.0 * series.v[k] / scales.velocity).tanh(),
        series.a[k] / scales.acceleration.max(f64::MIN_POSITIVE),
        drive / size.max(f64::MIN_POSITIVE),
    ];
    found.extend(needed.map(|effort| effort / scales.effort));
    found
}

fn features(inputs: &[Vec<f64>]) -> DMatrix<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(0);
    let width = inputs.first().map_or(0, Vec::len);
    let count = (inputs.len() / MIN_SAMPLES_PER_FEATURE).min(MAX_FEATURES);
    let normal = |rng: &mut ChaCha8Rng| (0..12).map(|_| rng.random_range(-0.5..0.5)).sum::<f64>();
    let directions: Vec<(Vec<f64>, f64)> = (0..count)
        .map(|_| {
            let direction = (0..width).map(|_| normal(&mut rng)).collect();
            (direction, rng.random_range(0.0..std::f64::consts::TAU))
        })
        .collect();
    DMatrix::from_fn(inputs.len(), count + width, |row, column| {
        if let Some((direction, phase)) = directions.get(column) {
            (direction.iter().zip(&inputs[row]).map(|(a, b)| a * b).sum::<f64>() + phase).cos()
        } else {
            inputs[row][column - count]
        }
    })
}

fn left_out_predictions(features: &DMatrix<f64>, values: &[f64], folds: &[usize]) -> Vec<f64> {
    let mut predicted = vec![0.0; values.len()];
    let targets = DVector::from_column_slice(values);
    let count = folds.iter().max().map_or(0, |most| most + 1);
    for fold in 0..count {
        let mut training = features.clone();
        let mut wanted = targets.clone();
        for row in (0..values.len()).filter(|row| folds[*row] == fold) {
            training.row_mut(row).fill(0.0);
            wanted[row] = 0.0;
        }
        let mut matrix = training.tr_mul(&training);
        for k in 0..matrix.ncols() {
            matrix[(k, k)] += RIDGE * values.len() as f64;
        }
        let Some(weights) = matrix.cholesky().map(|c| c.solve(&training.tr_mul(&wanted))) else { continue };
        for row in (0..values.len()).filter(|row| folds[*row] == fold) {
            predicted[row] = features.row(row).transpose().dot(&weights);
        }
    }
    predicted
}

/// Correlation of neighbouring samples.
fn autocorrelation(folds: &[Vec<f64>]) -> f64 {
    let product = |lag: usize| -> f64 {
        folds.iter().flat_map(|fold| fold.iter().zip(fold.iter().skip(lag))).map(|(a, b)| a * b).sum()
    };
    let variance = product(0);
    if variance > 0.0 { product(1) / variance } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::may_be_noise;

    #[test]
    fn small_misfits_must_be_explained_to_the_noise() {
        // A large misfit needs no such proof; of one below twice the noise, half of the excess must go.
        for (before, after, expected) in [(1.5, 1.4, true), (1.5, 1.1, false), (2.5, 2.4, false)] {
            assert_eq!(may_be_noise([before, after], 1.0), expected, "{before} {after}");
        }
    }
}
