//! What a segment's simulation ends in, and its slopes by the parameters.

use super::segments::Segment;
use crate::{InferError, StateVector};
use nalgebra::DMatrix;
use trundle_model::{
    Dual, Model, ModelInstance, Plant, Prior, Real, Slot, State, StepError, StepInput, Stepper, transport,
};

/// Derivatives carried at once.
const WIDTH: usize = 8;

/// Step of a finite difference, in what its prior takes for the scale of a parameter. An engine's contacts are
/// rough below it.
const RELATIVE: f64 = 1e-3;

/// The states that segments are compared with, at a model's values.
pub(crate) trait Simulate {
    /// Simulated states at the segment's samples.
    fn states(&self, segment: &Segment) -> Result<Vec<StateVector>, StepError>;

    /// Their slopes by some slots: a row a channel of a sample, six for each; a column a slot.
    fn slopes(&self, segment: &Segment) -> Result<DMatrix<f64>, StepError>;
}

/// By the laws alone, with exact slopes.
pub(crate) struct Laws {
    plant: Plant<f64>,
    /// The plant with [`WIDTH`] slots as variables, for each group of them.
    varied: Vec<Plant<Dual<WIDTH>>>,
    columns: usize,
}

impl Laws {
    /// Of a model at `values`, with slopes by the slots `free`.
    pub fn new(model: &Model, values: &[f64], free: &[usize]) -> Result<Self, InferError> {
        let varied = free.chunks(WIDTH).map(|slots| {
            let mut lifted: Vec<Dual<WIDTH>> = values.iter().map(|&v| Real::lift(v)).collect();
            for (k, &slot) in slots.iter().enumerate() {
                lifted[slot] = Dual::variable(values[slot], k);
            }
            model.plant(&lifted)
        });
        Ok(Self {
            plant: model.plant(values)?,
            varied: varied.collect::<Result<_, _>>()?,
            columns: free.len(),
        })
    }
}

/// Walk a plant through a segment.
fn walk<T: Real>(plant: &Plant<T>, segment: &Segment) -> Vec<[T; 6]> {
    let mut state = State::moving(segment.start.pose.map(T::lift), segment.start.twist.map(T::lift));
    let mut seen = segment.seen.iter().peekable();
    let mut found = Vec::with_capacity(segment.seen.len());
    for (k, input) in segment.inputs.iter().enumerate() {
        let applied = transport(plant.correct(input.reading.map(T::lift), input.clock), input.frame);
        state = plant.step(&state, applied, input.clock, input.dt);
        if seen.next_if(|s| s.after == k + 1).is_some() {
            found.push(vector(&state));
        }
    }
    found
}

fn vector<T: Real>(state: &State<T>) -> [T; 6] {
    let ([x, y, theta], [vx, vy, spin]) = (state.pose, state.twist);
    [x, y, theta, vx, vy, spin]
}

impl Simulate for Laws {
    fn states(&self, segment: &Segment) -> Result<Vec<StateVector>, StepError> {
        Ok(walk(&self.plant, segment))
    }

    fn slopes(&self, segment: &Segment) -> Result<DMatrix<f64>, StepError> {
        let mut slopes = DMatrix::zeros(6 * segment.seen.len(), self.columns);
        for (group, plant) in self.varied.iter().enumerate() {
            let first = group * WIDTH;
            for (i, value) in walk(plant, segment).iter().flatten().enumerate() {
                for (k, slope) in value.eps.iter().take(self.columns - first).enumerate() {
                    slopes[(i, first + k)] = *slope;
                }
            }
        }
        Ok(slopes)
    }
}

/// By a simulator that gives no slopes: they are central differences, each step a thousandth of the parameter's
/// scale under its prior.
pub(crate) struct Stepped<'a> {
    stepper: &'a dyn Stepper,
    model: &'a Model,
    values: Vec<f64>,
    plant: Plant<f64>,
    /// For each free slot the two values beside its own, with their plants.
    sides: Vec<[(Vec<f64>, Plant<f64>); 2]>,
    /// One over the distance between the two.
    inverse: Vec<f64>,
}

impl<'a> Stepped<'a> {
    /// Of a model at `values`, with slopes by the slots `free`.
    pub fn new(
        stepper: &'a dyn Stepper,
        model: &'a Model,
        values: &[f64],
        free: &[usize],
    ) -> Result<Self, InferError> {
        let slots = if free.is_empty() { vec![] } else { model.slots() };
        let side = |k: usize, h: f64| -> Result<_, InferError> {
            let mut moved = values.to_vec();
            moved[k] += h;
            let plant = model.plant(&moved)?;
            Ok((moved, plant))
        };
        let (mut sides, mut inverse) = (vec![], vec![]);
        for &k in free {
            let h = RELATIVE * scale(&slots[k], values[k]);
            sides.push([side(k, h)?, side(k, -h)?]);
            inverse.push(0.5 / h);
        }
        Ok(Self { stepper, model, values: values.to_vec(), plant: model.plant(values)?, sides, inverse })
    }

    fn rollout(
        &self,
        values: &[f64],
        plant: &Plant<f64>,
        segment: &Segment,
    ) -> Result<Vec<StateVector>, StepError> {
        let drive = |input: &super::segments::Input| StepInput {
            applied: transport(plant.correct(input.reading, input.clock), input.frame),
            clock: input.clock,
            dt: input.dt,
        };
        let drives: Vec<StepInput> = segment.inputs.iter().map(drive).collect();
        let at = ModelInstance { model: self.model, values, plant };
        let states = self.stepper.rollout(&at, &segment.start, &drives)?;
        let lost = || StepError { step: states.len(), reason: "the rollout is too short".to_owned() };
        segment
            .seen
            .iter()
            .map(|s| s.after.checked_sub(1).and_then(|k| states.get(k)).map(vector).ok_or_else(lost))
            .collect()
    }
}

/// What changes a parameter noticeably.
fn scale(slot: &Slot, value: f64) -> f64 {
    let size = match slot.prior {
        Prior::LogNormal { median, .. } => value.abs().max(1e-6 * median),
        Prior::Normal { sd, .. } => sd,
        Prior::Angle(_) => 1.0,
        _ => slot.upper - slot.lower,
    };
    if size.is_finite() && size > 0.0 { size } else { 1.0 }
}

impl Simulate for Stepped<'_> {
    fn states(&self, segment: &Segment) -> Result<Vec<StateVector>, StepError> {
        self.rollout(&self.values, &self.plant, segment)
    }

    fn slopes(&self, segment: &Segment) -> Result<DMatrix<f64>, StepError> {
        let mut slopes = DMatrix::zeros(6 * segment.seen.len(), self.sides.len());
        for (k, [above, below]) in self.sides.iter().enumerate() {
            let above = self.rollout(&above.0, &above.1, segment)?;
            let below = self.rollout(&below.0, &below.1, segment)?;
            for (i, (a, b)) in above.iter().zip(&below).enumerate() {
                for channel in 0..6 {
                    let rise = super::scatter::difference(a, b, channel);
                    slopes[(6 * i + channel, k)] = rise * self.inverse[k];
                }
            }
        }
        Ok(slopes)
    }
}
