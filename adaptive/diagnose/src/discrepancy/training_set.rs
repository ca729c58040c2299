//! Inputs of a discrepancy wrench along the training episodes.

use trundle_infer::{Fit, InferError, MotionLikelihood, Residual, Response, Track};
use trundle_model::{Axes, Discrepancy, Input, to_body, transport};

/// Maximum number of kernel centres.
const MAX_CENTRES: usize = 60;
/// Minimum distance between centres, in length scales.
const MIN_CENTRE_DISTANCE: f64 = 0.25;
/// Every so many steps, one is a candidate for a centre.
const CANDIDATE_STRIDE: usize = 4;

/// A training episode: its steps, its smoothed residual wrench, and its linear response.
pub(super) struct Episode {
    /// Response of the innovations to a wrench.
    pub response: Response,
    track: Track,
    residuals: Vec<Residual>,
}

/// All training episodes.
pub(super) struct TrainingSet {
    pub episodes: Vec<Episode>,
    /// Lever arm that converts a moment into a force, m.
    pub arm: f64,
    /// Root mean square of the residual wrench, N; moments count as forces at `arm`.
    pub size: f64,
}

impl TrainingSet {
    /// Linearises all episodes at a fit. The noise of `motion` includes a random-walk wrench. `None` if the fit
    /// cannot be evaluated.
    ///
    /// # Errors
    /// If the fit's values do not suit its model.
    pub fn new(motion: &MotionLikelihood, fit: &Fit) -> Result<Option<Self>, InferError> {
        let (model, values) = (&fit.model, &fit.values);
        let Some(responses) = motion.responses(model, values)? else { return Ok(None) };
        let Some(residuals) = motion.residuals(model, values)? else { return Ok(None) };
        let parts = responses.into_iter().zip(residuals).zip(motion.tracks());
        let episodes: Vec<_> = parts
            .map(|((response, residuals), track)| Episode { response, track: track.clone(), residuals })
            .collect();
        let arm = model.body.gyration.max(1e-3);
        let square = |[x, y, torque]: [f64; 3]| (x * x + y * y + (torque / arm).powi(2)) / 3.0;
        let squares: Vec<f64> =
            episodes.iter().flat_map(|e| &e.residuals).map(|residual| square(residual.wrench)).collect();
        let size = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
        Ok((size.is_finite() && size > 0.0).then_some(Self { episodes, arm, size }))
    }

    /// A discrepancy wrench with zero weights. Its centres cover the training inputs. Its length scales are `width`
    /// standard deviations of each input, times the square root of the number of inputs.
    pub fn unweighted(&self, kinds: &[Input], axes: Axes, width: f64) -> Discrepancy {
        let mut unweighted =
            Discrepancy { inputs: kinds.to_vec(), axes, scales: vec![], centres: vec![], weights: vec![] };
        let thinned = |e: &Episode| {
            e.inputs(&unweighted).into_iter().step_by(CANDIDATE_STRIDE).flatten().collect::<Vec<_>>()
        };
        let inputs: Vec<Vec<f64>> = self.episodes.iter().flat_map(thinned).collect();
        let widths = width * (unweighted.width() as f64).sqrt();
        unweighted.scales = (0..unweighted.width()).map(|k| scale(&inputs, k, widths)).collect();
        unweighted.centres = farthest_points(&inputs, &unweighted.scales);
        unweighted.weights = vec![[0.0; 3]; unweighted.centres.len()];
        unweighted
    }
}

impl Episode {
    /// Inputs at each step; `None` before contact.
    pub fn inputs(&self, of: &Discrepancy) -> Vec<Option<Vec<f64>>> {
        let at = |k: usize| {
            let (step, residual) = (&self.track.steps[k], &self.residuals[k]);
            step.clock
                .in_contact()
                .then(|| of.inputs_at(residual.pose, residual.twist, step.reading, step.clock))
        };
        (0..self.track.steps.len().min(self.residuals.len())).map(at).collect()
    }

    /// Transforms a wrench at a step from the axes of the discrepancy to object axes about the object origin.
    pub fn on_object(&self, axes: Axes, step: usize, wrench: [f64; 3]) -> [f64; 3] {
        match axes {
            Axes::Object => wrench,
            Axes::World => to_body(wrench, self.residuals[step].pose[2]),
            Axes::Reading => transport(wrench, self.track.steps[step].frame),
        }
    }
}

/// `width` standard deviations of one input; 1 if it is constant.
fn scale(inputs: &[Vec<f64>], k: usize, width: f64) -> f64 {
    let n = inputs.len() as f64;
    let mean = inputs.iter().map(|z| z[k]).sum::<f64>() / n;
    let variance = inputs.iter().map(|z| (z[k] - mean).powi(2)).sum::<f64>() / n;
    if variance > 1e-18 { width * variance.sqrt() } else { 1.0 }
}

/// Centres by farthest-point sampling.
fn farthest_points(inputs: &[Vec<f64>], scales: &[f64]) -> Vec<Vec<f64>> {
    let square = |a: &[f64], b: &[f64]| -> f64 {
        a.iter().zip(b).zip(scales).map(|((a, b), scale)| ((a - b) / scale).powi(2)).sum()
    };
    let mut nearest = vec![f64::INFINITY; inputs.len()];
    let mut centres: Vec<Vec<f64>> = vec![];
    while centres.len() < MAX_CENTRES {
        let farthest = (0..inputs.len()).max_by(|&a, &b| nearest[a].total_cmp(&nearest[b]));
        let Some(next) = farthest.filter(|&k| nearest[k] > MIN_CENTRE_DISTANCE * MIN_CENTRE_DISTANCE) else {
            break;
        };
        for (nearest, z) in nearest.iter_mut().zip(inputs) {
            *nearest = nearest.min(square(z, &inputs[next]));
        }
        centres.push(inputs[next].clone());
    }
    centres
}
