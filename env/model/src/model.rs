//! A model: a body and its effects, with fixed and free parameters.

use crate::law::{EffectTarget, InnerState, LawSetup, Param, Prior};
use crate::{Body, Discrepancy, Kind, Law, ModelError, Plant, Real, TruncatedPrior};
use std::collections::BTreeMap;
use std::sync::Arc;

/// An effect of a model, with its parameter values.
#[derive(Clone, Debug, PartialEq)]
pub struct Effect {
    /// Kind of the effect.
    pub kind: Kind,
    /// Parameter values in the order of [`crate::Spec::params`]; `None` is free.
    pub values: Vec<Option<f64>>,
}

impl Effect {
    /// An effect whose essential parameters are free and whose refinements have their defaults.
    pub fn free(kind: Kind) -> Self {
        Self { kind, values: kind.spec().params.iter().map(|p| p.refinement).collect() }
    }

    /// Copy with one value set, or freed by `None`. An unknown name has no effect.
    #[must_use]
    pub fn with(mut self, name: &str, value: Option<f64>) -> Self {
        if let Some(k) = self.kind.spec().params.iter().position(|p| p.name == name) {
            self.values[k] = value;
        }
        self
    }
}

/// A rigid body plus a list of effects.
#[derive(Clone, Debug, PartialEq)]
pub struct Model {
    /// Body. Its mass is the initial guess if [`Model::mass`] is free.
    pub body: Body,
    /// Mass, kg; `None` is free.
    pub mass: Option<f64>,
    /// Degrees of freedom: whether the object can move in x, y and θ.
    pub dof: [bool; 3],
    /// Effects.
    pub effects: Vec<Effect>,
    /// Priors by parameter name that replace those of the catalogue.
    pub priors: BTreeMap<String, TruncatedPrior>,
    /// Model discrepancy, shared by all plants of the model.
    pub discrepancy: Option<Arc<Discrepancy>>,
}

/// One scalar parameter of a model.
#[derive(Clone, Debug, PartialEq)]
pub struct Slot {
    /// `body.mass`, `coulomb_friction.force`, `coulomb_friction_2.force`, …
    pub name: String,
    /// SI unit.
    pub unit: &'static str,
    /// Lower bound.
    pub lower: f64,
    /// Upper bound.
    pub upper: f64,
    /// Prior distribution.
    pub prior: Prior,
    /// Value; `None` is free.
    pub value: Option<f64>,
    /// Index into [`Model::effects`]; `None` for a parameter of the body.
    pub effect: Option<usize>,
}

impl Model {
    /// Nominal model of the paper (eq. 3): a rigid body with one anisotropic viscous wheel whose parameters are free.
    pub fn nominal(body: Body, mass: Option<f64>, dof: [bool; 3]) -> Self {
        let effects = vec![Effect::free(Kind::ViscousWheel)];
        Self { body, mass, dof, effects, priors: BTreeMap::new(), discrepancy: None }
    }

    /// Whether the object is on a rail along x.
    pub fn on_rail(&self) -> bool {
        !self.dof[1] && !self.dof[2]
    }

    /// The same model with one more effect.
    #[must_use]
    pub fn with(mut self, effect: Effect) -> Self {
        self.effects.push(effect);
        self
    }

    /// The same model without instrument effects.
    #[must_use]
    pub fn without_instruments(mut self) -> Self {
        self.effects.retain(|effect| effect.kind.spec().target == EffectTarget::Object);
        self.discrepancy = self.discrepancy.filter(|discrepancy| !discrepancy.corrects_reading());
        self
    }

    /// Name of each effect within the model: its kind, numbered from the second of a kind.
    pub fn effect_names(&self) -> Vec<String> {
        let mut seen: BTreeMap<Kind, usize> = BTreeMap::new();
        let name = |effect: &Effect| {
            let count = seen.entry(effect.kind).or_default();
            *count += 1;
            let kind = effect.kind.spec().kind;
            if *count == 1 { kind.to_owned() } else { format!("{kind}_{count}") }
        };
        self.effects.iter().map(name).collect()
    }

    /// All scalar parameters: the mass, then the parameters of each effect in order.
    pub fn slots(&self) -> Vec<Slot> {
        let mut slots = vec![Slot {
            name: "body.mass".to_owned(),
            unit: "kg",
            lower: 1e-3,
            upper: 1e5,
            prior: Prior::LogNormal { median: self.body.mass, sd: 1.5 },
            value: self.mass,
            effect: None,
        }];
        for (index, (effect, name)) in self.effects.iter().zip(self.effect_names()).enumerate() {
            for (param, &value) in effect.kind.spec().params.iter().zip(&effect.values) {
                slots.push(self.slot(param, value, index, &name));
            }
        }
        for slot in &mut slots {
            if let Some(&TruncatedPrior { prior, lower, upper }) = self.priors.get(&slot.name) {
                (slot.prior, slot.lower, slot.upper) = (prior, lower, upper);
            }
        }
        slots
    }

    /// Set the value of parameter `index` of [`Model::slots`].
    pub(crate) fn set_value(&mut self, index: usize, value: f64) {
        if index == 0 {
            self.mass = Some(value);
            self.body.mass = value;
        } else if let Some(place) = self.effects.iter_mut().flat_map(|e| &mut e.values).nth(index - 1) {
            *place = Some(value);
        }
    }

    /// Free a refinement that has its default value.
    pub(crate) fn free_refinement(&mut self, slot: &str) {
        for (effect, name) in self.effect_names().into_iter().enumerate() {
            let Some(key) = slot.strip_prefix(&name).and_then(|rest| rest.strip_prefix('.')) else {
                continue;
            };
            let effect = &mut self.effects[effect];
            for (param, value) in effect.kind.spec().params.iter().zip(&mut effect.values) {
                let finer = param.refinement.is_some() && !param.role.is_choice();
                if param.name == key && finer && *value == param.refinement {
                    *value = None;
                }
            }
        }
    }

    fn slot(&self, param: &Param, value: Option<f64>, index: usize, effect: &str) -> Slot {
        let (lower, upper) = match param.prior {
            Prior::OnBody(axis) => {
                let [low, high] = self.body.bounds();
                (low[axis], high[axis])
            }
            _ => (param.lower, param.upper),
        };
        let kind = self.effects.get(index).map(|effect| effect.kind);
        let value = value.or_else(|| self.fixed_value(kind?, param));
        let name = format!("{effect}.{}", param.name);
        Slot { name, unit: param.unit, lower, upper, prior: param.prior, value, effect: Some(index) }
    }

    /// Value of a parameter that has no meaning for this object or is not identifiable; `None` for all others.
    /// On a rail this is its neutral value, or the allowed value closest to zero.
    pub fn fixed_value(&self, kind: Kind, param: &Param) -> Option<f64> {
        if self.on_rail() && !param.on_rail {
            let neutral = kind.spec().neutral;
            let own = neutral.iter().find(|(name, value)| *name == param.name && value.is_finite());
            return Some(own.map_or(0.0, |(_, value)| *value).clamp(param.lower, param.upper));
        }
        let is_fixed_to_one = param.scales_face_pressure && self.body.feet.is_some()
            || param.needs_known_mass && self.mass.is_none();
        is_fixed_to_one.then_some(1.0)
    }

    /// Plant with `values`, one for each of [`Model::slots`].
    ///
    /// # Errors
    /// When the number of values differs from the number of slots.
    pub fn plant<T: Real>(&self, values: &[T]) -> Result<Plant<T>, ModelError> {
        let expected = 1 + self.effects.iter().map(|e| e.values.len()).sum::<usize>();
        if values.len() != expected {
            return Err(ModelError::Length { what: "parameters", got: values.len(), expected });
        }
        let (mass, mut rest) = (values[0], &values[1..]);
        let wheel = self.first_wheel(values);
        let site = LawSetup { body: &self.body, wheel };
        let mut laws = Vec::with_capacity(self.effects.len());
        for effect in &self.effects {
            let (own, others) = rest.split_at(effect.values.len());
            laws.push(Law::new(effect.kind, own, &site));
            rest = others;
        }
        Plant::new(mass, &self.body, self.dof, laws, self.discrepancy.clone())
    }

    /// Parameters of the first viscous wheel among the values of all slots.
    fn first_wheel<T: Real>(&self, values: &[T]) -> Option<[T; 5]> {
        let index = self.effects.iter().position(|e| e.kind == Kind::ViscousWheel)?;
        let start = 1 + self.effects[..index].iter().map(|e| e.values.len()).sum::<usize>();
        values.get(start..start + 5)?.try_into().ok()
    }

    /// Inner states of all laws, in the order of [`crate::State::inner`].
    pub fn inner(&self) -> Vec<InnerState> {
        self.effects.iter().flat_map(|e| e.kind.spec().inner_states).copied().collect()
    }

    /// Plant of a model without free parameters.
    ///
    /// # Errors
    /// When a parameter is free; the message names it.
    pub fn resolved(&self) -> Result<Plant<f64>, ModelError> {
        let value = |slot: Slot| {
            slot.value.ok_or_else(|| {
                ModelError::Format(format!(
                    "{} has no value: give one, or fit the model to a recording first",
                    slot.name
                ))
            })
        };
        self.plant(&self.slots().into_iter().map(value).collect::<Result<Vec<_>, _>>()?)
    }

    /// The same model with the named parameters free (names of [`Model::slots`]). Unknown names have no effect.
    ///
    /// Refinements keep their values, because `model.toml` cannot represent a free refinement.
    #[must_use]
    pub fn with_free(&self, names: &[String]) -> Self {
        let mut model = self.clone();
        let free: Vec<bool> = self.slots().iter().map(|slot| names.contains(&slot.name)).collect();
        if free.first() == Some(&true) {
            model.mass = None;
        }
        let essential = |effect: &Effect| effect.kind.spec().params.iter().map(|p| p.refinement.is_none());
        let essential: Vec<bool> = self.effects.iter().flat_map(essential).collect();
        let values = model.effects.iter_mut().flat_map(|e| &mut e.values);
        for ((value, essential), free) in values.zip(essential).zip(free.iter().skip(1)) {
            if *free && essential {
                *value = None;
            }
        }
        model
    }

    /// The same model with fixed `values`, one for each of [`Model::slots`].
    ///
    /// # Errors
    /// When the number of values differs from the number of slots.
    pub fn with_values(&self, values: &[f64]) -> Result<Self, ModelError> {
        self.plant(values)?;
        let mut model = self.clone();
        model.mass = Some(values[0]);
        model.body.mass = values[0];
        let mut rest = values[1..].iter();
        for value in model.effects.iter_mut().flat_map(|e| &mut e.values) {
            *value = rest.next().copied();
        }
        Ok(model)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table() -> Model {
        let body = Body::from_footprint(&[[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]], 22.0).unwrap();
        Model::nominal(body, None, [true; 3])
    }

    #[test]
    fn nominal_model_has_the_papers_six_parameters() {
        let names: Vec<_> =
            table().slots().into_iter().filter(|s| s.value.is_none()).map(|s| s.name).collect();
        let wheel = ["x", "y", "angle", "mu_x", "mu_y"].map(|p| format!("viscous_wheel.{p}"));
        assert_eq!(names[0], "body.mass");
        assert_eq!(names[1..], wheel);
    }

    #[test]
    fn refinements_keep_their_values() {
        let [force, creep] = [("force", 40.0), ("creep", 0.2)];
        let values = [("x", 0.1), ("y", 0.2), force, creep];
        let rubbing =
            values.iter().fold(Effect::free(Kind::CoulombFriction), |e, (k, v)| e.with(k, Some(*v)));
        let mut model = Model::nominal(table().body, Some(22.0), [true; 3]);
        model.effects = vec![rubbing];
        let names = ["body.mass", "coulomb_friction.force", "coulomb_friction.creep"].map(str::to_owned);
        let freed = model.with_free(&names);
        let value = |name: &str| freed.slots().into_iter().find(|slot| slot.name == name).unwrap().value;
        assert_eq!((value("body.mass"), value("coulomb_friction.force")), (None, None));
        assert_eq!((value("coulomb_friction.x"), value("coulomb_friction.creep")), (Some(0.1), Some(0.2)));
        let (again, _) = Model::from_toml(&freed.to_toml(None).unwrap()).unwrap();
        assert_eq!(again.effects, freed.effects);
    }

    #[test]
    fn on_a_rail_mass_and_one_friction_are_free() {
        let model = Model::nominal(Body::point(95.0).unwrap(), None, [true, false, false]);
        let free: Vec<_> = model.slots().into_iter().filter(|s| s.value.is_none()).map(|s| s.name).collect();
        assert_eq!(free, ["body.mass", "viscous_wheel.mu_x"]);
    }

    #[test]
    fn the_phase_of_cogging_is_free_on_a_rail() {
        let rail = Model::nominal(Body::point(95.0).unwrap(), None, [true, false, false]);
        let slots = rail.with(Effect::free(Kind::Cogging)).slots();
        let value = |name: &str| slots.iter().find(|slot| slot.name == name).unwrap().value;
        assert_eq!((value("cogging.phase"), value("cogging.angle")), (None, Some(0.0)));
    }

    #[test]
    fn pressure_is_free_under_a_face_and_fixed_on_feet() {
        let spread = |model: Model| {
            let slots = model.with(Effect::free(Kind::SupportFriction)).slots();
            slots.into_iter().find(|s| s.name == "support_friction.spread").unwrap().value
        };
        let mut standing = table();
        standing.body = standing.body.with_feet(&[[-0.5, -0.3], [0.5, -0.3], [0.0, 0.3]]);
        assert_eq!((spread(table()), spread(standing)), (None, Some(1.0)));
    }

    #[test]
    fn effects_of_one_kind_are_numbered() {
        let model = table().with(Effect::free(Kind::ViscousWheel));
        assert_eq!(model.effect_names(), ["viscous_wheel", "viscous_wheel_2"]);
    }

    #[test]
    fn a_wrong_number_of_values_is_an_error() {
        let error = table().plant(&[1.0, 2.0]).unwrap_err();
        assert_eq!(error, ModelError::Length { what: "parameters", got: 2, expected: 6 });
        assert!(table().resolved().unwrap_err().to_string().contains("body.mass"));
    }
}
