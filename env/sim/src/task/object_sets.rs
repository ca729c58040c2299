//! Levels of difficulty: training and test sets of objects that share no outline family, mass range or wheel layout.

use std::ops::RangeInclusive;

use rand::RngExt;
use rand::seq::IndexedRandom;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};
use trundle_model::{Body, Fixture};

use crate::SimError;

/// Level of difficulty.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Level {
    /// One convex outline, little variation of mass and friction.
    Easy,
    /// Two convex outlines.
    Medium,
    /// Concave outlines, and the full ranges.
    Hard,
}

/// Set of objects of a level.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Split {
    /// Objects for training and tuning.
    #[default]
    Train,
    /// Objects for the evaluation.
    Test,
}

/// Family of outlines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outline {
    /// Rectangle.
    Rectangle,
    /// Trapezium that is narrower in front.
    Tapered,
    /// Rectangle with a round front.
    RoundEnded,
    /// L.
    Angle,
    /// Rectangle with cut corners.
    Octagon,
    /// Triangle with cut corners.
    Triangle,
    /// T.
    Tee,
    /// U, open at the rear left side.
    Channel,
}

/// Arrangement of the wheels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WheelLayout {
    /// Four wheels near the corners.
    Corners,
    /// Two wheels at the rear and one in front.
    Tricycle,
    /// Four wheels at the middles of the sides.
    Diamond,
    /// Six wheels in two rows.
    Rows,
}

/// Objects of a level and split.
#[derive(Debug)]
pub struct ObjectSet {
    /// Level.
    pub level: Level,
    /// Training or test set.
    pub split: Split,
    /// Outlines, drawn with equal probability.
    pub outlines: &'static [Outline],
    /// Range of the mass, drawn log-uniformly, kg.
    pub mass: (f64, f64),
    /// Wheel layouts, drawn with equal probability.
    pub wheels: &'static [WheelLayout],
    /// Range of the friction of a locked wheel, N·s/m.
    pub friction: (f64, f64),
}

use Outline::*;
use WheelLayout::*;

/// All sets. Every training set is disjoint from every test set in outlines, masses and wheel layouts.
pub const OBJECT_SETS: [ObjectSet; 6] = [
    set(Level::Easy, Split::Train, &[Rectangle], (18.0, 24.0), &[Corners]),
    set(Level::Easy, Split::Test, &[Octagon], (28.0, 32.0), &[Diamond]),
    set(Level::Medium, Split::Train, &[Rectangle, Tapered], (14.0, 25.0), &[Corners, Tricycle]),
    set(Level::Medium, Split::Test, &[Octagon, Triangle], (28.0, 40.0), &[Diamond, Rows]),
    set(
        Level::Hard,
        Split::Train,
        &[Rectangle, Tapered, RoundEnded, Angle],
        (10.0, 26.0),
        &[Corners, Tricycle],
    ),
    set(Level::Hard, Split::Test, &[Octagon, Triangle, Tee, Channel], (28.0, 60.0), &[Diamond, Rows]),
];

const fn set(
    level: Level,
    split: Split,
    outlines: &'static [Outline],
    mass: (f64, f64),
    wheels: &'static [WheelLayout],
) -> ObjectSet {
    let friction = match level {
        Level::Easy => (60.0, 120.0),
        Level::Medium => (60.0, 200.0),
        Level::Hard => (60.0, 300.0),
    };
    ObjectSet { level, split, outlines, mass, wheels, friction }
}

/// Half the length and width of objects, m.
const HALF_LENGTH_M: RangeInclusive<f64> = 0.35..=0.65;
const HALF_WIDTH_M: RangeInclusive<f64> = 0.25..=0.42;
/// Distance from the rim to a wheel that would lie outside, m.
const WHEEL_INSET_M: f64 = 0.03;

impl Level {
    /// The set of this level and a split.
    pub fn object_set(self, split: Split) -> &'static ObjectSet {
        let same = |set: &&ObjectSet| set.level == self && set.split == split;
        OBJECT_SETS.iter().find(same).unwrap_or(&OBJECT_SETS[0])
    }
}

impl ObjectSet {
    /// Draw a body with the positions of its wheels.
    ///
    /// # Errors
    /// If its shape is invalid.
    pub fn draw(&self, rng: &mut ChaCha8Rng) -> Result<Body, SimError> {
        let half = [rng.random_range(HALF_LENGTH_M), rng.random_range(HALF_WIDTH_M)];
        let mass = rng.random_range(self.mass.0.ln()..=self.mass.1.ln()).exp();
        let outline = self.outlines.choose(rng).copied().unwrap_or(Rectangle);
        let body = Body::from_fixtures(outline.fixtures(half, rng), mass)?;
        let wheels = self.wheels.choose(rng).copied().unwrap_or(Corners);
        let feet: Vec<[f64; 2]> = wheels.positions(half).into_iter().map(|p| onto(&body, p)).collect();
        Ok(body.with_feet(&feet))
    }
}

/// The position, or the nearest one well inside the body.
fn onto(body: &Body, [x, y]: [f64; 2]) -> [f64; 2] {
    let (distance, normal) = body.outside([x, y]);
    if distance <= 0.0 {
        return [x, y];
    }
    [x - (distance + WHEEL_INSET_M) * normal[0], y - (distance + WHEEL_INSET_M) * normal[1]]
}

impl Outline {
    /// Fixtures of an outline with half the length `a` and half the width `b`, m.
    fn fixtures(self, [a, b]: [f64; 2], rng: &mut ChaCha8Rng) -> Vec<Fixture> {
        let (u, v) = (rng.random_range(0.0..=1.0), rng.random_range(0.0..=1.0));
        let vertices = match self {
            Rectangle | RoundEnded => vec![[-a, -b], [a, -b], [a, b], [-a, b]],
            Tapered => {
                let front = b * (0.5 + 0.4 * u);
                vec![[-a, -b], [a, -front], [a, front], [-a, b]]
            }
            Angle => {
                let (x, y) = (0.4 * (2.0 * u - 1.0) * a, 0.4 * (2.0 * v - 1.0) * b);
                vec![[-a, -b], [a, -b], [a, y], [x, y], [x, b], [-a, b]]
            }
            Octagon => {
                let (c, d) = (a * (0.4 + 0.2 * u), b * (0.4 + 0.2 * v));
                vec![[-a, -d], [-c, -b], [c, -b], [a, -d], [a, d], [c, b], [-c, b], [-a, d]]
            }
            Triangle => {
                let (tip, side) = (b * (0.1 + 0.1 * u), 0.15 * a);
                vec![[-a, -b], [-a + side, -b], [a, -tip], [a, tip], [-a + side, b], [-a, b]]
            }
            Tee => {
                let (neck, x) = (b * (0.35 + 0.2 * u), -0.2 * a - 0.3 * a * v);
                vec![[-a, -b], [x, -b], [x, -neck], [a, -neck], [a, neck], [x, neck], [x, b], [-a, b]]
            }
            Channel => {
                let (x, depth) = (a * (0.4 + 0.2 * u), -b * (0.1 + 0.3 * v));
                vec![[-a, -b], [a, -b], [a, b], [x, b], [x, depth], [-x, depth], [-x, b], [-a, b]]
            }
        };
        let mut fixtures = vec![Fixture::Polygon { vertices, density: 1.0 }];
        if self == RoundEnded {
            fixtures.push(Fixture::Disc { center: [a, 0.0], radius: b, density: 1.0 });
        }
        fixtures
    }
}

impl WheelLayout {
    /// Positions of the wheels on a rectangle with these half sides, m.
    fn positions(self, [a, b]: [f64; 2]) -> Vec<[f64; 2]> {
        let (x, y) = (0.8 * a, 0.75 * b);
        match self {
            Corners => vec![[-x, -y], [x, -y], [x, y], [-x, y]],
            Tricycle => vec![[-x, -y], [x, 0.0], [-x, y]],
            Diamond => vec![[-x, 0.0], [0.0, -y], [x, 0.0], [0.0, y]],
            Rows => vec![[-x, -y], [0.0, -y], [x, -y], [x, y], [0.0, y], [-x, y]],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;

    #[test]
    fn training_and_test_sets_share_nothing() {
        let of = |split| OBJECT_SETS.iter().filter(move |set| set.split == split);
        for train in of(Split::Train) {
            for test in of(Split::Test) {
                assert!(train.mass.1 < test.mass.0 || test.mass.1 < train.mass.0, "{train:?} {test:?}");
                assert!(!train.outlines.iter().any(|one| test.outlines.contains(one)), "{train:?} {test:?}");
                assert!(!train.wheels.iter().any(|one| test.wheels.contains(one)), "{train:?} {test:?}");
            }
        }
    }

    #[test]
    fn the_office_table_is_in_no_test_set() {
        // 22 kg, also the default mass of an adaptive agent; a rectangle on four wheels near its corners.
        for set in OBJECT_SETS.iter().filter(|set| set.split == Split::Test) {
            assert!(!(set.mass.0..=set.mass.1).contains(&22.0), "{set:?}");
            assert!(!set.outlines.contains(&Rectangle) && !set.wheels.contains(&Corners), "{set:?}");
        }
    }

    #[test]
    fn objects_have_the_properties_of_their_set() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        for set in &OBJECT_SETS {
            for _ in 0..200 {
                let body = set.draw(&mut rng).unwrap();
                assert!((set.mass.0..=set.mass.1).contains(&body.mass), "{set:?}");
                let feet = body.feet.clone().unwrap();
                assert!(feet.iter().all(|&foot| body.outside(foot).0 <= 0.0), "{body:?}");
                crate::colliders::object_colliders(&body).unwrap();
            }
        }
    }
}
