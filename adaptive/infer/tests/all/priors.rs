//! Priors in the coordinates of the search: inverse, derivatives, normalisation, and valid values.

#![allow(clippy::unwrap_used)]

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use trundle_infer::Coordinates;
use trundle_model::{Body, Effect, Fixture, Kind, Model, PriorFile};

const TABLE: [[f64; 2]; 4] = [[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]];
const L: [[f64; 2]; 6] = [[-0.6, -0.4], [0.6, -0.4], [0.6, 0.0], [0.0, 0.0], [0.0, 0.4], [-0.6, 0.4]];

const EVERY: &str = r#"
[body]
mass = { distribution = "normal", mean = 2, sd = 3, high = 9 }
[viscous_wheel]
x = { distribution = "uniform", low = -0.6, high = 0.1 }
angle = { distribution = "uniform", low = -0.3, high = 0.3 }
mu_x = { distribution = "log_normal", median = 20, sd = 0.5, low = 10, high = 25 }
[force_bias]
force_x = { distribution = "normal", mean = 1, sd = 2 }
"#;

fn model(shape: &[[f64; 2]]) -> Model {
    let body = Body::from_footprint(shape, 22.0).unwrap();
    Model::nominal(body, None, [true; 3]).with(Effect::free(Kind::ForceBias))
}

fn with_priors(shape: &[[f64; 2]]) -> Model {
    PriorFile::from_toml(EVERY, "every.toml").unwrap().apply(&model(shape)).unwrap()
}

/// A model in which only the position of the wheel is free.
fn wheel_alone(body: Body) -> Model {
    let wheel =
        ["angle", "mu_x", "mu_y"].iter().fold(Effect::free(Kind::ViscousWheel), |e, p| e.with(p, Some(1.0)));
    Model { effects: vec![wheel], mass: Some(22.0), ..Model::nominal(body, None, [true; 3]) }
}

fn ramp(n: usize, from: f64, to: f64) -> impl Iterator<Item = f64> {
    (0..n).map(move |k| from + (to - from) * (k as f64 + 0.5) / n as f64)
}

#[test]
fn values_and_points_invert_each_other_and_slopes_are_right() {
    for model in [model(&TABLE), with_priors(&TABLE)] {
        let coordinates = Coordinates::new(&model);
        for shift in ramp(9, -3.0, 3.0) {
            let n = coordinates.free().len();
            let z: Vec<f64> = (0..n).map(|k| 0.1 * k as f64 + shift).collect();
            let (values, slopes) = coordinates.values(&z);
            for (a, b) in coordinates.point(&values).iter().zip(&z) {
                assert!((a - b).abs() < 1e-8, "{a} {b}");
            }
            for (k, &slope) in slopes.iter().enumerate() {
                let at = |dz: f64| {
                    let mut moved = z.clone();
                    moved[k] += dz;
                    coordinates.values(&moved).0[coordinates.free()[k]]
                };
                let numeric = (at(1e-4) - at(-1e-4)) / 2e-4;
                assert!((numeric - slope).abs() < 1e-6 * slope.abs() + 1e-9, "{k}: {numeric} {slope}");
            }
        }
    }
}

#[test]
fn every_point_is_valid() {
    for model in [model(&TABLE), with_priors(&TABLE)] {
        let coordinates = Coordinates::new(&model);
        for z in ramp(161, -8.0, 8.0) {
            let values = coordinates.values(&vec![z; coordinates.free().len()]).0;
            for (k, &slot) in coordinates.free().iter().enumerate() {
                let slot = (coordinates.slot(k), values[slot]);
                let angle = slot.0.name.ends_with("angle");
                assert!(angle || (slot.0.lower..=slot.0.upper).contains(&slot.1), "{slot:?} at {z}");
            }
        }
    }
}

/// Σ exp(−cost)·Δz over the searched range, for each parameter alone.
#[test]
fn each_density_has_mass_one() {
    for model in [model(&TABLE), with_priors(&TABLE)] {
        let coordinates = Coordinates::new(&model);
        for k in 0..coordinates.free().len() {
            let angle = coordinates.prior_precision(k) == 0.0;
            let reach = if angle { std::f64::consts::FRAC_PI_2 } else { 8.0 };
            let cell = 2.0 * reach / 1000.0;
            let mass: f64 =
                ramp(1000, -reach, reach).map(|z| (-coordinates.prior_cost_of(k, z)).exp() * cell).sum();
            assert!((mass - 1.0).abs() < 1e-9, "{}: {mass}", coordinates.slot(k).name);
        }
    }
}

/// Cumulative probabilities in the unit of the parameter agree with tables.
#[test]
fn distributions_are_those_of_the_file() {
    let coordinates = Coordinates::new(&with_priors(&TABLE));
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let draws: Vec<Vec<f64>> =
        (0..20_000).map(|_| coordinates.values(&coordinates.draw(&mut rng)).0).collect();
    let share = |slot: &str, value: f64| {
        let k = coordinates.slots().iter().position(|s| s.name == slot).unwrap();
        draws.iter().filter(|d| d[k] < value).count() as f64 / draws.len() as f64
    };
    // Φ from tables: cut between −0.6663 and 2.3333 (0.25261, 0.99018); Φ(1) = 0.84134.
    let tables = [
        ("body.mass", 5.0, (0.84134 - 0.25261) / (0.99018 - 0.25261)),
        ("viscous_wheel.x", -0.25, 0.5),
        ("viscous_wheel.y", 0.2, 0.75),
        ("viscous_wheel.angle", 0.15, 0.75),
        // Cut between ln(0.5)/0.5 = −1.38629 and ln(1.25)/0.5 = 0.44629 (0.08283, 0.67230).
        ("viscous_wheel.mu_x", 20.0, (0.5 - 0.08283) / (0.67230 - 0.08283)),
        ("force_bias.force_x", 3.0, 0.84134),
    ];
    for (slot, value, expected) in tables {
        assert!((share(slot, value) - expected).abs() < 0.012, "{slot}: {} {expected}", share(slot, value));
    }
}

#[test]
fn a_rectangle_needs_no_footprint_term() {
    assert!(Coordinates::new(&model(&TABLE)).footprint_priors().is_empty());
    assert_eq!(Coordinates::new(&model(&L)).footprint_priors().len(), 1);
}

/// The density of a place integrates to one over the plane, with little probability outside the shape.
#[test]
fn the_density_of_a_place_is_uniform_over_the_footprint() {
    let disc = Fixture::Disc { center: [0.2, 0.0], radius: 0.5, density: 1.0 };
    for (body, area) in [
        (Body::from_footprint(&L, 22.0).unwrap(), 0.72),
        (Body::from_fixtures(vec![disc], 22.0).unwrap(), 0.25 * std::f64::consts::PI),
    ] {
        let coordinates = Coordinates::new(&wheel_alone(body.clone()));
        let (mut mass, mut outside, cell) = (0.0, 0.0, (12.0f64 / 400.0).powi(2));
        for x in ramp(400, -6.0, 6.0) {
            for y in ramp(400, -6.0, 6.0) {
                let density = (-coordinates.prior_cost(&[x, y])).exp() * cell;
                let values = coordinates.values(&[x, y]).0;
                mass += density;
                outside += if body.outside([values[1], values[2]]).0 > 0.012 { density } else { 0.0 };
            }
        }
        assert!((mass - 1.0).abs() < 0.01, "{mass}");
        assert!(outside < 0.01, "{outside}");
        // In the middle of the shape: one over its area, by the slopes back to the unit of z.
        let z = coordinates.point(&[22.0, -0.1, -0.1, 1.0, 1.0, 1.0]);
        let slopes = coordinates.values(&z).1;
        let density = (-coordinates.prior_cost(&z)).exp() / (slopes[0] * slopes[1]);
        assert!((density * area - 1.0).abs() < 0.03, "{density} {area}");
    }
}

#[test]
fn the_footprint_penalty_is_the_gradient_of_the_cost() {
    let coordinates = Coordinates::new(&wheel_alone(Body::from_footprint(&L, 22.0).unwrap()));
    let prior = &coordinates.footprint_priors()[0];
    assert_eq!(coordinates.coordinates_of(prior), [Some(0), Some(1)]);
    for z in [[0.5, 0.2], [0.1, 1.0], [1.0, 1.0], [-1.0, -1.0]] {
        let penalty = coordinates.footprint_penalty(prior, z);
        for k in 0..2 {
            let at = |dz: f64| {
                let mut moved = z;
                moved[k] += dz;
                coordinates.footprint_penalty(prior, moved).cost
            };
            let numeric = (at(1e-6) - at(-1e-6)) / 2e-6;
            let slope = penalty.residual * penalty.slopes[k];
            assert!((numeric - slope).abs() < 1e-4 * (1.0 + slope.abs()), "{z:?} {k}: {numeric} {slope}");
        }
    }
}

#[test]
fn a_fixed_coordinate_restricts_the_other() {
    let mut model = wheel_alone(Body::from_footprint(&L, 22.0).unwrap());
    model.effects[0] = model.effects[0].clone().with("x", Some(0.3));
    let coordinates = Coordinates::new(&model);
    // At x = 0.3 the L reaches from y = −0.4 to 0, half of its extent.
    let cost = |y| coordinates.prior_cost(&coordinates.point(&[22.0, 0.3, y, 1.0, 1.0, 1.0]));
    let apart = |y: f64| coordinates.prior_cost_of(0, coordinates.point(&[22.0, 0.3, y, 1.0, 1.0, 1.0])[0]);
    assert!((cost(-0.2) - apart(-0.2) - 0.5f64.ln()).abs() < 0.03);
    assert!(cost(0.1) > 100.0);
}

#[test]
fn draws_lie_under_the_footprint() {
    let coordinates = Coordinates::new(&model(&L));
    let body = Body::from_footprint(&L, 22.0).unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    for _ in 0..500 {
        let values = coordinates.values(&coordinates.draw(&mut rng)).0;
        assert_eq!(body.outside([values[1], values[2]]).0, 0.0);
    }
}

#[test]
fn a_prior_data_conflict_is_reported() {
    let coordinates = Coordinates::new(&with_priors(&TABLE));
    let conflict_at = |z, information| coordinates.prior_conflict(0, z, information);
    let conflict = conflict_at(5.0, 100.0).unwrap();
    assert_eq!(conflict.name, "body.mass");
    assert!(conflict.range[0] < 0.01 && (conflict.range[1] - 9.0).abs() < 0.01, "{conflict:?}");
    let words = conflict.to_string();
    for word in ["the prior excludes the data", "body.mass above", ", 8.997] kg", "stays at 9;", "widen"] {
        assert!(words.contains(word), "{words}");
    }
    // Far inside the prior; at an end without conflict; at an end with a conflict.
    assert_eq!((conflict_at(1.0, 0.001), conflict_at(-3.0, 4.0)), (None, None));
    assert!(conflict_at(-3.0, 0.5).unwrap().to_string().contains("below"));
}

/// Mode of N(22 ± 0.1) under a uniform prior, for which the two criteria differ.
#[test]
fn only_a_bound_far_from_the_data_is_a_conflict() {
    for (low, conflict) in [(30.0, true), (22.0, false), (10.0, false), (22.6, true)] {
        let text = format!("[body]\nmass = {{ distribution = \"uniform\", low = {low}, high = 40 }}");
        let model = PriorFile::from_toml(&text, "p").unwrap().apply(&model(&TABLE)).unwrap();
        let coordinates = Coordinates::new(&model);
        let at = |z: f64| {
            let point: Vec<f64> =
                (0..coordinates.free().len()).map(|k| if k == 0 { z } else { 0.0 }).collect();
            let (values, slopes) = coordinates.values(&point);
            (values[0], slopes[0])
        };
        let cost = |z: f64| 0.5 * ((at(z).0 - 22.0) / 0.1).powi(2) + coordinates.prior_cost_of(0, z);
        let mode = ramp(160_000, -8.0, 8.0).min_by(|a, b| cost(*a).total_cmp(&cost(*b))).unwrap();
        let found = coordinates.prior_conflict(0, mode, (at(mode).1 / 0.1).powi(2));
        assert_eq!(found.is_some(), conflict, "{low}: mode at {mode}");
    }
}
