//! Scatter of measured around simulated states: σ of eq. 6.

use crate::{StateVector, Transition};
use trundle_model::{Prior, Slot};
use trundle_record::{Motion, Noise};

/// Standard deviation of each kind of channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scatter {
    /// Of x and y, m.
    pub position: f64,
    /// Of θ, rad.
    pub heading: f64,
    /// Of the velocity of the origin, m/s.
    pub velocity: f64,
    /// Of the spin, rad/s.
    pub spin: f64,
}

/// Prior knowledge of the scatter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Sigma {
    /// A fixed value.
    Known(Scatter),
    /// Log-normal about this median.
    Unknown { median: Scatter, spread: f64 },
}

/// Prior standard deviation of the logarithm of an unknown scatter: 95 % within a factor of seven of the
/// median. This prior keeps σ from zero where a few residuals can be fitted exactly.
pub(crate) const LOG_SCATTER_SD: f64 = 1.0;

/// Prior median of the scatter relative to the tracker noise, because noisy forces drive the simulation.
const SCATTER_PER_POSE_NOISE: f64 = 4.0;

/// Prior median of the scatter relative to the typical change of a channel.
const SCATTER_PER_CHANGE: f64 = 0.1;

const NAMES: [(&str, &str); 4] =
    [("noise.position", "m"), ("noise.heading", "rad"), ("noise.velocity", "m/s"), ("noise.spin", "rad/s")];

impl Scatter {
    pub(crate) fn array(self) -> [f64; 4] {
        [self.position, self.heading, self.velocity, self.spin]
    }

    fn from_array([position, heading, velocity, spin]: [f64; 4]) -> Self {
        Self { position, heading, velocity, spin }
    }

    /// Prior medians from the noise of the poses and the uncertainty of the smoothed twists.
    pub(crate) fn from_noise<'a>(noise: &Noise, motion: impl Iterator<Item = &'a Motion>) -> Self {
        let (mut variance, mut count) = ([0.0; 3], 0.0);
        for m in motion {
            variance = [0, 1, 2].map(|k| variance[k] + m.cov[k][1][1]);
            count += 1.0;
        }
        let twist = variance.map(|v| if count > 0.0 { (v / count).sqrt() } else { 0.01 });
        let [x, y, theta] = noise.pose;
        Self::from_array(
            [x.max(y), theta, twist[0].max(twist[1]), twist[2]]
                .map(|s| (SCATTER_PER_POSE_NOISE * s).max(1e-9)),
        )
    }

    /// Prior medians from the changes of the channels in these transitions.
    pub(crate) fn from_changes(data: &[Transition]) -> Self {
        let square = |channels: &[usize]| {
            let of =
                |t: &Transition| channels.iter().map(|&k| (t.after[k] - t.before[k]).powi(2)).sum::<f64>();
            let n = (channels.len() * data.len()).max(1) as f64;
            (data.iter().map(of).sum::<f64>() / n).sqrt()
        };
        let changes = [square(&[0, 1]), square(&[2]), square(&[3, 4]), square(&[5])];
        Self::from_array(changes.map(|c| if c > 0.0 { SCATTER_PER_CHANGE * c } else { 1e-6 }))
    }
}

/// Kind of scatter of a channel of [`StateVector`].
pub(crate) fn kind(channel: usize) -> usize {
    [0, 0, 1, 2, 2, 3][channel]
}

/// Slots of the given kinds.
pub(crate) fn slots(sigma: Sigma, kinds: &[usize]) -> Vec<Slot> {
    let one = |&k: &usize| {
        let (name, unit) = NAMES[k];
        let (median, spread, value) = match sigma {
            Sigma::Known(s) => (s.array()[k], LOG_SCATTER_SD, Some(s.array()[k])),
            Sigma::Unknown { median, spread } => (median.array()[k], spread, None),
        };
        Slot {
            name: name.to_owned(),
            unit,
            lower: 1e-12,
            upper: 1e6,
            prior: Prior::LogNormal { median, sd: spread },
            value,
            effect: None,
        }
    };
    kinds.iter().map(one).collect()
}

/// Measured minus simulated value; headings are wrapped.
pub(crate) fn difference(seen: &StateVector, simulated: &StateVector, channel: usize) -> f64 {
    let d = seen[channel] - simulated[channel];
    if channel == 2 { crate::error_metrics::wrap(d) } else { d }
}
