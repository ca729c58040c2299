//! The physics-engine world: agreement with the model's integrator, stability, energy and contact.

#![allow(clippy::unwrap_used, clippy::panic)]

use std::f64::consts::{PI, TAU};

use trundle_model::{Body, Clock, Effect, Kind, Model, State};
use trundle_sim::World;

const DT: f64 = 2e-3;
const CONTACT: Clock = Clock::since_contact(0.0);

fn table(mass: f64) -> Model {
    let footprint = [[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]];
    let body = Body::from_footprint(&footprint, mass).unwrap().with_feet(&[
        [-0.5, -0.3],
        [0.5, -0.3],
        [0.5, 0.3],
        [-0.5, 0.3],
    ]);
    Model {
        body,
        mass: Some(mass),
        dof: [true; 3],
        effects: vec![],
        priors: Default::default(),
        discrepancy: None,
    }
}

fn wheel(mu_x: f64, mu_y: f64) -> Effect {
    [("x", -0.5), ("y", 0.3), ("angle", 0.4), ("mu_x", mu_x), ("mu_y", mu_y)]
        .iter()
        .fold(Effect::free(Kind::ViscousWheel), |effect, &(name, value)| effect.with(name, Some(value)))
}

/// An effect with all parameters at typical values within their bounds.
fn plain(kind: Kind) -> Effect {
    kind.spec().params.iter().fold(Effect::free(kind), |effect, param| {
        let value = if param.role.is_choice() { 0.0 } else { 0.3f64.clamp(param.lower, param.upper) };
        effect.with(param.name, Some(value))
    })
}

/// A wrench that turns and reverses, object axes.
fn wrench(t: f64) -> [f64; 3] {
    [40.0 * (3.0 * t).sin(), 25.0 * (5.0 * t).cos(), 9.0 * (4.0 * t).sin()]
}

#[track_caller]
fn assert_near(a: [f64; 3], b: [f64; 3], tolerance: f64) {
    for k in 0..3 {
        assert!((a[k] - b[k]).abs() <= tolerance, "{a:?} and {b:?} differ by more than {tolerance}");
    }
}

/// Largest difference of poses and internal states between engine and integrator in one second under the same wrench.
fn gap(model: &Model) -> f64 {
    let mut world = World::new(model, &[], DT).unwrap();
    let plant = model.resolved().unwrap();
    let own = std::array::from_fn(|k| if k < plant.inner() { 0.1 * (k + 1) as f64 } else { 0.0 });
    let mut state = State::at_rest([0.3, -0.2, 0.7]).with_inner(own);
    world.place(state.pose);
    world.set_inner(own);
    let mut largest = 0.0f64;
    for tick in 0..500 {
        let t = f64::from(tick) * DT;
        let clock = Clock { t: t + DT / 2.0, dt: DT, grasp: [0.5, 0.2], ..Clock::since_contact(t) };
        world.step(wrench(t), clock);
        state = plant.step(&state, wrench(t), clock, DT);
        let pose = world.state().pose;
        let turned = (pose[2] - state.pose[2] + PI).rem_euclid(TAU) - PI;
        let motion = [pose[0] - state.pose[0], pose[1] - state.pose[1], turned];
        let own = world.state().inner.into_iter().zip(state.inner).map(|(a, b)| a - b);
        largest = motion.into_iter().chain(own).map(f64::abs).fold(largest, f64::max);
    }
    largest
}

#[test]
fn free_motion_agrees_with_the_integrator_to_a_micrometre_for_every_effect() {
    for &kind in Kind::ALL {
        let mut model = table(22.0);
        // Some effects modify a wheel, so the model has one.
        model.effects = vec![wheel(18.0, 32.0), plain(kind)];
        let gap = gap(&model);
        assert!(gap < 1e-6, "{}: {gap:e}", kind.spec().kind);
    }
    let mut model = table(22.0);
    model.effects = vec![wheel(180.0, 320.0), plain(Kind::CoulombFriction)];
    model.body.com = [0.1, -0.05];
    assert!(gap(&model) < 1e-6);
}

#[test]
fn laws_with_internal_states_agree_in_engine_and_integrator() {
    let with = |kind, values: &[(&str, f64)]| {
        values.iter().fold(Effect::free(kind), |effect, (name, value)| effect.with(name, Some(*value)))
    };
    let caster = with(Kind::CasterSwivel, &[("x", 0.5), ("y", 0.3), ("trail", 0.05), ("mu_side", 60.0)]);
    let load = [("x", 0.3), ("y", -0.2), ("mass", 5.0), ("frequency", 1.4), ("damping_ratio", 0.03)];
    let load = with(Kind::SwingingLoad, &load);
    for effects in [vec![caster.clone()], vec![load.clone()], vec![caster, load]] {
        let mut model = table(22.0);
        model.effects = effects;
        model.body.com = [0.1, -0.05];
        assert!(gap(&model) < 1e-6, "{:e}", gap(&model));
    }
}

#[test]
fn a_wheel_of_1e5_on_ten_kilograms_is_stable_at_two_milliseconds() {
    let mut model = table(10.0);
    model.effects = vec![wheel(1e5, 1e5)];
    let mut world = World::new(&model, &[], DT).unwrap();
    for tick in 0..2000 {
        world.step(wrench(f64::from(tick) * DT), CONTACT);
        assert!(world.energy().is_finite() && world.energy() < 50.0);
    }
    // The wheel's contact point creeps at F/μ, so it stays in place and the table turns about it.
    let [x, y, theta] = world.state().pose;
    let (sin, cos) = theta.sin_cos();
    let wheel = [x + cos * -0.5 - sin * 0.3, y + sin * -0.5 + cos * 0.3];
    assert_near([wheel[0], wheel[1], 0.0], [-0.5, 0.3, 0.0], 5e-3);
}

#[test]
fn energy_does_not_grow_without_input() {
    for &kind in Kind::ALL.iter().filter(|k| k.spec().is_dissipative) {
        let mut model = table(22.0);
        model.effects = vec![plain(kind), wheel(30.0, 300.0)];
        let mut world = World::new(&model, &[], DT).unwrap();
        for tick in 0..100 {
            world.step(wrench(f64::from(tick) * DT), CONTACT);
        }
        let mut energy = world.energy();
        for _ in 0..500 {
            world.step([0.0; 3], CONTACT);
            assert!(world.energy() <= energy * (1.0 + 1e-12), "{}", kind.spec().kind);
            energy = world.energy();
        }
    }
}

#[test]
fn a_snapshot_repeats_free_motion_bit_for_bit() {
    let mut model = table(22.0);
    model.effects = vec![wheel(180.0, 320.0), plain(Kind::SwingingLoad)];
    let mut world = World::new(&model, &[], DT).unwrap();
    let run = |world: &mut World| {
        (0..200).for_each(|tick| world.step(wrench(f64::from(tick) * DT), CONTACT));
        world.snapshot()
    };
    let middle = run(&mut world);
    let end = run(&mut world);
    let mut other = World::new(&model, &[], DT).unwrap();
    other.restore(&middle);
    assert_eq!(run(&mut other), end);
}

#[test]
fn a_wall_stops_the_table_and_dissipates_energy() {
    let wall = vec![vec![[1.0, -3.0], [1.2, -3.0], [1.2, 3.0], [1.0, 3.0]]];
    let mut world = World::new(&table(22.0), &wall, DT).unwrap();
    for tick in 0..2000 {
        let push = if tick < 500 { [20.0, 0.0, 0.0] } else { [0.0; 3] };
        let energy = world.energy();
        world.step(push, CONTACT);
        assert!(tick < 500 || world.energy() <= energy + 1e-9, "energy grows at the wall");
    }
    let [x, _, theta] = world.state().pose;
    assert!((0.35..0.41).contains(&x), "front edge at the wall: x = {x}");
    assert!(theta.abs() < 1e-3);
    assert!(world.state().twist[0].abs() < 0.02, "{:?}", world.state().twist);
}

#[test]
fn a_concave_shape_has_the_models_mass_and_inertia() {
    let corner = [[0.0, 0.0], [1.0, 0.0], [1.0, 0.4], [0.4, 0.4], [0.4, 1.0], [0.0, 1.0]];
    let body = Body::from_footprint(&corner, 40.0).unwrap();
    let model = Model {
        mass: Some(40.0),
        body,
        dof: [true; 3],
        effects: vec![],
        priors: Default::default(),
        discrepancy: None,
    };
    assert!(gap(&model) < 1e-6, "{:e}", gap(&model));
}

#[test]
fn an_invalid_shape_is_named_in_the_error() {
    let bow_tie = vec![[0.0, 0.0], [2.0, 1.0], [2.0, 0.0], [0.0, 3.0]];
    for polygon in [bow_tie, vec![[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]], vec![]] {
        let error = World::new(&table(22.0), &[polygon], DT).err().unwrap().to_string();
        assert!(error.contains("obstacle 1"), "{error}");
    }
}
