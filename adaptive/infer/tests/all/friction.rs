//! Axis friction, friction that decreases with speed, and friction at two points are recovered from pushes.
#![allow(clippy::unwrap_used)]

use trundle_fixtures::{NOISE, World, effect, locked, table};
use trundle_infer::{Fit, FitOptions, MotionLikelihood, Quiet, fit};
use trundle_model::{Effect, Kind, Model};

fn fitted(truth: &[Effect], tried: &[Effect], warm: &[Vec<f64>]) -> Fit {
    let world = World::of(truth.iter().cloned().fold(locked(), Model::with));
    let likelihood = MotionLikelihood::new(&world.pushes(4, 3), &NOISE).unwrap();
    let model = tried.iter().cloned().fold(Model::nominal(table(), None, [true; 3]), Model::with);
    fit(&likelihood, &model, warm, &FitOptions::default(), &Quiet).unwrap()
}

#[track_caller]
fn assert_near(fit: &Fit, name: &str, truth: f64, within: f64) {
    let found = fit.estimate(name).unwrap();
    assert!(found.identified && (found.mean - truth).abs() < within, "{found:?} for {truth}");
}

/// Axes turned by a quarter, with their forces exchanged, are the same axes.
#[track_caller]
fn assert_axes(fit: &Fit, kind: &str, [angle, along, across, torque]: [f64; 4]) {
    let found = |name: &str| fit.estimate(&format!("{kind}.{name}")).unwrap().mean;
    let quarters = ((found("angle") - angle) / std::f64::consts::FRAC_PI_2).round();
    let turned = found("angle") - angle - quarters * std::f64::consts::FRAC_PI_2;
    let [first, second] =
        if quarters.rem_euclid(2.0) < 0.5 { ["force_x", "force_y"] } else { ["force_y", "force_x"] };
    assert!(turned.abs() < 0.05, "angle {}", found("angle"));
    assert_near(fit, &format!("{kind}.{first}"), along, 0.6);
    assert_near(fit, &format!("{kind}.{second}"), across, 0.6);
    assert_near(fit, &format!("{kind}.torque"), torque, 0.3);
}

#[test]
fn dry_axes_in_the_world() {
    let values = [("angle", 0.4), ("force_x", 3.0), ("force_y", 9.0), ("torque", 1.5)];
    let found = fitted(&[effect(Kind::AxisFriction, &values)], &[Effect::free(Kind::AxisFriction)], &[]);
    assert_axes(&found, "axis_friction", values.map(|(_, value)| value));
}

#[test]
fn dry_axes_in_the_body() {
    let values = [("angle", 0.4), ("force_x", 3.0), ("force_y", 9.0), ("torque", 1.5)];
    let truth = effect(Kind::BodyAxisFriction, &values);
    let found = fitted(&[truth], &[Effect::free(Kind::BodyAxisFriction)], &[]);
    assert_axes(&found, "body_axis_friction", values.map(|(_, value)| value));
}

#[test]
fn drag_that_thins_with_speed() {
    let values = [("force", 8.0), ("exponent", 0.4), ("spread", 1.0)];
    let found = fitted(&[effect(Kind::ThinningDrag, &values)], &[Effect::free(Kind::ThinningDrag)], &[]);
    assert_near(&found, "thinning_drag.force", 8.0, 0.6);
    assert_near(&found, "thinning_drag.exponent", 0.4, 0.06);
}

#[test]
fn dry_friction_at_two_points() {
    let [one, other] = [[0.5, 0.3, 6.0], [0.4, -0.35, 9.0]]
        .map(|[x, y, force]| effect(Kind::CoulombFriction, &[("x", x), ("y", y), ("force", force)]));
    let free = || Effect::free(Kind::CoulombFriction);
    let start = [
        vec![22.0, -0.4, -0.2, 0.1, 20.0, 150.0],
        vec![0.4, 0.2, 5.0, 0.0, 0.01, 1e-4],
        vec![0.2, -0.2, 5.0, 0.0, 0.01, 1e-4],
    ];
    let found = fitted(&[one.clone(), other.clone()], &[free(), free()], &[start.concat()]);
    let alone = fitted(&[one, other], &[free()], &[]);
    let upper = found.estimate("coulomb_friction.y").unwrap().mean > 0.0;
    let names = ["coulomb_friction", "coulomb_friction_2"];
    let [first, second] = if upper { names } else { [names[1], names[0]] };
    for (name, [x, y, force]) in [(first, [0.5, 0.3, 6.0]), (second, [0.4, -0.35, 9.0])] {
        assert_near(&found, &format!("{name}.x"), x, 0.06);
        assert_near(&found, &format!("{name}.y"), y, 0.06);
        assert_near(&found, &format!("{name}.force"), force, 0.8);
    }
    assert!(alone.cost - found.cost > 50.0, "{} {}", alone.cost, found.cost);
}
