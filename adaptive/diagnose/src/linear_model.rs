//! The linear model of the score test: residuals of a fit, their derivatives by the fit's own parameters, and
//! by amplitudes of candidates.

use crate::linearisation::{Linearisation, Start};
use crate::proposals::is_amplitude;
use nalgebra::{DMatrix, DVector};
use trundle_infer::{Fit, InferError};
use trundle_model::{Effect, Kind, Model, Param, Slot};

/// Relative ridge on a candidate's information matrix, so that unidentifiable amplitudes stay at zero.
const RELATIVE_RIDGE: f64 = 1e-6;

/// The residuals of a fit, and an orthonormal basis of the derivatives by its own parameters.
pub(crate) struct LinearModel {
    pub residual: DVector<f64>,
    own: DMatrix<f64>,
    basis: DMatrix<f64>,
    /// The slot of each own parameter.
    free: Vec<Option<usize>>,
}

impl LinearModel {
    pub fn new(view: &dyn Linearisation, fit: &Fit) -> Result<Self, InferError> {
        let (own, free) = view.own_derivatives(fit)?;
        let basis = own.clone().qr().q();
        Ok(Self { residual: view.residual(), own, basis, free })
    }

    /// The part of some columns that is orthogonal to the derivatives by the fit's own parameters.
    fn projected(&self, columns: &DMatrix<f64>) -> DMatrix<f64> {
        columns - &self.basis * self.basis.tr_mul(columns)
    }

    /// Starting points for some candidates, each added alone.
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

    /// The fit's own values after their response to a step of amplitudes.
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

    /// Number of values in a group before an effect.
    fn offset(&self, group: &[Effect], effect: &Effect) -> usize {
        group.iter().take_while(|e| !std::ptr::eq(*e, effect)).map(|e| e.values.len()).sum()
    }

    /// Score and information matrix of some amplitudes, with the fit's own parameters profiled out.
    pub fn normal_equations(&self, columns: &DMatrix<f64>) -> (DVector<f64>, DMatrix<f64>) {
        let projected = self.projected(columns);
        let mut information = projected.tr_mul(&projected);
        for k in 0..information.nrows() {
            let squared_norm = columns.column(k).norm_squared();
            information[(k, k)] += RELATIVE_RIDGE * squared_norm + 1e-12;
        }
        (-projected.tr_mul(&self.residual), information)
    }

    /// The Newton step of some amplitudes and its gain, nats.
    fn step(&self, columns: &DMatrix<f64>) -> Option<(DVector<f64>, f64)> {
        let (score, information) = self.normal_equations(columns);
        let step = information.cholesky()?.solve(&score);
        let gain = 0.5 * step.dot(&score);
        (gain.is_finite() && step.iter().all(|s| s.is_finite())).then_some((step, gain))
    }

    /// The response of the fit's own parameters to a step of the candidate.
    fn own_shift(&self, columns: &DMatrix<f64>, step: &DVector<f64>) -> Option<DVector<f64>> {
        let target = -(columns * step);
        let mut information = self.own.tr_mul(&self.own);
        for k in 0..information.nrows() {
            information[(k, k)] *= 1.0 + 1e-9;
        }
        Some(information.cholesky()?.solve(&self.own.tr_mul(&target)))
    }
}

/// Derivatives of the residuals by the amplitudes of some effects.
pub(crate) struct AmplitudeDerivatives {
    pub model: Model,
    pub values: Vec<f64>,
    /// For each effect: the slots of its amplitudes, and the derivatives by them.
    pub columns: Vec<(Vec<usize>, DMatrix<f64>)>,
}

/// The derivatives by the amplitudes of some effects that are added to a fit.
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
    let slots_of_amplitudes: Vec<usize> = amplitudes.iter().flatten().copied().collect();
    let all = view.derivatives(&model, &values, &slots_of_amplitudes)?;
    let mut column = 0;
    let columns = amplitudes.into_iter().map(|amplitudes| {
        let columns = all.columns(column, amplitudes.len()).into_owned();
        column += amplitudes.len();
        (amplitudes, columns)
    });
    let columns = columns.collect();
    Ok(AmplitudeDerivatives { model, values, columns })
}

/// An effect after a step of its amplitudes; `None` if every amplitude falls below its bound. `first` is the
/// effect's first slot.
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
    slot.lower < slot.upper && model.fixed_value(kind, param).is_none()
}

/// A value clamped to its bounds. A value that must be positive stays above 2 % of its prior median.
fn clamped(slot: &Slot, value: f64) -> f64 {
    let lower = match slot.prior {
        trundle_model::Prior::LogNormal { median, .. } => slot.lower.max(0.02 * median),
        _ => slot.lower,
    };
    value.clamp(lower, slot.upper)
}
