//! Whether the data identify the parameters that define an effect.

use crate::fitted_model::FittedModel;
use nalgebra::DMatrix;
use trundle_infer::{Fit, IDENTIFIED_SD};
use trundle_model::{Param, Role};

/// Whether the data identify the parameters that define an effect: every essential parameter except for
/// places and directions, and at least one of the alternatives of which any defines it, or a combination of these. For
/// example, a swinging load with an unknown frequency is equivalent to an offset mass. The offsets of a tracked frame
/// may each be uncertain only because the place of the wheel is. A refinement of its shape that the data pull above
/// its prior makes another law of it: dry friction with a very large creep speed is viscous.
pub(crate) fn is_defined(candidate: &FittedModel, k: usize) -> bool {
    let names = candidate.fit.model.effect_names();
    let name = &names[names.len() - candidate.added.len() + k];
    let spec = candidate.added[k].kind.spec();
    let full_name = |p: &Param| format!("{name}.{}", p.name);
    let identified = |p: &Param| candidate.fit.estimate(&full_name(p)).map(|e| e.identified);
    let essential = |p: &&Param| {
        p.refinement.is_none() && !p.role.is_choice() && !p.scales_face_pressure && !p.role.is_place()
    };
    let of = |any: bool| spec.params.iter().filter(essential).filter(move |p| p.is_alternative == any);
    let is_above_prior =
        |p: &Param| candidate.fit.prior_conflicts.iter().any(|c| c.name == full_name(p) && c.z > 0.0);
    let is_another_law = |p: &Param| p.role == Role::Shape && p.refinement.is_some() && is_above_prior(p);
    if spec.params.iter().any(is_another_law) {
        return false;
    }
    let any: Vec<bool> = of(true).filter_map(identified).collect();
    let alternatives: Vec<String> = of(true).map(full_name).collect();
    of(false).filter_map(identified).all(|known| known)
        && (any.is_empty() || any.contains(&true) || determines_a_combination(&candidate.fit, &alternatives))
}

/// Whether the posterior determines a combination of several parameters.
fn determines_a_combination(fit: &Fit, parameters: &[String]) -> bool {
    let at = |name: &String| fit.slots.iter().position(|slot| slot.name == *name);
    let places: Vec<usize> = parameters.iter().filter_map(at).collect();
    if places.len() < 2 {
        return false;
    }
    let covariance = DMatrix::from_fn(places.len(), places.len(), |i, j| fit.spread[(places[i], places[j])]);
    covariance.symmetric_eigenvalues().min() < IDENTIFIED_SD * IDENTIFIED_SD
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::is_defined;
    use crate::engine::Engine;
    use crate::engine::plant_engine::PlantEngine;
    use crate::fitted_model::FittedModel;
    use trundle_fixtures::{World, effect, locked};
    use trundle_infer::{Comparison, FitOptions, PriorConflict, Quiet, fit};
    use trundle_model::{Effect, Kind, Model};

    /// A fit with one effect, of whose parameters only `known` are identified.
    fn fit_with_identified(kind: Kind, known: &[&str]) -> FittedModel {
        let data = World::of(locked()).recording(4);
        let added = vec![Effect::free(kind)];
        let nominal = PlantEngine::new(&data, None).unwrap().nominal().clone();
        let model = Model { effects: [nominal.effects.clone(), added.clone()].concat(), ..nominal };
        let options = FitOptions { starts: 1, ..FitOptions::default() };
        let mut fitted = fit(&Comparison::of(&data).unwrap(), &model, &[], &options, &Quiet).unwrap();
        for (index, estimate) in fitted.estimates.iter_mut().enumerate() {
            estimate.identified = known.iter().any(|key| estimate.name.ends_with(&format!(".{key}")));
            if !estimate.identified {
                fitted.spread.row_mut(index).fill(0.0);
                fitted.spread.column_mut(index).fill(0.0);
                fitted.spread[(index, index)] = 1.0;
            }
        }
        FittedModel::new(added, fitted, None)
    }

    #[test]
    fn one_identified_limit_defines_a_saturation() {
        assert!(is_defined(&fit_with_identified(Kind::Saturation, &["limit_torque"]), 0));
        assert!(!is_defined(&fit_with_identified(Kind::Saturation, &[]), 0));
    }

    #[test]
    fn the_gain_of_one_axis_defines_a_scale_error() {
        assert!(is_defined(&fit_with_identified(Kind::ForceScale, &["gain_y"]), 0));
        assert!(!is_defined(&fit_with_identified(Kind::ForceScale, &[]), 0));
    }

    #[test]
    fn a_combination_of_gains_defines_a_scale_error() {
        let mut fitted = fit_with_identified(Kind::ForceScale, &[]);
        let at = |key: &str| fitted.fit.slots.iter().position(|slot| slot.name.ends_with(key)).unwrap();
        let [x, y] = [at("gain_y"), at("gain_torque")];
        fitted.fit.spread[(x, y)] = 0.999;
        fitted.fit.spread[(y, x)] = 0.999;
        assert!(is_defined(&fitted, 0));
    }

    #[test]
    fn a_load_heavier_than_the_object_is_defined() {
        let load = effect(Kind::MassChange, &[("episode", 1.0), ("time", 2.0), ("mass", 26.0)]);
        let data = World::of(locked().with(load.clone())).recording(4);
        let added = vec![Effect::free(Kind::MassChange).with("episode", Some(1.0))];
        let nominal = PlantEngine::new(&data, None).unwrap().nominal().clone();
        let free = Model { effects: [nominal.effects.clone(), added.clone()].concat(), ..nominal };
        let own: Vec<f64> = [20.0, 0.0, 0.0, 0.0, 20.0, 100.0, 1.0, 2.0, 20.0].into();
        let options = FitOptions { starts: 2, ..FitOptions::default() };
        let fitted = fit(&Comparison::of(&data).unwrap(), &free, &[own], &options, &Quiet).unwrap();
        let fitted = FittedModel::new(added, fitted, None);
        let mass = fitted.fit.estimate("mass_change.mass").unwrap();
        assert!(mass.mean > 22.0 && is_defined(&fitted, 0), "{mass:?}");
    }

    #[test]
    fn dry_friction_that_creeps_faster_than_its_prior_allows_is_not_defined() {
        let conflict = |name: &str, value: f64, z: f64| PriorConflict {
            name: name.to_owned(),
            unit: "m/s",
            value,
            z,
            range: [2.5e-6, 0.4],
        };
        let mut fitted = fit_with_identified(Kind::CoulombFriction, &["force", "creep"]);
        assert!(is_defined(&fitted, 0));
        // A place beyond the outline is no other law.
        fitted.fit.prior_conflicts = vec![conflict("coulomb_friction.x", 0.9, 4.5)];
        assert!(is_defined(&fitted, 0));
        fitted.fit.prior_conflicts = vec![conflict("coulomb_friction.creep", 0.9, 4.5)];
        assert!(!is_defined(&fitted, 0));
        // Friction that does not creep is ideal dry friction.
        fitted.fit.prior_conflicts = vec![conflict("coulomb_friction.creep", 1e-6, -4.5)];
        assert!(is_defined(&fitted, 0));
        // A large drift is a drift.
        let mut fitted = fit_with_identified(Kind::ForceBias, &["force_x", "force_y", "torque_z", "drift_x"]);
        fitted.fit.prior_conflicts = vec![conflict("force_bias.drift_x", 3.0, 10.0)];
        assert!(is_defined(&fitted, 0));
    }

    #[test]
    fn a_swinging_load_without_its_frequency_is_not_defined() {
        let all: Vec<&str> = Kind::SwingingLoad.spec().params.iter().map(|p| p.name).collect();
        assert!(is_defined(&fit_with_identified(Kind::SwingingLoad, &all), 0));
        let rest: Vec<&str> = all.into_iter().filter(|key| *key != "frequency").collect();
        assert!(!is_defined(&fit_with_identified(Kind::SwingingLoad, &rest), 0));
    }
}
