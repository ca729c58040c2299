//! Derivatives of the whitened innovations by the parameters, with the filter's gains held.
//!
//! With its gains held, the filter is a simulation that each sample nudges: forward dual numbers
//! walk through it, eight parameters at a time. What is neglected, the gains' own dependence on
//! the parameters, has mean zero where the model is right (Ljung 1999, section 10.3).

use crate::filter::{Innovation, push};
use crate::{InferError, Linearised, Track};
use nalgebra::{DMatrix, DVector};
use trundle_model::{Dual, Model, Real, State};

/// Derivatives carried at once.
const WIDTH: usize = 8;

/// Cost of one episode with its derivatives by the slots `free`.
pub(crate) fn linearise(
    model: &Model,
    values: &[f64],
    free: &[usize],
    track: &Track,
    innovations: &[Innovation],
) -> Result<Linearised, InferError> {
    let rows = 3 * innovations.len();
    let mut jacobian = DMatrix::zeros(rows, free.len());
    for (chunk, slots) in free.chunks(WIDTH).enumerate() {
        let columns = whitened_slopes(model, values, slots, track, innovations)?;
        for (row, slopes) in columns.iter().enumerate() {
            for (k, slope) in slopes[..slots.len()].iter().enumerate() {
                jacobian[(row, chunk * WIDTH + k)] = *slope;
            }
        }
    }
    let residual = DVector::from_iterator(
        rows,
        innovations.iter().flat_map(|i| {
            let whitened = i.whitener * i.error;
            [whitened[0], whitened[1], whitened[2]]
        }),
    );
    Ok(Linearised {
        cost: innovations.iter().map(|i| i.cost).sum(),
        gradient: jacobian.tr_mul(&residual),
        curvature: jacobian.tr_mul(&jacobian),
    })
}

/// Slopes of each whitened innovation by up to [`WIDTH`] slots.
fn whitened_slopes(
    model: &Model,
    values: &[f64],
    slots: &[usize],
    track: &Track,
    innovations: &[Innovation],
) -> Result<Vec<[f64; WIDTH]>, InferError> {
    let mut lifted: Vec<Dual<WIDTH>> = values.iter().map(|&v| Real::lift(v)).collect();
    for (k, &slot) in slots.iter().enumerate() {
        lifted[slot] = Dual::variable(values[slot], k);
    }
    let plant = model.plant(&lifted)?;
    let mut state = State { pose: track.pose.0.map(Real::lift), twist: track.twist.0.map(Real::lift) };
    let mut error = [Dual::<WIDTH>::zero(); 3];
    let mut slopes = Vec::with_capacity(3 * innovations.len());
    let mut seen = innovations.iter();
    for step in &track.steps {
        state = push(&plant, &state, error, step);
        let Some(innovation) = step.pose.and_then(|_| seen.next()) else { continue };
        // d(error) = −d(pose); its value is the filter's own.
        for row in 0..3 {
            let mut slope = [0.0; WIDTH];
            for k in 0..3 {
                for (s, e) in slope.iter_mut().zip(state.pose[k].eps) {
                    *s -= innovation.whitener[(row, k)] * e;
                }
            }
            slopes.push(slope);
        }
        nudge(&mut state, &mut error, innovation);
    }
    Ok(slopes)
}

/// Apply the filter's correction, gain times innovation.
fn nudge(state: &mut State<Dual<WIDTH>>, error: &mut [Dual<WIDTH>; 3], innovation: &Innovation) {
    let slopes = state.pose.map(|p| p.eps);
    let parts = state.pose.iter_mut().chain(&mut state.twist).chain(error.iter_mut());
    for (row, value) in parts.enumerate() {
        for (k, slope) in slopes.iter().enumerate() {
            let gain = innovation.gain[(row, k)];
            value.re += gain * innovation.error[k];
            for (e, s) in value.eps.iter_mut().zip(slope) {
                *e -= gain * s;
            }
        }
    }
}
