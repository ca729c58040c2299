//! Objects of the tasks: household objects, objects from files, and random ones.

use std::path::Path;
use std::sync::Arc;

use rand::RngExt;
use rand::seq::IndexedRandom;
use rand_chacha::ChaCha8Rng;
use trundle_model::{Body, Effect, Fixture, Kind};

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
}

impl TaskObject {
    fn new(body: Body, configurations: Vec<Vec<Effect>>) -> Self {
        let feet = body.feet.clone().unwrap_or_else(|| default_feet(&body));
        Self { body, feet, configurations }
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
        let inside = |far: f64| self.body.outside([x + far * cos, y + far * sin]).0 <= 0.0;
        let (mut low, mut high) = (0.0, 2.0 * crate::obstacle_distance::outline_radius(&self.body));
        // Step inwards from outside to the first point inside, then bisect.
        let stride = high / 256.0;
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
        [x + low * cos, y + low * sin]
    }
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

/// Set of objects to draw from. `None` stands for a random object.
#[derive(Clone, Debug)]
pub struct TaskObjects(Vec<Option<Arc<TaskObject>>>);

impl TaskObjects {
    /// Objects by name or file.
    ///
    /// # Errors
    /// If there is no such object. The message lists the names.
    pub fn named(names: &[String]) -> Result<Self, SimError> {
        let mut objects = vec![];
        for name in names {
            match name.as_str() {
                RANDOM_NAME => objects.push(None),
                HOUSEHOLD_NAME => {
                    for (name, text) in HOUSEHOLD_FILES {
                        objects.push(Some(Arc::new(TaskObject::from_object(&Object::parse(name, text)?)?)));
                    }
                }
                _ => objects.push(Some(Arc::new(TaskObject::from_object(&read_object(name)?)?))),
            }
        }
        Ok(Self(objects))
    }

    /// The object, if there is only one.
    pub fn only(&self) -> Option<&Arc<TaskObject>> {
        if let [Some(object)] = self.0.as_slice() { Some(object) } else { None }
    }

    /// Draw an object.
    pub fn draw(&self, rng: &mut ChaCha8Rng) -> Result<Arc<TaskObject>, SimError> {
        match self.0.choose(rng) {
            Some(Some(object)) => Ok(object.clone()),
            _ => Ok(Arc::new(draw_random_object(rng)?)),
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

/// Draw a rectangular, L-shaped, tapered or round-ended object of 8 to 60 kg on four wheels near its corners.
fn draw_random_object(rng: &mut ChaCha8Rng) -> Result<TaskObject, SimError> {
    let (a, b) = (rng.random_range(0.3..=0.7), rng.random_range(0.2..=0.45));
    let mass = rng.random_range(8f64.ln()..=60f64.ln()).exp();
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
