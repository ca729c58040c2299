//! Place, time and parameters of an effect for the answer.

use crate::answer::{Moment, Place, Point, Quantity, Value};
use std::collections::BTreeMap;
use trundle_infer::Fit;
use trundle_model::{Kind, Model, Plant, Proposal, Role, obstacle_surface};
use trundle_record::Dataset;

/// An effect of a fitted model.
pub(crate) struct FittedEffect<'a> {
    pub fit: &'a Fit,
    pub kind: Kind,
    /// Its name within the model, for example `coulomb_friction_2`.
    pub name: &'a str,
}

impl FittedEffect<'_> {
    /// Mean and standard deviation of a parameter, if it is identifiable.
    fn identified(&self, param: &str) -> Option<(f64, f64)> {
        let estimate = self.fit.estimate(&format!("{}.{param}", self.name))?;
        estimate.identified.then_some((estimate.mean, estimate.sd))
    }

    /// A point, from the two parameters that are its coordinates.
    fn point(&self, coordinate: fn(usize) -> Role) -> Option<Point> {
        let coordinate_of = |axis| self.param_name(coordinate(axis)).and_then(|name| self.identified(name));
        let ((x, sx), (y, sy)) = (coordinate_of(0)?, coordinate_of(1)?);
        Some(Point { mean: [x, y], sd: [sx, sy] })
    }

    /// The parameter with a role.
    fn param_name(&self, role: Role) -> Option<&'static str> {
        self.kind.spec().params.iter().find(|p| p.role == role).map(|p| p.name)
    }

    /// Its values in the order of the catalogue.
    fn values(&self) -> Option<Vec<f64>> {
        let index = self.fit.model.effect_names().iter().position(|n| n == self.name)?;
        self.fit.model.effects[index].values.iter().copied().collect()
    }

    /// Where and when it acts, if identifiable.
    pub fn place(&self, data: &Dataset) -> Option<BTreeMap<&'static str, Place>> {
        let mut places = BTreeMap::new();
        let in_world = self.point(Role::WorldPoint);
        if let Some(region) = self.kind.region(&self.values()?) {
            in_world?;
            places.insert("world_region", Place::Region(region));
        } else if self.kind.proposal() == Proposal::ContactCandidate {
            places.insert("world_point", Place::Point(self.surface(data, in_world?)?));
        } else {
            places.extend(in_world.map(|point| ("world_point", Place::Point(point))));
            places.extend(self.point(Role::BodyPoint).map(|point| ("body_point", Place::Point(point))));
            places.extend(self.event(data).map(|event| ("event", event)));
        }
        (!places.is_empty()).then_some(places)
    }

    /// The point of an obstacle's surface that came nearest to the object.
    fn surface(&self, data: &Dataset, centre: Point) -> Option<Point> {
        let index = self.kind.spec().params.iter().position(|p| p.role == Role::Region)?;
        let radius = *self.values()?.get(index)?;
        let body = &self.fit.model.body;
        let poses = data.training.iter().flat_map(|e| &e.pose);
        let gap = |pose: [f64; 3]| {
            let (sin, cos) = pose[2].sin_cos();
            let (dx, dy) = (centre.mean[0] - pose[0], centre.mean[1] - pose[1]);
            body.outside([cos * dx + sin * dy, cos * dy - sin * dx]).0
        };
        let nearest = poses.min_by(|a, b| gap(a.pose).total_cmp(&gap(b.pose)))?;
        Some(Point { mean: obstacle_surface(body, centre.mean, radius, nearest.pose), sd: centre.sd })
    }

    fn event(&self, data: &Dataset) -> Option<Place> {
        let (mean, sd) = self.identified(self.param_name(Role::Time)?)?;
        let index = self.kind.spec().params.iter().position(|p| p.role.is_choice())?;
        let ordinal = self.values()?.get(index).copied()?;
        let episode = data.episode_name(ordinal)?.to_owned();
        Some(Place::Event { episode, time: Moment { mean, sd } })
    }

    /// Its identifiable parameters except for place and time.
    pub fn parameters(&self) -> BTreeMap<String, Value> {
        if self.kind.is_damping() && !self.kind.is_building_block() {
            let damping = damping(&self.fit.model).map(|mean| Value::Matrix { mean, sd: None, unit: "SI" });
            return damping.into_iter().map(|d| ("damping".to_owned(), d)).collect();
        }
        let prefix = format!("{}.", self.name);
        let spec = self.kind.spec();
        let own = self.fit.estimates.iter().filter(|e| e.identified && e.name.starts_with(&prefix));
        own.filter_map(|e| {
            let short = e.name.strip_prefix(&prefix)?;
            let role = spec.params.iter().find(|p| p.name == short)?.role;
            let is_place = matches!(role, Role::BodyPoint(_) | Role::WorldPoint(_) | Role::Time);
            // A mass centre is both a place and an amplitude.
            let strength = spec.neutral.iter().any(|(name, _)| *name == short);
            let value = Value::Number(Quantity { mean: e.mean, sd: e.sd, unit: e.unit });
            (!is_place || strength).then(|| (short.to_owned(), value))
        })
        .collect()
    }
}

/// The damping matrix of all viscous wheels together, about the object's origin.
fn damping(model: &Model) -> Option<[[f64; 3]; 3]> {
    let mut wheels = model.clone();
    wheels.effects.retain(|e| e.kind.is_damping());
    let plant: Plant<f64> = wheels.resolved().ok()?;
    let state = trundle_model::State::at_rest([0.0; 3]);
    let force = plant.generalised_force(&state, trundle_model::Clock::since_contact(1.0));
    let [xx, xy, yy, xt, yt, tt] = force.damping;
    Some([[xx, xy, xt], [xy, yy, yt], [xt, yt, tt]])
}
