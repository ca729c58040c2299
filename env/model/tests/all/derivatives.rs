//! Derivatives of a step by state, wrench and every parameter, compared with central differences.

#![allow(clippy::unwrap_used)]

use trundle_model::{Body, Clock, Dual, Effect, Kind, Model, Plant, Real, State, to_body, to_world};

const CLOCK: Clock = Clock::since_contact(1.0);
/// Pose, twist and wrench.
const STATE: [f64; 9] = [0.1, 0.2, 0.3, 0.4, -0.1, 0.2, 12.0, -3.0, 1.5];
/// Number of derivatives, at least the number of inputs of a step.
const WIDTH: usize = 32;

fn effect(kind: Kind, values: &[(&str, f64)]) -> Effect {
    values.iter().fold(Effect::free(kind), |effect, (name, value)| effect.with(name, Some(*value)))
}

/// A table with an offset mass centre, a wheel and a foot with dry friction, on a slope.
fn table(dof: [bool; 3]) -> Model {
    let mut body = Body::from_footprint(&[[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]], 22.0).unwrap();
    body.com = [0.07, -0.11];
    let wheel = [("x", -0.5), ("y", -0.3), ("angle", 0.2), ("mu_x", 15.0), ("mu_y", 180.0)];
    let foot = [("x", 0.4), ("y", 0.3), ("force", 6.0), ("static_force", 9.0), ("stribeck_velocity", 0.3)];
    let mut model = Model::nominal(body, Some(22.0), dof);
    model.effects = vec![
        effect(Kind::ViscousWheel, &wheel),
        effect(Kind::CoulombFriction, &foot),
        effect(Kind::FloorSlope, &[("accel_x", 0.1), ("accel_y", -0.2)]),
    ];
    model
}

fn step<T: Real>(model: &Model, at: &[T], dt: f64) -> Vec<T> {
    let plant: Plant<T> = model.plant(&at[9..]).unwrap();
    let state = State::moving([at[0], at[1], at[2]], [at[3], at[4], at[5]]);
    let State { pose, twist, .. } = plant.step(&state, [at[6], at[7], at[8]], CLOCK, dt);
    [pose, twist].concat()
}

fn check(
    mut point: Vec<f64>,
    of: impl Fn(&[f64]) -> Vec<f64>,
    slopes: impl Fn(&[Dual<WIDTH>]) -> Vec<Dual<WIDTH>>,
) {
    assert!(point.len() <= WIDTH);
    let variables: Vec<_> = point.iter().enumerate().map(|(k, &value)| Dual::variable(value, k)).collect();
    let (values, exact) = (of(&point), slopes(&variables));
    for (value, exact) in values.iter().zip(&exact) {
        assert!((value - exact.re).abs() < 1e-14 * (1.0 + value.abs()), "{value} {}", exact.re);
    }
    for k in 0..point.len() {
        let (middle, h) = (point[k], 1e-5 * point[k].abs().max(0.1));
        let mut at = |value: f64| {
            point[k] = value;
            of(&point)
        };
        let (above, below, _) = (at(middle + h), at(middle - h), at(middle));
        for (row, exact) in exact.iter().enumerate() {
            let numeric = (above[row] - below[row]) / (2.0 * h);
            let off = (numeric - exact.eps[k]).abs();
            assert!(off < 1e-6 * numeric.abs() + 1e-9, "{row} by {k}: {numeric} {}", exact.eps[k]);
        }
    }
}

#[test]
fn derivatives_of_a_step() {
    for (dof, dt) in [([true; 3], 2e-3), ([true; 3], 0.05), ([true, false, false], 2e-3)] {
        let model = table(dof);
        let mut point = STATE.to_vec();
        point.extend(model.slots().iter().map(|slot| slot.value.unwrap()));
        if !dof[2] {
            // On a rail there is no lateral motion and no rotation.
            for k in [1, 2, 4, 5] {
                point[k] = 0.0;
            }
        }
        check(point, |at| step(&model, at, dt), |at| step(&model, at, dt));
    }
}

#[test]
fn derivatives_of_a_rotation() {
    fn turned<T: Real>(at: &[T]) -> Vec<T> {
        let vector = [at[0], at[1], at[2]];
        [to_world(vector, at[3]), to_body(vector, at[3])].concat()
    }
    check(vec![0.4, -0.7, 0.2, 1.1], turned, turned);
}
