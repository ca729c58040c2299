//! Posterior density for optimisers and samplers: likelihood and prior in the coordinates of [`Coordinates`].
//! Some parameters are shared by all episodes, others have a value for each episode (eq. 6).

use crate::coordinates::clamp_to_prior;
use crate::{Coordinates, Evaluation, InferError, Likelihood, Linearised};
use std::collections::BTreeSet;
use trundle_model::{Model, Slot};

/// A posterior density over unbounded coordinates `z`, not normalised.
pub trait Density: Sync {
    /// Number of coordinates.
    fn dimension(&self) -> usize;

    /// −log density at `z`; infinite where it cannot be evaluated, never NaN.
    ///
    /// # Errors
    /// When a user-supplied simulator fails.
    fn cost(&self, z: &[f64]) -> Result<f64, InferError>;

    /// The cost with its derivatives by `z`.
    ///
    /// # Errors
    /// As [`Density::cost`].
    fn linearise(&self, z: &[f64]) -> Result<Linearised, InferError>;

    /// The cost, with derivatives on demand; `likely` means that they are probably required.
    ///
    /// # Errors
    /// As [`Density::cost`].
    fn evaluate<'a>(&'a self, z: &[f64], likely: bool) -> Result<Evaluation<'a>, InferError> {
        if likely {
            return self.linearise(z).map(Evaluation::of);
        }
        let (cost, z) = (self.cost(z)?, z.to_vec());
        Ok(Evaluation::new(cost, move || self.linearise(&z)))
    }
}

/// Parameter of one coordinate of a [`Target`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct ParameterRef {
    /// Index among the free parameters of [`Coordinates`].
    parameter: usize,
    /// The episode of a per-episode parameter; `None` for a shared one.
    episode: Option<usize>,
}

/// Posterior density of a model's free parameters given some episodes.
pub struct Target<'a> {
    model: &'a Model,
    coordinates: Coordinates,
    /// The whole likelihood, or one part for each episode if some parameters are per episode.
    parts: Vec<Part<'a>>,
    parameter_refs: Vec<ParameterRef>,
    episodes: Vec<String>,
    /// Footprint priors of the places on the body.
    footprint_terms: FootprintTerms,
}

enum Part<'a> {
    Whole(&'a dyn Likelihood),
    Episode(Box<dyn Likelihood + 'a>),
}

impl Part<'_> {
    fn likelihood(&self) -> &dyn Likelihood {
        match self {
            Self::Whole(l) => *l,
            Self::Episode(l) => &**l,
        }
    }
}

impl<'a> Target<'a> {
    /// The density of `model`'s free parameters; those named in `per_episode` have a value for each episode.
    ///
    /// # Errors
    /// When `per_episode` names a parameter that is not free, or the likelihood cannot be split.
    pub fn new(
        likelihood: &'a dyn Likelihood,
        model: &'a Model,
        per_episode: &BTreeSet<String>,
    ) -> Result<Self, InferError> {
        let slots: Vec<Slot> = model.slots().into_iter().chain(likelihood.noise()).collect();
        Self::assemble(Coordinates::of(slots).with_footprint(model), likelihood, model, per_episode)
    }

    /// The density under another likelihood of the same model.
    ///
    /// # Errors
    /// As [`Target::new`].
    pub(crate) fn with_likelihood(
        &self,
        likelihood: &'a dyn Likelihood,
        per_episode: &BTreeSet<String>,
    ) -> Result<Self, InferError> {
        let slots = self.model.slots().into_iter().chain(likelihood.noise());
        // The normalisation of the footprint priors takes as long as a likelihood.
        if !slots.eq(self.coordinates.slots().iter().cloned()) {
            return Self::new(likelihood, self.model, per_episode);
        }
        Self::assemble(self.coordinates.clone(), likelihood, self.model, per_episode)
    }

    fn assemble(
        coordinates: Coordinates,
        likelihood: &'a dyn Likelihood,
        model: &'a Model,
        per_episode: &BTreeSet<String>,
    ) -> Result<Self, InferError> {
        let per_episode_indices = per_episode_indices(&coordinates, per_episode)?;
        let (parts, episodes) = if per_episode_indices.is_empty() {
            (vec![Part::Whole(likelihood)], vec![])
        } else {
            let (names, parts): (Vec<_>, Vec<_>) = likelihood.split().into_iter().unzip();
            (parts.into_iter().map(Part::Episode).collect(), names)
        };
        let parameter_refs = parameter_refs(coordinates.free().len(), &per_episode_indices, episodes.len());
        let footprint_terms = footprint_terms(&coordinates, &parameter_refs, episodes.len());
        Ok(Self { model, coordinates, parts, parameter_refs, episodes, footprint_terms })
    }

    /// Coordinates of the parameters, as if all were shared.
    pub fn coordinates(&self) -> &Coordinates {
        &self.coordinates
    }

    /// The model.
    pub fn model(&self) -> &Model {
        self.model
    }

    /// Slot of the coordinate `k`; for a per-episode parameter it is named `slot[episode]`.
    pub fn slot(&self, k: usize) -> Slot {
        let place = self.parameter_refs[k];
        let slot = self.coordinates.slot(place.parameter).clone();
        match place.episode {
            Some(e) => Slot { name: format!("{}[{}]", slot.name, self.episodes[e]), ..slot },
            None => slot,
        }
    }

    /// Parameter of [`Coordinates`] of the coordinate `k`.
    pub fn parameter(&self, k: usize) -> usize {
        self.parameter_refs[k].parameter
    }

    /// Whether some parameters are per episode.
    pub fn has_per_episode(&self) -> bool {
        !self.episodes.is_empty()
    }

    /// Value of the coordinate `k` at `z`, and its derivative.
    pub fn value(&self, k: usize, z: f64) -> (f64, f64) {
        let parameter = self.parameter(k);
        let mut point = vec![0.0; self.coordinates.free().len()];
        point[parameter] = z;
        let (values, slopes) = self.coordinates.values(&point);
        (values[self.coordinates.free()[parameter]], slopes[parameter])
    }

    /// Point `z` of values of all slots; per-episode parameters have the same value in each episode.
    pub fn point(&self, values: &[f64]) -> Vec<f64> {
        let shared = self.coordinates.point(&self.padded(values));
        self.parameter_refs.iter().map(|p| shared[p.parameter]).collect()
    }

    /// A draw from the prior.
    pub fn draw(&self, rng: &mut impl rand::RngExt) -> Vec<f64> {
        let shared = self.coordinates.draw(rng);
        self.parameter_refs.iter().map(|p| shared[p.parameter]).collect()
    }

    /// A better starting point than `z`, with the strengths of laws scaled to the data.
    ///
    /// # Errors
    /// When the likelihood cannot be evaluated.
    pub(crate) fn rescaled(&self, z: Vec<f64>) -> Result<Vec<f64>, InferError> {
        let Some(Part::Whole(likelihood)) = self.parts.first() else { return Ok(z) };
        let (mut values, _) = self.shared_values(&z);
        values.truncate(self.model.slots().len());
        Ok(likelihood.rescaled(self.model, &values)?.map_or(z, |values| self.point(&values)))
    }

    /// Mean square of the whitened residuals at `z`; one if it is smaller, not finite, or not known.
    ///
    /// # Errors
    /// When the likelihood cannot be evaluated.
    pub(crate) fn misfit_factor(&self, z: &[f64]) -> Result<f64, InferError> {
        let (mut sum, mut count) = (0.0, 0);
        for (k, part) in self.parts.iter().enumerate() {
            let (own, residuals) = part.likelihood().chi_squared(self.model, &self.values(z, k).0)?;
            (sum, count) = (sum + own, count + residuals);
        }
        let mean = sum / count as f64;
        Ok(if mean.is_finite() { mean.max(1.0) } else { 1.0 })
    }

    /// Limits a coordinate to the searched range.
    pub fn clamp(&self, k: usize, z: f64) -> f64 {
        clamp_to_prior(z, self.coordinates.slot(self.parameter(k)))
    }

    /// −log prior density at `z`.
    pub fn prior_cost(&self, z: &[f64]) -> f64 {
        self.prior(z).cost
    }

    /// −log prior density at `z` with its derivatives.
    pub fn prior(&self, z: &[f64]) -> Linearised {
        let parameters: Vec<usize> = self.parameter_refs.iter().map(|p| p.parameter).collect();
        prior_of(&self.coordinates, &parameters, &self.footprint_terms, z)
    }

    /// Values of all slots in the episode `part`, and derivatives of the free ones by their `z`. Without per-episode
    /// parameters, all episodes have the same values.
    pub fn values(&self, z: &[f64], part: usize) -> (Vec<f64>, Vec<f64>) {
        let mut per_episode_indices = vec![0.0; self.coordinates.free().len()];
        for (place, &z) in self.parameters_of(part).zip(z) {
            if let Some(k) = place {
                per_episode_indices[k] = z;
            }
        }
        self.coordinates.values(&per_episode_indices)
    }

    /// For each coordinate, its parameter if the part uses it.
    fn parameters_of(&self, part: usize) -> impl Iterator<Item = Option<usize>> + '_ {
        self.parameter_refs.iter().map(move |p| p.episode.is_none_or(|e| e == part).then_some(p.parameter))
    }

    /// Values of all slots and derivatives at `z`; for a per-episode parameter, those of the first episode.
    pub fn shared_values(&self, z: &[f64]) -> (Vec<f64>, Vec<f64>) {
        self.values(z, 0)
    }

    /// `values` completed by the prior medians of the noise.
    fn padded(&self, values: &[f64]) -> Vec<f64> {
        let middle = self.coordinates.values(&vec![0.0; self.coordinates.free().len()]).0;
        values.iter().copied().chain(middle.into_iter().skip(values.len())).collect()
    }

    /// Adds one part's derivatives by its parameters to those by the coordinates.
    fn accumulate(
        &self,
        sum: &mut Linearised,
        part: usize,
        per_episode_indices: &Linearised,
        slopes: &[f64],
    ) {
        let parameters_of: Vec<(usize, usize)> =
            self.parameters_of(part).enumerate().filter_map(|(k, p)| p.map(|p| (k, p))).collect();
        sum.cost += per_episode_indices.cost;
        for &(i, a) in &parameters_of {
            sum.gradient[i] += per_episode_indices.gradient[a] * slopes[a];
            for &(j, b) in &parameters_of {
                sum.curvature[(i, j)] += per_episode_indices.curvature[(a, b)] * slopes[a] * slopes[b];
            }
        }
    }
}

impl Density for Target<'_> {
    fn dimension(&self) -> usize {
        self.parameter_refs.len()
    }

    fn cost(&self, z: &[f64]) -> Result<f64, InferError> {
        let mut cost = self.prior_cost(z);
        for (k, part) in self.parts.iter().enumerate() {
            cost += part.likelihood().cost(self.model, &self.values(z, k).0)?;
        }
        Ok(if cost.is_nan() { f64::INFINITY } else { cost })
    }

    fn linearise(&self, z: &[f64]) -> Result<Linearised, InferError> {
        self.evaluate(z, true)?.linearise()
    }

    fn evaluate<'a>(&'a self, z: &[f64], likely: bool) -> Result<Evaluation<'a>, InferError> {
        let evaluation = |(k, part): (usize, &'a Part<'_>)| {
            let (values, slopes) = self.values(z, k);
            let evaluation =
                part.likelihood().evaluate(self.model, &values, self.coordinates.free(), likely)?;
            Ok((evaluation, slopes))
        };
        let evaluations =
            self.parts.iter().enumerate().map(evaluation).collect::<Result<Vec<_>, InferError>>()?;
        let prior = self.prior(z);
        let cost = evaluations.iter().map(|(evaluation, _)| evaluation.cost).sum::<f64>() + prior.cost;
        let n = z.len();
        Ok(Evaluation::new(cost, move || {
            let mut sum = Linearised::sum(n, []);
            for (k, (evaluation, slopes)) in evaluations.into_iter().enumerate() {
                self.accumulate(&mut sum, k, &evaluation.linearise()?, &slopes);
            }
            Ok(Linearised::sum(n, [sum, prior]))
        }))
    }
}

/// Index of a footprint prior and the coordinates of its place; `None` for a fixed one.
pub(crate) type FootprintTerms = Vec<(usize, [Option<usize>; 2])>;

/// −log prior density at `z` with its derivatives. `parameters` gives the parameter of each coordinate.
pub(crate) fn prior_of(
    coordinates: &Coordinates,
    parameters: &[usize],
    footprint_terms: &FootprintTerms,
    z: &[f64],
) -> Linearised {
    let mut prior = Linearised::sum(z.len(), []);
    for (k, &parameter) in parameters.iter().enumerate() {
        let precision = coordinates.prior_precision(parameter);
        prior.cost += coordinates.prior_cost_of(parameter, z[k]);
        prior.gradient[k] += precision * z[k];
        prior.curvature[(k, k)] += precision;
    }
    for &(footprint_prior, at) in footprint_terms {
        let point = at.map(|k| k.map_or(0.0, |k| z[k]));
        let penalty = coordinates.footprint_penalty(&coordinates.footprint_priors()[footprint_prior], point);
        let ends = || at.into_iter().zip(penalty.slopes).filter_map(|(k, slope)| Some((k?, slope)));
        prior.cost += penalty.cost;
        for (i, a) in ends() {
            prior.gradient[i] += penalty.residual * a;
            for (j, b) in ends() {
                prior.curvature[(i, j)] += a * b;
            }
        }
    }
    prior
}

/// Indices of the per-episode parameters.
fn per_episode_indices(
    coordinates: &Coordinates,
    per_episode: &BTreeSet<String>,
) -> Result<BTreeSet<usize>, InferError> {
    let names: Vec<&str> = (0..coordinates.free().len()).map(|k| coordinates.slot(k).name.as_str()).collect();
    per_episode
        .iter()
        .map(|name| {
            names
                .iter()
                .position(|n| n == name)
                .ok_or_else(|| InferError::NotFree { name: name.clone(), free: names.join(", ") })
        })
        .collect()
}

/// Parameters of the coordinates: shared ones in order, then those of each episode.
fn parameter_refs(
    parameters: usize,
    per_episode_indices: &BTreeSet<usize>,
    episodes: usize,
) -> Vec<ParameterRef> {
    let shared = (0..parameters)
        .filter(|k| !per_episode_indices.contains(k))
        .map(|parameter| ParameterRef { parameter, episode: None });
    let each = (0..episodes).flat_map(|e| {
        per_episode_indices.iter().map(move |&parameter| ParameterRef { parameter, episode: Some(e) })
    });
    shared.chain(each).collect()
}

/// Coordinates of each place with a footprint prior, repeated for each episode with own values.
fn footprint_terms(
    coordinates: &Coordinates,
    parameter_refs: &[ParameterRef],
    episodes: usize,
) -> FootprintTerms {
    let mut found = BTreeSet::new();
    for (index, footprint_prior) in coordinates.footprint_priors().iter().enumerate() {
        for part in 0..episodes.max(1) {
            let parameters_of = |parameter| {
                parameter_refs
                    .iter()
                    .position(|p| p.parameter == parameter && p.episode.is_none_or(|e| e == part))
            };
            found.insert((
                index,
                coordinates
                    .coordinates_of(footprint_prior)
                    .map(|parameter| parameter.and_then(parameters_of)),
            ));
        }
    }
    found.into_iter().collect()
}
