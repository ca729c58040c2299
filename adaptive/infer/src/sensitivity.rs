//! Derivatives of the whitened innovations by the parameters, with the filter's gains fixed.
//!
//! With fixed gains, the filter is a simulation with a correction at each pose sample. Forward-mode dual
//! numbers propagate through it, up to eight parameters at a time. The neglected dependence of the gains on
//! the parameters has mean zero under the correct model (Ljung 1999, section 10.3).

use crate::filter::{FilterRun, Innovation, advance};
use crate::{InferError, Linearised, Track};
use nalgebra::{DMatrix, DMatrixViewMut, DVector, Vector3};
use trundle_model::{Dual, Model, Real, State};

/// Maximum number of derivatives propagated at once.
const MAX_DUALS: usize = 8;

/// Cost of one episode with its derivatives by the slots `free`.
pub(crate) fn linearise(
    model: &Model,
    values: &[f64],
    free: &[usize],
    track: &Track,
    run: &FilterRun,
) -> Result<Linearised, InferError> {
    let jacobian = slopes(model, values, free, track, run)?;
    let residual = whitened(run);
    Ok(Linearised {
        cost: run.innovations.iter().map(|i| i.cost).sum(),
        gradient: jacobian.tr_mul(&residual),
        curvature: jacobian.tr_mul(&jacobian),
    })
}

/// Whitened innovations of an episode in order.
pub(crate) fn whitened(run: &FilterRun) -> DVector<f64> {
    let each = run.innovations.iter().flat_map(|i| {
        let whitened = i.whitener * i.error;
        [whitened[0], whitened[1], whitened[2]]
    });
    DVector::from_iterator(3 * run.innovations.len(), each)
}

/// Derivatives of the whitened innovations by the slots `free`, one column for each slot.
pub(crate) fn slopes(
    model: &Model,
    values: &[f64],
    free: &[usize],
    track: &Track,
    run: &FilterRun,
) -> Result<DMatrix<f64>, InferError> {
    let mut jacobian = DMatrix::zeros(3 * run.innovations.len(), free.len());
    for (chunk, slots) in free.chunks(MAX_DUALS).enumerate() {
        let mut columns = jacobian.columns_mut(chunk * MAX_DUALS, slots.len());
        match slots.len() {
            0..=4 => whitened_slopes::<4>(model, values, slots, track, run, &mut columns)?,
            5 | 6 => whitened_slopes::<6>(model, values, slots, track, run, &mut columns)?,
            _ => whitened_slopes::<MAX_DUALS>(model, values, slots, track, run, &mut columns)?,
        }
    }
    Ok(jacobian)
}

/// Derivatives of each whitened innovation by up to `W` slots, written to their columns.
fn whitened_slopes<const W: usize>(
    model: &Model,
    values: &[f64],
    slots: &[usize],
    track: &Track,
    run: &FilterRun,
    columns: &mut DMatrixViewMut<'_, f64>,
) -> Result<(), InferError> {
    let mut lifted: Vec<Dual<W>> = values.iter().map(|&v| Real::lift(v)).collect();
    for (k, &slot) in slots.iter().enumerate() {
        lifted[slot] = Dual::variable(values[slot], k);
    }
    let plant = model.plant(&lifted)?;
    let start = State::moving(track.pose.0.map(Real::lift), track.twist.0.map(Real::lift));
    let mut state = start.with_inner(run.inner);
    let mut error = [Dual::<W>::zero(); 3];
    let mut seen = run.innovations.iter().enumerate();
    for step in &track.steps {
        advance(&plant, &mut state, &error, step, &track.curve);
        let Some((index, innovation)) = step.pose.and_then(|_| seen.next()) else { continue };
        // d(error) = −d(pose); the value is the filter's own.
        for (column, _) in slots.iter().enumerate() {
            let slope = Vector3::from([0, 1, 2].map(|k| state.pose[k].eps[column]));
            columns.fixed_view_mut::<3, 1>(3 * index, column).copy_from(&-(innovation.whitener * slope));
        }
        correct(&mut state, &mut error, innovation);
    }
    Ok(())
}

/// Applies the filter's correction: gain times innovation.
fn correct<const W: usize>(state: &mut State<Dual<W>>, error: &mut [Dual<W>; 3], innovation: &Innovation) {
    let slopes = state.pose.map(|p| p.eps);
    let parts = state.pose.iter_mut().chain(&mut state.twist).chain(error.iter_mut()).chain(&mut state.inner);
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

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::Coordinates;
    use crate::covariance::STATES;
    use nalgebra::{Matrix3, SMatrix};
    use trundle_model::{Body, Effect, Kind};
    use trundle_record::{Counts, Noise, PoseSample, Prepared, WrenchSample};

    pub(crate) const NOISE: Noise =
        Noise { pose: [1e-3; 3], force: 0.4, torque: 0.05, time: 0.0, stated: true };

    /// One second of a push of a turning table.
    pub(crate) fn track() -> Track {
        let wrench = |k: usize| {
            let t = k as f64 * 0.01;
            let reading = [20.0 * (3.0 * t).sin(), 9.0 * (5.0 * t).cos(), (4.0 * t).sin()];
            WrenchSample { t, reading, frame: [-0.6, 0.1, 0.2], ..Default::default() }
        };
        let pose =
            |k: usize| PoseSample { t: 0.02 * k as f64, pose: [0.01 * k as f64, 0.0, 0.02 * k as f64] };
        let episode = Prepared {
            name: "push".to_owned(),
            ordinal: 0,
            wrench: (0..100).map(wrench).collect(),
            pose: (0..50).map(pose).collect(),
            contact: 0.0,
            tare_sd: [0.04; 3],
            at_rest: true,
            counts: Counts::default(),
            ..Default::default()
        };
        Track::new(&episode, &NOISE).unwrap()
    }

    /// Errors of the simulation that is corrected with the innovations' gains.
    fn errors(model: &Model, values: &[f64], track: &Track, innovations: &[Innovation]) -> Vec<Vector3<f64>> {
        let plant = model.plant(values).unwrap();
        let mut state = State::moving(track.pose.0, track.twist.0);
        let mut reading = [0.0; 3];
        let mut seen = innovations.iter();
        let mut errors = Vec::new();
        for step in &track.steps {
            advance(&plant, &mut state, &reading, step, &track.curve);
            let (Some(pose), Some(innovation)) = (step.pose, step.pose.and_then(|_| seen.next())) else {
                continue;
            };
            let error = Vector3::from(pose) - Vector3::from(state.pose);
            let parts = state.pose.iter_mut().chain(&mut state.twist).chain(reading.iter_mut());
            for (value, correct) in parts.zip((innovation.gain * error).iter()) {
                *value += correct;
            }
            errors.push(error);
        }
        errors
    }

    pub(crate) fn nominal() -> Model {
        let body = Body::from_footprint(&[[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]], 22.0);
        Model::nominal(body.unwrap(), None, [true; 3])
    }

    #[test]
    fn slopes_match_the_corrected_simulation() {
        let model = nominal().with(Effect::free(Kind::CoulombFriction)).with(Effect::free(Kind::ForceBias));
        let coordinates = Coordinates::new(&model);
        let z = [0.1, -0.9, 0.4, 0.3, 0.2, 0.9, 0.5, -0.5, -0.3, 0.2, -0.1, 0.3];
        check(&model, &coordinates.values(&z).0);
    }

    /// A model with the wheel of the other tests and further effects, and its values.
    fn with_wheel(effects: &[(Kind, &[f64])]) -> (Model, Vec<f64>) {
        let wheel = [-0.3, 0.1, 0.3, 18.0, 90.0];
        let values = std::iter::once(22.0).chain(wheel);
        let own = effects.iter().flat_map(|(_, values)| values.iter().copied());
        let model = effects.iter().fold(nominal(), |model, (kind, _)| model.with(Effect::free(*kind)));
        (model, values.chain(own).collect())
    }

    #[test]
    fn slopes_by_a_delay_and_event_times_are_correct() {
        // Both events lie within a step.
        let (model, values) = with_wheel(&[
            (Kind::Latency, &[0.043]),
            (Kind::MassChange, &[0.0, 0.3137, 6.0]),
            (Kind::WheelEvent, &[0.0, 0.5171, 4.0, 0.3]),
        ]);
        check(&model, &values);
    }

    #[test]
    fn slopes_by_inertia_and_instruments_are_correct() {
        let (model, values) = with_wheel(&[
            (Kind::ComOffset, &[0.13, -0.07]),
            (Kind::MassSpread, &[1.3]),
            (Kind::GripperInertia, &[1.7]),
            (Kind::ForceScale, &[1.0, 1.2, 0.8]),
            (Kind::TrackerOffset, &[0.05, -0.03, 0.2]),
        ]);
        check(&model, &values);
    }

    fn check(model: &Model, values: &[f64]) {
        let track = track();
        let coordinates = Coordinates::new(model);
        let gain = SMatrix::<f64, STATES, 3>::from_fn(|i, j| 0.05 * ((3 * i + j) as f64).sin());
        let whitener = Matrix3::new(3.0, 0.0, 0.0, 1.0, 2.0, 0.0, -1.0, 0.5, 4.0);
        let blank = Innovation {
            t: 0.0,
            error: Vector3::zeros(),
            covariance: Matrix3::identity(),
            gain,
            whitener,
            cost: 0.0,
        };
        let mut innovations = vec![blank; track.observations()];
        let seen = errors(model, values, &track, &innovations);
        for (innovation, error) in innovations.iter_mut().zip(seen) {
            innovation.error = error;
        }
        let run = FilterRun { innovations, inner: [0.0; 5] };
        let at = linearise(model, values, coordinates.free(), &track, &run).unwrap();
        for (k, &slot) in coordinates.free().iter().enumerate() {
            let h = 1e-6 * values[slot].abs().max(0.1);
            let misfit = |sign: f64| {
                let mut moved = values.to_vec();
                moved[slot] += sign * h;
                let errors = errors(model, &moved, &track, &run.innovations);
                errors.iter().map(|e| 0.5 * (whitener * e).norm_squared()).sum::<f64>()
            };
            let numeric = (misfit(1.0) - misfit(-1.0)) / (2.0 * h);
            let error = (numeric - at.gradient[k]).abs();
            assert!(
                error < 1e-4 * numeric.abs() + 1e-7,
                "{}: {numeric} {}",
                coordinates.slot(k).name,
                at.gradient[k]
            );
        }
    }
}
