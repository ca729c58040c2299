//! What an unnamed wrench may depend on, along the training episodes.

use trundle_infer::{Fit, InferError, MotionLikelihood, Residual, Response, Track};
use trundle_model::{Axes, Discrepancy, Input, to_body, transport};

/// Centres, at most.
const CENTRES: usize = 60;
/// Distance from all others, in lengths over which the wrench changes, below which a place is no centre.
const NEAR: f64 = 0.25;
/// Of the steps seen, every so many may be a centre.
const THINNED: usize = 4;

/// A training episode, seen and as a linear system.
pub(super) struct Episode {
    /// What a wrench does to the innovations.
    pub response: Response,
    track: Track,
    seen: Vec<Residual>,
}

/// All training episodes.
pub(super) struct Course {
    pub episodes: Vec<Episode>,
    /// What makes a force of a moment, m.
    pub arm: f64,
    /// Root mean square of the missing wrench, a moment as a force at `arm`, N.
    pub size: f64,
}

impl Course {
    /// Under noise that lets the missing wrench wander; `None` where the fit cannot be evaluated.
    ///
    /// # Errors
    /// When the fit's values do not suit its model.
    pub fn new(motion: &MotionLikelihood, fit: &Fit) -> Result<Option<Self>, InferError> {
        let (model, values) = (&fit.model, &fit.values);
        let Some(responses) = motion.responses(model, values)? else { return Ok(None) };
        let Some(seen) = motion.residuals(model, values)? else { return Ok(None) };
        let parts = responses.into_iter().zip(seen).zip(motion.tracks());
        let episodes: Vec<_> =
            parts.map(|((response, seen), track)| Episode { response, track: track.clone(), seen }).collect();
        let arm = model.body.gyration.max(1e-3);
        let square = |[x, y, torque]: [f64; 3]| (x * x + y * y + (torque / arm).powi(2)) / 3.0;
        let squares: Vec<f64> =
            episodes.iter().flat_map(|e| &e.seen).map(|seen| square(seen.wrench)).collect();
        let size = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
        Ok((size.is_finite() && size > 0.0).then_some(Self { episodes, arm, size }))
    }

    /// An unnamed wrench of no size, its centres spread over what was seen, its lengths `width` standard deviations of
    /// that in each of its numbers (and more the more numbers there are).
    pub fn blank(&self, inputs: &[Input], axes: Axes, width: f64) -> Discrepancy {
        let mut blank =
            Discrepancy { inputs: inputs.to_vec(), axes, scales: vec![], centres: vec![], weights: vec![] };
        let thinned =
            |e: &Episode| e.inputs(&blank).into_iter().step_by(THINNED).flatten().collect::<Vec<_>>();
        let seen: Vec<Vec<f64>> = self.episodes.iter().flat_map(thinned).collect();
        let longer = width * (blank.width() as f64).sqrt();
        blank.scales = (0..blank.width()).map(|k| scale(&seen, k, longer)).collect();
        blank.centres = spread(&seen, &blank.scales);
        blank.weights = vec![[0.0; 3]; blank.centres.len()];
        blank
    }
}

impl Episode {
    /// Inputs at each step; `None` before contact.
    pub fn inputs(&self, of: &Discrepancy) -> Vec<Option<Vec<f64>>> {
        let at = |k: usize| {
            let (step, seen) = (&self.track.steps[k], &self.seen[k]);
            step.clock.in_contact().then(|| of.inputs_at(seen.pose, seen.twist, step.reading, step.clock))
        };
        (0..self.track.steps.len().min(self.seen.len())).map(at).collect()
    }

    /// A wrench in the axes of an unnamed one at a step, as one on the object: object axes about the object origin.
    pub fn on_object(&self, axes: Axes, step: usize, wrench: [f64; 3]) -> [f64; 3] {
        match axes {
            Axes::Object => wrench,
            Axes::World => to_body(wrench, self.seen[step].pose[2]),
            Axes::Reading => transport(wrench, self.track.steps[step].frame),
        }
    }
}

/// So many standard deviations of one number; of one that never changes, its unit.
fn scale(seen: &[Vec<f64>], k: usize, width: f64) -> f64 {
    let n = seen.len() as f64;
    let mean = seen.iter().map(|z| z[k]).sum::<f64>() / n;
    let variance = seen.iter().map(|z| (z[k] - mean).powi(2)).sum::<f64>() / n;
    if variance > 1e-18 { width * variance.sqrt() } else { 1.0 }
}

/// Places far from one another, each the farthest from those before.
fn spread(seen: &[Vec<f64>], scales: &[f64]) -> Vec<Vec<f64>> {
    let square = |a: &[f64], b: &[f64]| -> f64 {
        a.iter().zip(b).zip(scales).map(|((a, b), scale)| ((a - b) / scale).powi(2)).sum()
    };
    let mut nearest = vec![f64::INFINITY; seen.len()];
    let mut centres: Vec<Vec<f64>> = vec![];
    while centres.len() < CENTRES {
        let farthest = (0..seen.len()).max_by(|&a, &b| nearest[a].total_cmp(&nearest[b]));
        let Some(next) = farthest.filter(|&k| nearest[k] > NEAR * NEAR) else { break };
        for (nearest, z) in nearest.iter_mut().zip(seen) {
            *nearest = nearest.min(square(z, &seen[next]));
        }
        centres.push(seen[next].clone());
    }
    centres
}
