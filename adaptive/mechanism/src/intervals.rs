//! Standard deviations of fitted parameters.

use crate::fit::Fit;
use crate::laws::JointKind;
use crate::model::{Kind, Role};
use crate::problem::Problem;
use crate::rows::{Scope, evaluate, normal_equations};
use crate::units::Unit;
use nalgebra::DMatrix;

/// Largest share of the prior's standard deviation at which a parameter counts as identified.
const MAX_POSTERIOR_SHARE: f64 = 0.5;

/// Distance of a strength from zero at which it is identified, standard deviations.
const CLEAR_SDS: f64 = 2.0;

/// The same of a payload, whose four values are chosen together.
const PAYLOAD_CLEAR_SDS: f64 = 2.0 * CLEAR_SDS;

/// A parameter's standard deviation, and whether the data identify it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Interval {
    pub sd: f64,
    pub identified: bool,
}

/// Covariance of all slots; `None` if the precision is singular. Correlated residuals count as fewer samples: `time` is the
/// correlation time of each joint's residual, in samples.
pub(crate) fn covariance(problem: &Problem, fit: &Fit, time: &[f64]) -> Option<DMatrix<f64>> {
    let rows = evaluate(problem, &fit.effects, &fit.slots, &fit.values, Scope::Training, true);
    let sd: Vec<f64> = fit.sd.iter().zip(time).map(|(sd, time)| sd * time.sqrt()).collect();
    let (mut matrix, _) = normal_equations(&rows, &sd, &fit.slots, &fit.values, &|_| true);
    // A parameter at its bound cannot move with the others.
    let is_bound = |k: usize| fit.slots[k].bounds.contains(&fit.values[k]);
    for k in (0..fit.slots.len()).filter(|k| is_bound(*k)) {
        let own = matrix[(k, k)];
        matrix.row_mut(k).fill(0.0);
        matrix.column_mut(k).fill(0.0);
        matrix[(k, k)] = own;
    }
    let scale: Vec<f64> =
        (0..fit.slots.len()).map(|k| matrix[(k, k)].max(f64::MIN_POSITIVE).sqrt()).collect();
    let scaled = DMatrix::from_fn(scale.len(), scale.len(), |i, k| matrix[(i, k)] / (scale[i] * scale[k]));
    let inverse = scaled.cholesky()?.inverse();
    Some(DMatrix::from_fn(scale.len(), scale.len(), |i, k| inverse[(i, k)] / (scale[i] * scale[k])))
}

/// Intervals of all slots; `time` as in [`covariance`].
pub(crate) fn intervals(problem: &Problem, fit: &Fit, time: &[f64]) -> Vec<Interval> {
    let covariance = covariance(problem, fit, time);
    let one = |k: usize| {
        let prior = fit.slots[k].prior.sd();
        let sd = covariance.as_ref().map_or(prior, |all| all[(k, k)].max(0.0).sqrt());
        Interval { sd, identified: sd < MAX_POSTERIOR_SHARE * prior }
    };
    (0..fit.slots.len()).map(one).collect()
}

/// Whether the data identify every effect: at least one parameter of its strength is two standard deviations from zero.
/// That of a payload is its mass with its moments: the data may determine a moment, and neither mass nor place.
pub(crate) fn are_defined(problem: &Problem, fit: &Fit, time: &[f64]) -> bool {
    let Some(covariance) = covariance(problem, fit, time) else { return fit.effects.is_empty() };
    let is_strength = |effect: usize, param: usize| {
        let spec = fit.effects[effect].kind.params()[param];
        let is_phase = spec.unit == Unit::Angle && fit.effects[effect].kind.joint().is_some();
        let is_place = matches!(spec.unit, Unit::Position | Unit::Velocity | Unit::Length);
        !(spec.is_choice || is_place || is_phase)
    };
    (0..fit.effects.len()).all(|k| {
        let kind = fit.effects[k].kind;
        let offset = matches!(kind, Kind::EncoderOffset(_) | Kind::Joint(JointKind::Backlash, _));
        let own = |slot: usize| match fit.slots[slot].role {
            Role::Effect(effect, param) if effect == k => Some(param),
            _ => None,
        };
        let slots: Vec<(usize, usize)> =
            (0..fit.slots.len()).filter_map(|slot| Some((slot, own(slot)?))).collect();
        let is_clear = |(slot, param): &(usize, usize)| {
            let sd = covariance[(*slot, *slot)].max(0.0).sqrt();
            (offset || is_strength(k, *param)) && fit.values[*slot].abs() > CLEAR_SDS * sd
        };
        if let Kind::Payload(_) = kind {
            let own: Vec<usize> = slots.iter().map(|(slot, _)| *slot).collect();
            return distance(&covariance, &fit.values, &own).is_some_and(|sds| sds > PAYLOAD_CLEAR_SDS);
        }
        slots.iter().any(is_clear)
    })
}

/// Distance of a payload from zero: of its mass and its moments together, standard deviations. In (m, m·c), a mass at its own place
/// is the direction to zero; so this is the mass over its standard deviation at a fixed place. `None` if the covariance of
/// its values is singular.
fn distance(covariance: &DMatrix<f64>, values: &[f64], slots: &[usize]) -> Option<f64> {
    let mass = *slots.first()?;
    let sds: Vec<f64> = slots.iter().map(|k| covariance[(*k, *k)].max(f64::MIN_POSITIVE).sqrt()).collect();
    let of = |i: usize, k: usize| covariance[(slots[i], slots[k])] / (sds[i] * sds[k]);
    let precision = DMatrix::from_fn(slots.len(), slots.len(), of).cholesky()?.inverse();
    Some(values[mass] / sds[0] * precision[(0, 0)].sqrt())
}

#[cfg(test)]
mod tests {
    use super::PAYLOAD_CLEAR_SDS;
    use nalgebra::DMatrix;

    #[test]
    fn a_payload_is_defined_if_only_its_moment_is_known() {
        // A load of 0.5 kg at 0.3 m: its mass is known to 0.4 kg, and its moment to a share.
        let (mass, place, sd) = (0.5, 0.3, 0.4);
        let distance = |share: f64| {
            // d(m c) = c dm + m dc.
            let precision = |moment: f64| {
                let gradient = [place, mass];
                DMatrix::from_fn(2, 2, |i, k| {
                    let own = if i + k == 0 { 1.0 / (sd * sd) } else { 0.0 };
                    gradient[i] * gradient[k] / (moment * moment) + own
                })
            };
            let covariance = precision(share * mass * place).try_inverse().unwrap();
            super::distance(&covariance, &[mass, place], &[0, 1]).unwrap()
        };
        assert!(distance(0.05) > PAYLOAD_CLEAR_SDS, "{}", distance(0.05));
        assert!(distance(0.5) < PAYLOAD_CLEAR_SDS, "{}", distance(0.5));
    }
}
