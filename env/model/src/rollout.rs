//! Motion of a plant under a sampled wrench.

use crate::{Clock, Plant, State};

/// Longest step, s. The wrench is interpolated between its samples.
const MAX_STEP_S: f64 = 2e-3;

/// States at the times `t`, s, under the wrench samples `wrench` (object axes about the object origin, `[N, N, N·m]`),
/// which are interpolated linearly. `contact`: time of first contact, s.
pub fn rollout(
    plant: &Plant<f64>,
    start: State<f64>,
    t: &[f64],
    wrench: &[[f64; 3]],
    contact: f64,
) -> Vec<State<f64>> {
    let mut states = vec![start];
    let mut state = start;
    for (times, ends) in t.windows(2).zip(wrench.windows(2)) {
        let span = times[1] - times[0];
        let steps = (span / MAX_STEP_S).ceil().max(1.0);
        let dt = span / steps;
        for step in 0..steps as usize {
            let middle = (step as f64 + 0.5) / steps;
            let mean = [0, 1, 2].map(|k| ends[0][k] + middle * (ends[1][k] - ends[0][k]));
            let begin = times[0] + step as f64 * dt;
            let clock = Clock { t: begin + dt / 2.0, dt, ..Clock::since_contact(begin - contact) };
            state = plant.step(&state, mean, clock, dt);
        }
        states.push(state);
    }
    states
}
