//! Response of one axis of an arm to its command.

/// How the wrench along one axis follows the command.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum AxisResponse {
    /// The wrench is the command.
    #[default]
    Exact,
    /// A first-order lag, `τ ẇ = c − w`.
    Lag {
        /// Time constant τ, s.
        time_constant: f64,
    },
    /// A hand that holds the object through a spring and damper: `ë = g c − w`, `w = ω² e + 2ζω ė`. The gain g is below 1
    /// because a part of the command accelerates the hand: with masses m of the hand and M of a free object at the grasp,
    /// `g = M/(M + m)`.
    Compliant {
        /// Natural frequency ω, rad/s.
        frequency: f64,
        /// Damping ratio ζ.
        damping_ratio: f64,
        /// Gain g.
        gain: f64,
    },
}

impl AxisResponse {
    /// Whether the axis yields.
    pub(crate) fn is_compliant(&self) -> bool {
        matches!(self, Self::Compliant { .. })
    }

    /// Wrench of a state.
    pub(crate) fn wrench(&self, [a, b]: [f64; 2]) -> f64 {
        match *self {
            Self::Exact | Self::Lag { .. } => a,
            Self::Compliant { frequency, damping_ratio, .. } => {
                frequency * (frequency * a + 2.0 * damping_ratio * b)
            }
        }
    }

    /// The state that is nearest to `state` and exerts `wrench`.
    pub(crate) fn corrected(&self, state: [f64; 2], wrench: f64) -> [f64; 2] {
        match *self {
            Self::Exact | Self::Lag { .. } => [wrench, 0.0],
            Self::Compliant { frequency, .. } => {
                [state[0] + (wrench - self.wrench(state)) / (frequency * frequency), state[1]]
            }
        }
    }

    /// The exact step of length `dt`, s, under a constant command.
    pub(crate) fn discretised(&self, dt: f64) -> AxisStep {
        let (matrix, input, mean, gain) = match *self {
            Self::Exact => ([[0.0; 2]; 2], [1.0, 0.0], [0.0; 2], 1.0),
            Self::Lag { time_constant } => {
                let keep = (-dt / time_constant).exp();
                ([[keep, 0.0], [0.0; 2]], [1.0 - keep, 0.0], [time_constant / dt, 0.0], 1.0)
            }
            Self::Compliant { frequency, damping_ratio, gain } => {
                let drag = 2.0 * damping_ratio * frequency;
                let stiffness = frequency * frequency;
                let matrix = exponential([[0.0, dt], [-stiffness * dt, -drag * dt]]);
                // K⁻¹ (exp(K dt) − 1) (0, 1).
                let input = [(-drag * matrix[0][1] - matrix[1][1] + 1.0) / stiffness, matrix[0][1]];
                (matrix, input.map(|entry| gain * entry), [0.0, dt.recip()], gain)
            }
        };
        AxisStep { matrix, input, mean, gain }
    }
}

/// Step of an axis: `s' = A s + b c`. The mean wrench over the step is `g c − m·(s' − s)`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AxisStep {
    matrix: [[f64; 2]; 2],
    input: [f64; 2],
    mean: [f64; 2],
    gain: f64,
}

impl AxisStep {
    /// Advance a state. Returns the mean wrench over the step.
    #[inline]
    pub(crate) fn advance(&self, state: &mut [f64; 2], command: f64) -> f64 {
        let next = [0, 1]
            .map(|k| self.matrix[k][0] * state[0] + self.matrix[k][1] * state[1] + self.input[k] * command);
        let mean =
            self.gain * command - self.mean[0] * (next[0] - state[0]) - self.mean[1] * (next[1] - state[1]);
        *state = next;
        mean
    }
}

/// Number of terms of the series in [`exponential`]. With a norm of at most a half, the remainder is below 1e-15.
const SERIES_TERMS: u32 = 14;

/// Exponential of a matrix by scaling and squaring.
fn exponential(matrix: [[f64; 2]; 2]) -> [[f64; 2]; 2] {
    let norm = matrix.iter().flatten().fold(0.0, |sum: f64, entry| sum + entry.abs());
    let halvings = if norm > 0.5 { (norm / 0.5).log2().ceil() as i32 } else { 0 };
    let scaled = matrix.map(|row| row.map(|entry| entry / 2f64.powi(halvings)));
    let mut term = [[1.0, 0.0], [0.0, 1.0]];
    let mut sum = term;
    for k in 1..=SERIES_TERMS {
        term = product(term, scaled).map(|row| row.map(|entry| entry / f64::from(k)));
        sum = [0, 1].map(|i| [0, 1].map(|j| sum[i][j] + term[i][j]));
    }
    (0..halvings).fold(sum, |power, _| product(power, power))
}

fn product(a: [[f64; 2]; 2], b: [[f64; 2]; 2]) -> [[f64; 2]; 2] {
    [0, 1].map(|i| [0, 1].map(|j| a[i][0] * b[0][j] + a[i][1] * b[1][j]))
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [AxisResponse; 4] = [
        AxisResponse::Exact,
        AxisResponse::Lag { time_constant: 0.08 },
        AxisResponse::Compliant { frequency: 31.6, damping_ratio: 0.47, gain: 1.0 },
        AxisResponse::Compliant { frequency: 20.0, damping_ratio: 1.0, gain: 0.8 },
    ];

    #[test]
    fn one_long_step_equals_many_short_ones() {
        for response in ALL {
            let (long, short) = (response.discretised(0.05), response.discretised(0.0005));
            let (mut at_once, mut in_parts) = ([0.1, -0.2], [0.1, -0.2]);
            let mean = long.advance(&mut at_once, 30.0);
            let parts: f64 = (0..100).map(|_| short.advance(&mut in_parts, 30.0)).sum::<f64>() / 100.0;
            assert!((mean - parts).abs() < 1e-9, "{response:?}: {mean} {parts}");
            assert!((0..2).all(|k| (at_once[k] - in_parts[k]).abs() < 1e-9), "{response:?}");
        }
    }

    #[test]
    fn the_mean_is_that_of_the_wrench_and_the_wrench_tends_to_the_command() {
        for response in ALL {
            let short = response.discretised(1e-4);
            let mut state = [0.0; 2];
            let (mut sum, mut before) = (0.0, 0.0);
            let mean: f64 = (0..20_000)
                .map(|_| {
                    let mean = short.advance(&mut state, 10.0);
                    let after = response.wrench(state);
                    sum += if response == AxisResponse::Exact { after } else { (before + after) / 2.0 };
                    before = after;
                    mean
                })
                .sum();
            assert!((mean - sum).abs() < 1e-3 * mean, "{response:?}: {mean} {sum}");
            assert!((before - 10.0 * short.gain).abs() < 1e-6, "{response:?}: {before}");
        }
    }

    #[test]
    fn a_lag_reaches_63_percent_after_its_time_constant() {
        let lag = AxisResponse::Lag { time_constant: 0.08 };
        let mut state = [0.0; 2];
        lag.discretised(0.08).advance(&mut state, 1.0);
        assert!((lag.wrench(state) - (1.0 - (-1.0f64).exp())).abs() < 1e-12);
    }

    #[test]
    fn a_corrected_state_exerts_the_given_wrench() {
        for response in ALL {
            assert!((response.wrench(response.corrected([0.3, 0.1], 7.0)) - 7.0).abs() < 1e-12);
        }
    }
}
