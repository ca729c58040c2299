//! The linear model behind the score test: what a fit leaves, what its own parameters can do about it, and what amplitudes of
//! candidates would change.

use crate::proposals::is_amplitude;
use crate::screen::{Linearisation, Start};
use nalgebra::{DMatrix, DVector};
use trundle_infer::{Fit, InferError};
use trundle_model::{Effect, Kind, Model, Param, Slot};

/// Ridge on a candidate's information, relative: amplitudes that the data do not hold stay put.
const RELATIVE_RIDGE: f64 = 1e-6;

/// What the fit leaves, and an orthonormal basis of what its own parameters can do.
pub(crate) struct LinearModel {
    pub residual: DVector<f64>,
    own: DMatrix<f64>,
    basis: DMatrix<f64>,
    /// The slot of each of those parameters.
    free: Vec<Option<usize>>,
}

impl LinearModel {
    pub fn new(view: &dyn Linearisation, fit: &Fit) -> Result<Self, InferError> {
        let (own, free) = view.own_derivatives(fit)?;
        let basis = own.clone().qr().q();
        Ok(Self { residual: view.residual(), own, basis, free })
    }

    /// What of some columns the fit's own parameters cannot do.
    fn projected(&self, columns: &DMatrix<f64>) -> DMatrix<f64> {
        columns - &self.basis * self.basis.tr_mul(columns)
    }

    /// Starts of some candidates, each on its own.
    pub fn starts(
        &self,
        view: &dyn Linearisation,
        fit: &Fit,
        group: &[Effect],
    ) -> Result<Vec<Start>, InferError> {
        let AmplitudeDerivatives { model, values, columns, .. } = &amplitude_derivatives(view, fit, group)?;
        let slots = model.slots();
        let mut starts = Vec::with_capacity(group.len());
        for (effect, (amplitudes, columns)) in group.iter().zip(columns) {
            let Some((step, gain)) = self.step(columns) else { continue };
            let first = fit.values.len() + self.offset(group, effect);
            let Some(stepped) = stepped(effect, first, amplitudes, step.as_slice(), values, &slots) else {
                continue;
            };
            let base = self.shifted(fit, &slots, columns, &step);
            starts.push(Start { effect: stepped, base, gain, neutral: effect.clone() });
        }
        Ok(starts)
    }

    /// The fit's own values after they gave way to a step.
    pub fn shifted(
        &self,
        fit: &Fit,
        slots: &[Slot],
        columns: &DMatrix<f64>,
        step: &DVector<f64>,
    ) -> Vec<f64> {
        let mut own = fit.values.clone();
        if let Some(shift) = self.own_shift(columns, step) {
            for (k, slot) in self.free.iter().enumerate() {
                let Some(slot) = *slot else { continue };
                own[slot] = clamped(&slots[slot], fit.values[slot] + shift[k]);
            }
        }
        own
    }

    /// Number of values before an effect of a group.
    fn offset(&self, group: &[Effect], effect: &Effect) -> usize {
        group.iter().take_while(|e| !std::ptr::eq(*e, effect)).map(|e| e.values.len()).sum()
    }

    /// The score of some amplitudes and their information, beside what the fit's own parameters can do.
    pub fn normal_equations(&self, columns: &DMatrix<f64>) -> (DVector<f64>, DMatrix<f64>) {
        let projected = self.projected(columns);
        let mut information = projected.tr_mul(&projected);
        for k in 0..information.nrows() {
            let squared_norm = columns.column(k).norm_squared();
            information[(k, k)] += RELATIVE_RIDGE * squared_norm + 1e-12;
        }
        (-projected.tr_mul(&self.residual), information)
    }

    /// The best small step of some amplitudes, and its gain.
    fn step(&self, columns: &DMatrix<f64>) -> Option<(DVector<f64>, f64)> {
        let (score, information) = self.normal_equations(columns);
        let step = information.cholesky()?.solve(&score);
        let gain = 0.5 * step.dot(&score);
        (gain.is_finite() && step.iter().all(|s| s.is_finite())).then_some((step, gain))
    }

    /// How the fit's own parameters give way to a step of the candidate.
    fn own_shift(&self, columns: &DMatrix<f64>, step: &DVector<f64>) -> Option<DVector<f64>> {
        let target = -(columns * step);
        let mut information = self.own.tr_mul(&self.own);
        for k in 0..information.nrows() {
            information[(k, k)] *= 1.0 + 1e-9;
        }
        Some(information.cholesky()?.solve(&self.own.tr_mul(&target)))
    }
}

/// What amplitudes of some effects would change.
pub(crate) struct AmplitudeDerivatives {
    pub model: Model,
    pub values: Vec<f64>,
    /// Of each effect: the slots of its amplitudes, and their derivatives.
    pub columns: Vec<(Vec<usize>, DMatrix<f64>)>,
}

/// The derivatives by the amplitudes of some effects on top of a fit.
pub(crate) fn amplitude_derivatives(
    view: &dyn Linearisation,
    fit: &Fit,
    group: &[Effect],
) -> Result<AmplitudeDerivatives, InferError> {
    let mut model = fit.model.clone();
    if fit.estimate("body.mass").is_some() {
        model.mass = None;
    }
    model.effects.extend(group.iter().cloned());
    let slots = model.slots();
    let mut values = fit.values.clone();
    let mut amplitudes: Vec<Vec<usize>> = Vec::with_capacity(group.len());
    for effect in group {
        let start = values.len();
        let spec = effect.kind.spec();
        let free = |(k, slot): (usize, &Slot)| {
            let param = &spec.params[k];
            let free =
                is_amplitude(effect.kind, param) && is_free_amplitude(slot, &model, effect.kind, param);
            free.then_some(start + k)
        };
        let of_effect = &slots[start..start + effect.values.len()];
        amplitudes.push(of_effect.iter().enumerate().filter_map(free).collect());
        values.extend(effect.values.iter().map(|v| v.unwrap_or(0.0)));
    }
    let wanted: Vec<usize> = amplitudes.iter().flatten().copied().collect();
    let all = view.derivatives(&model, &values, &wanted)?;
    let mut column = 0;
    let columns = amplitudes.into_iter().map(|amplitudes| {
        let columns = all.columns(column, amplitudes.len()).into_owned();
        column += amplitudes.len();
        (amplitudes, columns)
    });
    let columns = columns.collect();
    Ok(AmplitudeDerivatives { model, values, columns })
}

/// An effect, the first of whose slots is given, after a step of its amplitudes; `None` where all of them fall below their
/// bounds.
pub(crate) fn stepped(
    effect: &Effect,
    first: usize,
    amplitudes: &[usize],
    step: &[f64],
    values: &[f64],
    slots: &[Slot],
) -> Option<Effect> {
    let mut stepped = effect.clone();
    let below = |(&slot, step): (&usize, &f64)| values[slot] + step < slots[slot].lower;
    if !amplitudes.is_empty() && amplitudes.iter().zip(step).all(below) {
        return None;
    }
    for (&slot, step) in amplitudes.iter().zip(step) {
        let value = values[slot] + step;
        stepped.values[slot - first] = Some(clamped(&slots[slot], value));
    }
    Some(stepped)
}

/// Whether an amplitude is free in a model.
fn is_free_amplitude(slot: &Slot, model: &Model, kind: Kind, param: &Param) -> bool {
    slot.lower < slot.upper && model.fixed(kind, param).is_none()
}

/// A value within its bounds, and where it must be positive, not at nothing.
fn clamped(slot: &Slot, value: f64) -> f64 {
    let lower = match slot.prior {
        trundle_model::Prior::LogNormal { median, .. } => slot.lower.max(0.02 * median),
        _ => slot.lower,
    };
    value.clamp(lower, slot.upper)
}
