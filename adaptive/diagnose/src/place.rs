//! Where and when an effect acts, and how large it is, for the answer.

use crate::answer::{Moment, Place, Point, Quantity, Value};
use std::collections::BTreeMap;
use trundle_infer::Fit;
use trundle_model::{Kind, Model, Plant, obstacle_surface, patch_outline};
use trundle_record::Dataset;

/// An effect of a fitted model.
pub(crate) struct Named<'a> {
    pub fit: &'a Fit,
    pub kind: Kind,
    /// Its name within the model: `coulomb_friction_2`.
    pub name: &'a str,
}

/// Pairs of parameters that are a place, and what it is called.
const PLACES: [(&str, &str, &str); 3] =
    [("x", "y", "body_point"), ("com_x", "com_y", "body_point"), ("anchor_x", "anchor_y", "world_point")];

impl Named<'_> {
    /// A parameter that the data hold: mean and standard deviation.
    fn held(&self, param: &str) -> Option<(f64, f64)> {
        let estimate = self.fit.estimate(&format!("{}.{param}", self.name))?;
        estimate.identified.then_some((estimate.mean, estimate.sd))
    }

    fn point(&self, x: &str, y: &str) -> Option<Point> {
        let ((x, sx), (y, sy)) = (self.held(x)?, self.held(y)?);
        Some(Point { mean: [x, y], sd: [sx, sy] })
    }

    /// Its values in the catalogue's order.
    fn values(&self) -> Option<Vec<f64>> {
        let index = self.fit.model.effect_names().iter().position(|n| n == self.name)?;
        self.fit.model.effects[index].values.iter().copied().collect()
    }

    /// Where it acts, if the data hold that.
    pub fn place(&self, data: &Dataset) -> Option<BTreeMap<&'static str, Place>> {
        let mut places = BTreeMap::new();
        match self.kind {
            Kind::FloorPatch => {
                self.point("x", "y")?;
                places.insert("world_region", Place::Region(patch_outline(&self.values()?)));
            }
            Kind::ObstacleContact => {
                places.insert("world_point", Place::Point(self.surface(data)?));
            }
            _ => {
                for (x, y, name) in PLACES {
                    if let Some(point) = self.point(x, y) {
                        places.insert(name, Place::Point(point));
                    }
                }
                places.extend(self.event(data).map(|event| ("event", event)));
            }
        }
        (!places.is_empty()).then_some(places)
    }

    /// The point of an obstacle's surface that came nearest to the body.
    fn surface(&self, data: &Dataset) -> Option<Point> {
        let centre = self.point("x", "y")?;
        let radius = self.held("radius").map_or_else(|| self.values().map(|v| v[2]), |(r, _)| Some(r))?;
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
        let (mean, sd) = self.held("time")?;
        let names = self.kind.spec().params;
        let index = names.iter().position(|p| p.name == "episode")?;
        let ordinal = self.values()?.get(index).copied()?;
        let episode = data.episodes().find(|e| e.ordinal as f64 == ordinal)?;
        Some(Place::Event { episode: episode.name.clone(), time: Moment { mean, sd } })
    }

    /// Its parameters that the data hold, but for those that say where or when.
    pub fn parameters(&self) -> BTreeMap<String, Value> {
        if self.kind == Kind::SpinDrag {
            let damping = damping(&self.fit.model).map(|mean| Value::Matrix { mean, sd: None, unit: "SI" });
            return damping.into_iter().map(|d| ("damping".to_owned(), d)).collect();
        }
        let prefix = format!("{}.", self.name);
        let own = self.fit.estimates.iter().filter(|e| e.identified && e.name.starts_with(&prefix));
        own.filter_map(|e| {
            let short = e.name.strip_prefix(&prefix)?;
            let placed = matches!(short, "x" | "y" | "anchor_x" | "anchor_y" | "time");
            let value = Value::Number(Quantity { mean: e.mean, sd: e.sd, unit: e.unit });
            (!placed).then(|| (short.to_owned(), value))
        })
        .collect()
    }
}

/// The damping matrix of all viscous wheels together, about the object origin.
fn damping(model: &Model) -> Option<[[f64; 3]; 3]> {
    let mut wheels = model.clone();
    wheels.effects.retain(|e| matches!(e.kind, Kind::ViscousWheel | Kind::SpinDrag));
    let plant: Plant<f64> = wheels.resolved().ok()?;
    let state = trundle_model::State::at_rest([0.0; 3]);
    let action = plant.action(&state, trundle_model::Clock::since_contact(1.0));
    let [xx, xy, yy, xt, yt, tt] = action.drag;
    Some([[xx, xy, xt], [xy, yy, yt], [xt, yt, tt]])
}
