//! The sentence of a payload: of its mass and place, what the data identify.
//!
//! Gravity tells the product of mass and place, and accelerations their squares as well. Where the mass alone is not
//! identified, the sentence has the products.

use crate::answer::JointAnswer;
use crate::fit::Fit;
use crate::intervals::covariance;
use crate::model::{Kind, Role};
use crate::problem::Problem;
use crate::statement::shown;
use trundle_diagnose::Quantity;

/// Standard deviation at which a value is identified: a share of the mass, and of the prior's standard deviation of a place.
const MAX_SHARE: f64 = 0.5;
/// The parameters of a payload.
const NAMES: [&str; 4] = ["mass", "com_x", "com_y", "com_z"];

/// Replaces the sentences of payloads whose mass or place is not identified.
pub(crate) fn state_payloads(problem: &Problem, fit: &Fit, answer: &mut JointAnswer) {
    for (k, effect) in fit.effects.iter().enumerate() {
        let Kind::Payload(body) = effect.kind else { continue };
        let body = &problem.bodies[body].0;
        let entry = answer.missing.iter_mut().find(|entry| {
            let place = entry.place.as_ref().and_then(|place| place.get("body"));
            entry.effect == effect.kind.effect() && place == Some(body)
        });
        let slot = |i| fit.slots.iter().position(|slot| slot.role == Role::Effect(k, i));
        let slots: Option<Vec<usize>> = (0..NAMES.len()).map(slot).collect();
        let (Some(entry), Some(slots)) = (entry, slots) else { continue };
        let quantities: Option<Vec<Quantity>> =
            NAMES.map(|name| entry.parameters.get(name).cloned()).into_iter().collect();
        // Correlations hardly depend on how long residuals are correlated.
        let covariance = covariance(problem, fit, &vec![1.0; problem.joints.len()]);
        let (Some(quantities), Some(covariance)) = (quantities, covariance) else { continue };
        let prior = [1, 2, 3].map(|i| fit.slots[slots[i]].prior.sd());
        let correlation = [1, 2, 3].map(|i| {
            let [mass, place] = [slots[0], slots[i]];
            covariance[(mass, place)] / (covariance[(mass, mass)] * covariance[(place, place)]).sqrt()
        });
        if let Some(text) = sentence(body, &quantities, prior, correlation) {
            entry.statement = text;
        }
    }
}

/// The sentence of a payload of a mass and three places; `None` if all are identified. `prior` are the prior standard deviations
/// of the places, `correlation` are their correlations with the mass.
fn sentence(body: &str, values: &[Quantity], prior: [f64; 3], correlation: [f64; 3]) -> Option<String> {
    let (mass, places) = values.split_first()?;
    let unknown = || "unknown".to_owned();
    if mass.sd < MAX_SHARE * mass.mean {
        let is_known = |i: usize| places[i].sd < MAX_SHARE * prior[i];
        let text = |i: usize| if is_known(i) { shown(&places[i]) } else { unknown() };
        let [x, y, z] = [0, 1, 2].map(text);
        let load = shown(mass);
        return (![0, 1, 2].map(is_known).iter().all(|known| *known))
            .then(|| format!("A load of {load} is attached to body {body} at ({x}, {y}, {z})."));
    }
    let moment = |i: usize| {
        let [m, x] = [mass.mean, places[i].mean];
        let [by_mass, by_place] = [x * mass.sd, m * places[i].sd];
        let variance = by_mass * by_mass + by_place * by_place + 2.0 * correlation[i] * by_mass * by_place;
        let sd = variance.max(0.0).sqrt();
        if sd < MAX_SHARE * m * prior[i] {
            shown(&Quantity { mean: m * x, sd, unit: "1" })
        } else {
            unknown()
        }
    };
    let [x, y, z] = [0, 1, 2].map(moment);
    Some(format!(
        "A load is attached to body {body}; its mass and place are not identified separately, and mass times place is \
         ({x}, {y}, {z}) {}·m.",
        mass.unit
    ))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::sentence;
    use trundle_diagnose::Quantity;

    fn values(mass: [f64; 2], places: [[f64; 2]; 3]) -> Vec<Quantity> {
        let quantity = |[mean, sd]: [f64; 2], unit| Quantity { mean, sd, unit };
        std::iter::once(quantity(mass, "kg")).chain(places.map(|place| quantity(place, "m"))).collect()
    }

    #[test]
    fn a_mass_and_place_on_a_ridge_are_stated_as_their_product() {
        // Mass times place is known to 1 %, mass and place are not.
        let all = values([0.2, 5.7], [[-0.13, 3.705], [0.0, 10.0], [0.2, 5.7]]);
        let text = sentence("fore", &all, [10.0; 3], [0.99999, 0.0, -0.99999]).unwrap();
        assert!(
            text.contains("mass times place is (-0.0260 ± 0.0033, unknown, 0.0400 ± 0.0051) kg·m."),
            "{text}"
        );
        assert!(!text.contains("5.7"), "{text}");
    }

    #[test]
    fn an_unknown_place_of_a_known_mass_is_unknown() {
        let all = values([0.5, 0.01], [[0.1, 0.01], [0.0, 10.0], [0.3, 0.01]]);
        let text = sentence("fore", &all, [10.0; 3], [0.0; 3]).unwrap();
        assert!(text.ends_with("fore at (0.100 ± 0.010 m, unknown, 0.300 ± 0.010 m)."), "{text}");
        let all = values([0.5, 0.01], [[0.1, 0.01]; 3]);
        assert_eq!(sentence("fore", &all, [10.0; 3], [0.0; 3]), None);
    }
}
