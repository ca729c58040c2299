//! The compliant gripper: its wrench accelerates the object, and the coupling is stable and passive.

#![allow(clippy::unwrap_used)]

use trundle_model::{Body, Clock, Model};
use trundle_sim::{Coupling, DriveMode, Gripper, World};

const CONTACT: Clock = Clock::since_contact(0.0);
const DT: f64 = 2e-3;

fn square(mass: f64) -> World {
    let body = Body::from_footprint(&[[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]], mass).unwrap();
    let model = Model {
        mass: Some(mass),
        body,
        dof: [true; 3],
        effects: vec![],
        priors: Default::default(),
        discrepancy: None,
    };
    World::new(&model, &[], DT).unwrap()
}

fn grip(grasp: [f64; 3], coupling: Coupling) -> Gripper {
    Gripper::new(grasp, [0.0; 3], DriveMode::Velocity, coupling)
}

#[test]
fn the_impulse_of_the_gripper_equals_the_change_of_momentum() {
    let mut world = square(20.0);
    let mut gripper = grip([0.3, 0.4, 1.0], Coupling::default());
    let (mut impulse, mut spin) = ([0.0; 2], 0.0);
    for _ in 0..1000 {
        let state = world.state();
        let (sin, cos) = state.pose[2].sin_cos();
        let [fx, fy, torque] = gripper.step([0.3, -0.1, 0.4], &state, world.rigid(), DT);
        world.step([fx, fy, torque], CONTACT);
        // The wrench turns with the object, so use its mean heading over the step.
        let turned = (world.state().pose[2] - state.pose[2]) / 2.0;
        let (s, c) = (sin + cos * turned, cos - sin * turned);
        impulse[0] += (c * fx - s * fy) * DT;
        impulse[1] += (s * fx + c * fy) * DT;
        spin += torque * DT;
    }
    let [vx, vy, omega] = world.state().twist;
    assert!((20.0 * vx - impulse[0]).abs() < 1e-3, "{} {}", 20.0 * vx, impulse[0]);
    assert!((20.0 * vy - impulse[1]).abs() < 1e-3);
    assert!((20.0 / 6.0 * omega - spin).abs() < 1e-9);
}

#[test]
fn the_object_follows_the_gripper() {
    let mut world = square(20.0);
    let mut gripper = grip([-0.5, 0.0, 0.0], Coupling::default());
    for _ in 0..2000 {
        let wrench = gripper.step([0.2, 0.0, 0.1], &world.state(), world.rigid(), DT);
        world.step(wrench, CONTACT);
    }
    let object = world.state().pose;
    let gripper_pose = gripper.pose(object);
    let (sin, cos) = object[2].sin_cos();
    assert!((object[0] - 0.5 * cos - gripper_pose[0]).abs() < 0.01, "{object:?} {gripper_pose:?}");
    assert!((object[1] - 0.5 * sin - gripper_pose[1]).abs() < 0.01);
    assert!((object[2] - gripper_pose[2]).abs() < 0.01);
}

#[test]
fn a_stiff_gripper_on_a_light_object_is_stable_and_dissipates_energy() {
    let coupling = Coupling { stiffness: 1e6, damping: 0.0, twist_stiffness: 1e4, twist_damping: 0.0 };
    let mut world = square(0.5);
    let mut gripper = grip([0.5, 0.5, 0.0], coupling);
    for tick in 0..5000 {
        let command = if tick < 50 { [0.5, 0.2, 2.0] } else { [0.0; 3] };
        let wrench = gripper.step(command, &world.state(), world.rigid(), DT);
        world.step(wrench, CONTACT);
        assert!(world.energy() < 10.0, "{tick}: {} J", world.energy());
    }
    assert!(world.energy() < 1e-6, "{} J", world.energy());
}
