//! Objects of the tasks: household objects, objects from files, and random ones.

use std::path::Path;
use std::sync::Arc;

use rand::RngExt;
use rand::seq::IndexedRandom;
use rand_chacha::ChaCha8Rng;
use trundle_model::{Body, Effect, Fixture, Kind};

use super::constants::OUTLINE_ENTRIES;
use super::object_sets::ObjectSet;
use super::options::Options;
use crate::{Object, SimError};

/// The ten objects of the paper's Fig. 7.
const HOUSEHOLD_FILES: [(&str, &str); 10] = [
    ("bed", include_str!("../../objects/bed.toml")),
    ("bookcase", include_str!("../../objects/bookcase.toml")),
    ("chair", include_str!("../../objects/chair.toml")),
    ("couch", include_str!("../../objects/couch.toml")),
    ("desk", include_str!("../../objects/desk.toml")),
    ("kitchen_table", include_str!("../../objects/kitchen_table.toml")),
    ("office_table", include_str!("../../objects/office_table.toml")),
    ("shopping_cart", include_str!("../../objects/shopping_cart.toml")),
    ("utility_cart", include_str!("../../objects/utility_cart.toml")),
    ("wheelchair", include_str!("../../objects/wheelchair.toml")),
];

/// Name of random objects.
const RANDOM_NAME: &str = "random";
/// Name of the set of all household objects.
const HOUSEHOLD_NAME: &str = "household";

/// Names of the household objects.
pub fn household_names() -> impl Iterator<Item = &'static str> {
    HOUSEHOLD_FILES.iter().map(|(name, _)| *name)
}

/// The visible properties of an object, and its possible effects.
#[derive(Clone, Debug)]
pub struct TaskObject {
    /// Shape and mass.
    pub body: Body,
    /// Positions of wheels or legs, object frame, m.
    pub feet: Vec<[f64; 2]>,
    /// Effects of each configuration.
    pub configurations: Vec<Vec<Effect>>,
    /// Distance from the middle of the bounds to the outermost point of the outline in equally spaced directions, m.
    pub outline: [f64; OUTLINE_ENTRIES],
}

impl TaskObject {
    /// An object with these configurations.
    fn new(body: Body, configurations: Vec<Vec<Effect>>) -> Self {
        let feet = body.feet.clone().unwrap_or_else(|| default_feet(&body));
        let outline = outline_radii(&body);
        Self { body, feet, configurations, outline }
    }

    fn from_object(object: &Object) -> Result<Self, SimError> {
        let body = object.model(None)?.body;
        let effects = |name: &String| Ok(object.model(Some(name))?.effects);
        let configurations = object.configurations.iter().map(effects).collect::<Result<_, SimError>>()?;
        Ok(Self::new(body, configurations))
    }

    /// Whether a wheel has a preferred direction in some configuration. An object without configurations counts as such.
    pub fn has_directional_wheel(&self) -> bool {
        let holds = |e: &Effect| e.kind == Kind::ViscousWheel && e.values.get(3) != e.values.get(4);
        self.configurations.is_empty() || self.configurations.iter().flatten().any(holds)
    }

    /// Default grasp: the rim point behind the mass centre, object frame, m.
    pub fn default_grasp(&self) -> [f64; 2] {
        self.rim_point(std::f64::consts::PI)
    }

    /// Grasp at these fractions of half the sides from the centre of the bounds, projected onto the object, object frame, m.
    pub fn grasp_point(&self, shares: [f64; 2]) -> [f64; 2] {
        let [low, high] = self.body.bounds();
        let place = [0, 1].map(|k| (low[k] + high[k]) / 2.0 + shares[k] * (high[k] - low[k]) / 2.0);
        let (distance, normal) = self.body.outside(place);
        [0, 1].map(|k| place[k] - distance * normal[k])
    }

    /// Outermost point of the rim at this angle about the mass centre, object frame, m.
    pub fn rim_point(&self, angle: f64) -> [f64; 2] {
        let (sin, cos) = angle.sin_cos();
        let [x, y] = self.body.com;
        let far = rim_distance(&self.body, [x, y], [cos, sin], 256);
        [x + far * cos, y + far * sin]
    }
}

/// Distance from a point to the outermost point of the outline in a direction, m; 0 if there is none. The search steps
/// inwards in `strides` steps to the first point inside, then bisects.
fn rim_distance(body: &Body, [x, y]: [f64; 2], [cos, sin]: [f64; 2], strides: u32) -> f64 {
    let inside = |far: f64| body.outside([x + far * cos, y + far * sin]).0 <= 0.0;
    let (mut low, mut high) = (0.0, 2.0 * crate::obstacle_distance::outline_radius(body));
    let stride = high / f64::from(strides);
    while high > stride && !inside(high - stride) {
        high -= stride;
    }
    if high > stride {
        low = high - stride;
    }
    for _ in 0..40 {
        let middle = (low + high) / 2.0;
        if inside(middle) { low = middle } else { high = middle }
    }
    low
}

/// Distances of [`TaskObject::outline`].
fn outline_radii(body: &Body) -> [f64; OUTLINE_ENTRIES] {
    let [low, high] = body.bounds();
    let middle = [0, 1].map(|k| (low[k] + high[k]) / 2.0);
    std::array::from_fn(|k| {
        let (sin, cos) = (std::f64::consts::TAU * k as f64 / OUTLINE_ENTRIES as f64).sin_cos();
        rim_distance(body, middle, [cos, sin], 64)
    })
}

/// Default positions of feet: the corners of the bounds, inset by 15 % of the sides.
fn default_feet(body: &Body) -> Vec<[f64; 2]> {
    let [low, high] = body.bounds();
    let middle = [0, 1].map(|k| (low[k] + high[k]) / 2.0);
    let at = |sx: f64, sy: f64| {
        [middle[0] + 0.35 * sx * (high[0] - low[0]), middle[1] + 0.35 * sy * (high[1] - low[1])]
    };
    vec![at(-1.0, -1.0), at(1.0, -1.0), at(1.0, 1.0), at(-1.0, 1.0)]
}

/// Range of the mass of random objects, kg.
const RANDOM_MASS_KG: [f64; 2] = [8.0, 60.0];

/// Set of objects to draw from.
#[derive(Clone, Debug)]
pub struct TaskObjects(Vec<Source>);

/// A source of objects.
#[derive(Clone, Debug)]
enum Source {
    /// Always the same object.
    Fixed(Arc<TaskObject>),
    /// Random objects with a mass in this range, kg.
    Random([f64; 2]),
    /// Objects of a level.
    Set(&'static ObjectSet),
}

impl TaskObjects {
    /// Objects of the level, or else by name or file.
    ///
    /// # Errors
    /// If there is no such object. The message lists the names.
    pub fn new(options: &Options) -> Result<Self, SimError> {
        if let Some(level) = options.level {
            return Ok(Self(vec![Source::Set(level.object_set(options.split))]));
        }
        let mut objects = vec![];
        for name in &options.object {
            match name.as_str() {
                RANDOM_NAME => objects.push(Source::Random(options.mass.unwrap_or(RANDOM_MASS_KG))),
                HOUSEHOLD_NAME => {
                    for (name, text) in HOUSEHOLD_FILES {
                        let object = TaskObject::from_object(&Object::parse(name, text)?)?;
                        objects.push(Source::Fixed(Arc::new(object)));
                    }
                }
                _ => objects.push(Source::Fixed(Arc::new(TaskObject::from_object(&read_object(name)?)?))),
            }
        }
        Ok(Self(objects))
    }

    /// The object, if there is only one.
    pub fn only(&self) -> Option<&Arc<TaskObject>> {
        if let [Source::Fixed(object)] = self.0.as_slice() { Some(object) } else { None }
    }

    /// Draw an object.
    pub fn draw(&self, rng: &mut ChaCha8Rng) -> Result<Arc<TaskObject>, SimError> {
        match self.0.choose(rng) {
            Some(Source::Fixed(object)) => Ok(object.clone()),
            Some(Source::Random(mass)) => Ok(Arc::new(draw_random_object(*mass, rng)?)),
            Some(Source::Set(set)) => Ok(Arc::new(TaskObject::new(set.draw(rng)?, vec![]))),
            None => Err(SimError::value("object", "", "name at least one object, or \"random\"")),
        }
    }
}

/// A household object by name, or the object of a file.
pub(crate) fn read_object(name: &str) -> Result<Object, SimError> {
    if let Some((name, text)) = HOUSEHOLD_FILES.iter().find(|(known, _)| *known == name) {
        return Object::parse(name, text);
    }
    if name.ends_with(".toml") {
        return Object::read(Path::new(name));
    }
    let remedy = "not a household object: choose bed, bookcase, chair, couch, desk, kitchen_table, office_table, \
                  shopping_cart, utility_cart or wheelchair, \"household\" for all, \"random\", or an object's file.toml";
    Err(SimError::value("object", name, remedy))
}

/// Draw a rectangular, L-shaped, tapered or round-ended object with a mass in this range, kg, on four wheels near its
/// corners.
fn draw_random_object([light, heavy]: [f64; 2], rng: &mut ChaCha8Rng) -> Result<TaskObject, SimError> {
    let (a, b) = (rng.random_range(0.3..=0.7), rng.random_range(0.2..=0.45));
    let mass = rng.random_range(light.ln()..=heavy.ln()).exp();
    let polygon = |vertices: Vec<[f64; 2]>| Fixture::Polygon { vertices, density: 1.0 };
    let fixtures = match rng.random_range(0..4) {
        0 => vec![polygon(vec![[-a, -b], [a, -b], [a, b], [-a, b]])],
        1 => {
            let (x, y) = (rng.random_range(-0.4..=0.4) * a, rng.random_range(-0.4..=0.4) * b);
            vec![polygon(vec![[-a, -b], [a, -b], [a, y], [x, y], [x, b], [-a, b]])]
        }
        2 => {
            let front = b * rng.random_range(0.5..=0.9);
            vec![polygon(vec![[-a, -b], [a, -front], [a, front], [-a, b]])]
        }
        _ => {
            let round = Fixture::Disc { center: [a, 0.0], radius: b, density: 1.0 };
            vec![polygon(vec![[-a, -b], [a, -b], [a, b], [-a, b]]), round]
        }
    };
    let inset = rng.random_range(0.75..=0.9);
    let (x, y) = (a * inset, b * inset * 0.6);
    // The L has no material at one corner, so that wheel is further back.
    let inner = [-0.4 * a, y];
    let body = Body::from_fixtures(fixtures, mass)?;
    let feet = [[-x, -y], [x, -y], [x, y], [-x, y]];
    let feet = feet.map(|p| if body.outside(p).0 > 0.0 { inner } else { p });
    Ok(TaskObject::new(body.with_feet(&feet), vec![]))
}
