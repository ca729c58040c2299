//! What can be pushed: the household objects, objects of a file, and random ones.

use std::path::Path;
use std::sync::Arc;

use rand::RngExt;
use rand::seq::IndexedRandom;
use rand_chacha::ChaCha8Rng;
use trundle_model::{Body, Effect, Fixture, Kind};

use crate::{Object, SimError};

/// The ten objects of the paper's Fig. 7.
const HOUSEHOLD: [(&str, &str); 10] = [
    ("bed", include_str!("../../../../configs/objects/bed.toml")),
    ("bookcase", include_str!("../../../../configs/objects/bookcase.toml")),
    ("chair", include_str!("../../../../configs/objects/chair.toml")),
    ("couch", include_str!("../../../../configs/objects/couch.toml")),
    ("desk", include_str!("../../../../configs/objects/desk.toml")),
    ("kitchen_table", include_str!("../../../../configs/objects/kitchen_table.toml")),
    ("office_table", include_str!("../../../../configs/objects/office_table.toml")),
    ("shopping_cart", include_str!("../../../../configs/objects/shopping_cart.toml")),
    ("utility_cart", include_str!("../../../../configs/objects/utility_cart.toml")),
    ("wheelchair", include_str!("../../../../configs/objects/wheelchair.toml")),
];

/// Name under which objects are made up.
const RANDOM: &str = "random";
/// Name for all ten.
const HOUSE: &str = "household";

/// Names of the household objects.
pub fn household() -> impl Iterator<Item = &'static str> {
    HOUSEHOLD.iter().map(|(name, _)| *name)
}

/// An object as anybody can see it, and what may act on it.
#[derive(Clone, Debug)]
pub struct Thing {
    /// Shape and mass.
    pub body: Body,
    /// Where wheels or legs stand, object frame, m.
    pub feet: Vec<[f64; 2]>,
    /// Effects of each of its configurations.
    pub configurations: Vec<Vec<Effect>>,
}

impl Thing {
    fn new(body: Body, configurations: Vec<Vec<Effect>>) -> Self {
        let feet = body.feet.clone().unwrap_or_else(|| corners(&body));
        Self { body, feet, configurations }
    }

    fn from_object(object: &Object) -> Result<Self, SimError> {
        let body = object.model(None)?.body;
        let effects = |name: &String| Ok(object.model(Some(name))?.effects);
        let configurations = object.configurations.iter().map(effects).collect::<Result<_, SimError>>()?;
        Ok(Self::new(body, configurations))
    }

    /// Whether a wheel holds it to a direction in some configuration.
    pub fn rolls(&self) -> bool {
        let holds = |e: &Effect| e.kind == Kind::ViscousWheel && e.values.get(3) != e.values.get(4);
        self.configurations.is_empty() || self.configurations.iter().flatten().any(holds)
    }

    /// Where a gripper holds it unless told: the middle of the rear edge.
    pub fn rear(&self) -> [f64; 2] {
        self.rim(std::f64::consts::PI)
    }

    /// The point at these shares of half its sides from the middle of its bounds, or the nearest of its points, object
    /// frame, m.
    pub fn place(&self, shares: [f64; 2]) -> [f64; 2] {
        let [low, high] = self.body.bounds();
        let place = [0, 1].map(|k| (low[k] + high[k]) / 2.0 + shares[k] * (high[k] - low[k]) / 2.0);
        let (beside, way) = self.body.outside(place);
        [0, 1].map(|k| place[k] - beside * way[k])
    }

    /// The outermost point of the rim at this angle about the mass centre, object frame, m.
    pub fn rim(&self, angle: f64) -> [f64; 2] {
        let (sin, cos) = angle.sin_cos();
        let [x, y] = self.body.com;
        let inside = |far: f64| self.body.outside([x + far * cos, y + far * sin]).0 <= 0.0;
        let (mut low, mut high) = (0.0, 2.0 * crate::contact::reach(&self.body));
        // From far outside inwards to the first point within, then between the two.
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

/// Corners of the bounds, 15 % inwards: where an object that says nothing of its wheels may have them.
fn corners(body: &Body) -> Vec<[f64; 2]> {
    let [low, high] = body.bounds();
    let middle = [0, 1].map(|k| (low[k] + high[k]) / 2.0);
    let at = |sx: f64, sy: f64| {
        [middle[0] + 0.35 * sx * (high[0] - low[0]), middle[1] + 0.35 * sy * (high[1] - low[1])]
    };
    vec![at(-1.0, -1.0), at(1.0, -1.0), at(1.0, 1.0), at(-1.0, 1.0)]
}

/// What objects are drawn from.
#[derive(Clone, Debug)]
pub struct Things(Vec<Option<Arc<Thing>>>);

impl Things {
    /// From names and files; `None` stands for a random object.
    ///
    /// # Errors
    /// When there is no such object; the message lists those that there are.
    pub fn named(names: &[String]) -> Result<Self, SimError> {
        let mut things = vec![];
        for name in names {
            match name.as_str() {
                RANDOM => things.push(None),
                HOUSE => {
                    for (name, text) in HOUSEHOLD {
                        things.push(Some(Arc::new(Thing::from_object(&Object::parse(name, text)?)?)));
                    }
                }
                _ => things.push(Some(Arc::new(Thing::from_object(&object(name)?)?))),
            }
        }
        Ok(Self(things))
    }

    /// The object, where there is but one.
    pub fn only(&self) -> Option<&Arc<Thing>> {
        if let [Some(thing)] = self.0.as_slice() { Some(thing) } else { None }
    }

    /// One of them.
    pub fn draw(&self, random: &mut ChaCha8Rng) -> Result<Arc<Thing>, SimError> {
        match self.0.choose(random) {
            Some(Some(thing)) => Ok(thing.clone()),
            _ => Ok(Arc::new(made_up(random)?)),
        }
    }
}

fn object(name: &str) -> Result<Object, SimError> {
    if let Some((name, text)) = HOUSEHOLD.iter().find(|(known, _)| *known == name) {
        return Object::parse(name, text);
    }
    if name.ends_with(".toml") {
        return Object::read(Path::new(name));
    }
    let remedy = "is no household object: choose bed, bookcase, chair, couch, desk, kitchen_table, office_table, \
                  shopping_cart, utility_cart or wheelchair, \"household\" for all, \"random\", or an object's file.toml";
    Err(SimError::value("object", name, remedy))
}

/// A rectangle, an L, a tapering top or one with a round end, of 8 to 60 kg, on four wheels near its corners.
fn made_up(random: &mut ChaCha8Rng) -> Result<Thing, SimError> {
    let (a, b) = (random.random_range(0.3..=0.7), random.random_range(0.2..=0.45));
    let mass = random.random_range(8f64.ln()..=60f64.ln()).exp();
    let polygon = |vertices: Vec<[f64; 2]>| Fixture::Polygon { vertices, density: 1.0 };
    let fixtures = match random.random_range(0..4) {
        0 => vec![polygon(vec![[-a, -b], [a, -b], [a, b], [-a, b]])],
        1 => {
            let (x, y) = (random.random_range(-0.4..=0.4) * a, random.random_range(-0.4..=0.4) * b);
            vec![polygon(vec![[-a, -b], [a, -b], [a, y], [x, y], [x, b], [-a, b]])]
        }
        2 => {
            let front = b * random.random_range(0.5..=0.9);
            vec![polygon(vec![[-a, -b], [a, -front], [a, front], [-a, b]])]
        }
        _ => {
            let round = Fixture::Disc { center: [a, 0.0], radius: b, density: 1.0 };
            vec![polygon(vec![[-a, -b], [a, -b], [a, b], [-a, b]]), round]
        }
    };
    let inset = random.random_range(0.75..=0.9);
    let (x, y) = (a * inset, b * inset * 0.6);
    // The L lacks a corner: its wheel stands further back.
    let inner = [-0.4 * a, y];
    let body = Body::from_fixtures(fixtures, mass)?;
    let feet = [[-x, -y], [x, -y], [x, y], [-x, y]];
    let feet = feet.map(|p| if body.outside(p).0 > 0.0 { inner } else { p });
    Ok(Thing::new(body.with_feet(&feet), vec![]))
}
