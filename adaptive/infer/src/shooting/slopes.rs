//! Simulated states of a segment and their derivatives by the parameters.

use super::segments::Segment;
use crate::{InferError, StateVector};
use nalgebra::DMatrix;
use trundle_model::{
    Dual, Model, ModelInstance, Plant, Prior, Real, Slot, State, StepError, StepInput, Stepper, transport,
};

/// Maximum number of derivatives propagated at once.
const MAX_DUALS: usize = 8;

/// Step of a finite difference relative to the parameter's scale under its prior. With smaller steps, the
/// contacts of a physics engine are not smooth.
const RELATIVE_STEP: f64 = 1e-3;

/// Simulation of segments at a model's values.
pub(crate) trait Simulate {
    /// Simulated states at the segment's samples.
    fn states(&self, segment: &Segment) -> Result<Vec<StateVector>, StepError>;

    /// Derivatives of the states by some slots: six rows for each sample, one column for each slot.
    fn slopes(&self, segment: &Segment) -> Result<DMatrix<f64>, StepError>;
}

/// Simulation by the built-in laws, with exact derivatives.
pub(crate) struct LawSimulation {
    plant: Plant<f64>,
    /// The plant with up to [`MAX_DUALS`] slots as dual variables, for each group of them.
    dual_plants: Vec<Plant<Dual<MAX_DUALS>>>,
    columns: usize,
}

impl LawSimulation {
    /// Simulation of a model at `values`, with derivatives by the slots `free`.
    pub fn new(model: &Model, values: &[f64], free: &[usize]) -> Result<Self, InferError> {
        let dual_plants = free.chunks(MAX_DUALS).map(|slots| {
            let mut lifted: Vec<Dual<MAX_DUALS>> = values.iter().map(|&v| Real::lift(v)).collect();
            for (k, &slot) in slots.iter().enumerate() {
                lifted[slot] = Dual::variable(values[slot], k);
            }
            model.plant(&lifted)
        });
        Ok(Self {
            plant: model.plant(values)?,
            dual_plants: dual_plants.collect::<Result<_, _>>()?,
            columns: free.len(),
        })
    }
}

/// Simulates a segment with a plant.
fn simulate<T: Real>(plant: &Plant<T>, segment: &Segment) -> Vec<[T; 6]> {
    let mut state = State::moving(segment.start.pose.map(T::lift), segment.start.twist.map(T::lift));
    let mut observed = segment.observed.iter().peekable();
    let mut found = Vec::with_capacity(segment.observed.len());
    for (k, input) in segment.inputs.iter().enumerate() {
        let applied = transport(plant.correct(input.reading.map(T::lift), input.clock), input.frame);
        state = plant.step(&state, applied, input.clock, input.dt);
        if observed.next_if(|s| s.after == k + 1).is_some() {
            found.push(state_vector(&state));
        }
    }
    found
}

fn state_vector<T: Real>(state: &State<T>) -> [T; 6] {
    let ([x, y, theta], [vx, vy, spin]) = (state.pose, state.twist);
    [x, y, theta, vx, vy, spin]
}

impl Simulate for LawSimulation {
    fn states(&self, segment: &Segment) -> Result<Vec<StateVector>, StepError> {
        Ok(simulate(&self.plant, segment))
    }

    fn slopes(&self, segment: &Segment) -> Result<DMatrix<f64>, StepError> {
        let mut slopes = DMatrix::zeros(6 * segment.observed.len(), self.columns);
        for (group, plant) in self.dual_plants.iter().enumerate() {
            let first = group * MAX_DUALS;
            for (i, value) in simulate(plant, segment).iter().flatten().enumerate() {
                for (k, slope) in value.eps.iter().take(self.columns - first).enumerate() {
                    slopes[(i, first + k)] = *slope;
                }
            }
        }
        Ok(slopes)
    }
}

/// Simulation by a simulator without derivatives. These are central differences with a step of a thousandth
/// of the parameter's scale under its prior.
pub(crate) struct StepperSimulation<'a> {
    stepper: &'a dyn Stepper,
    model: &'a Model,
    values: Vec<f64>,
    plant: Plant<f64>,
    /// For each free slot the two shifted sets of values, with their plants.
    shifted: Vec<[(Vec<f64>, Plant<f64>); 2]>,
    /// Inverse of the distance between the two.
    inverse: Vec<f64>,
}

impl<'a> StepperSimulation<'a> {
    /// Simulation of a model at `values`, with derivatives by the slots `free`.
    pub fn new(
        stepper: &'a dyn Stepper,
        model: &'a Model,
        values: &[f64],
        free: &[usize],
    ) -> Result<Self, InferError> {
        let slots = if free.is_empty() { vec![] } else { model.slots() };
        let shift = |k: usize, h: f64| -> Result<_, InferError> {
            let mut moved = values.to_vec();
            moved[k] += h;
            let plant = model.plant(&moved)?;
            Ok((moved, plant))
        };
        let (mut shifted, mut inverse) = (vec![], vec![]);
        for &k in free {
            let h = RELATIVE_STEP * scale(&slots[k], values[k]);
            shifted.push([shift(k, h)?, shift(k, -h)?]);
            inverse.push(0.5 / h);
        }
        Ok(Self { stepper, model, values: values.to_vec(), plant: model.plant(values)?, shifted, inverse })
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
        let too_short = || StepError {
            step: states.len(),
            reason: "the simulator returned fewer states than inputs".to_owned(),
        };
        segment
            .observed
            .iter()
            .map(|s| {
                s.after.checked_sub(1).and_then(|k| states.get(k)).map(state_vector).ok_or_else(too_short)
            })
            .collect()
    }
}

/// Scale of a parameter under its prior.
fn scale(slot: &Slot, value: f64) -> f64 {
    let size = match slot.prior {
        Prior::LogNormal { median, .. } => value.abs().max(1e-6 * median),
        Prior::Normal { sd, .. } => sd,
        Prior::Angle(_) => 1.0,
        _ => slot.upper - slot.lower,
    };
    if size.is_finite() && size > 0.0 { size } else { 1.0 }
}

impl Simulate for StepperSimulation<'_> {
    fn states(&self, segment: &Segment) -> Result<Vec<StateVector>, StepError> {
        self.rollout(&self.values, &self.plant, segment)
    }

    fn slopes(&self, segment: &Segment) -> Result<DMatrix<f64>, StepError> {
        let mut slopes = DMatrix::zeros(6 * segment.observed.len(), self.shifted.len());
        for (k, [above, below]) in self.shifted.iter().enumerate() {
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
