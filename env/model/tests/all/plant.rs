//! The integrator compared with motions known in closed form.

#![allow(clippy::unwrap_used)]

use trundle_model::{Body, Clock, Effect, Kind, Model, Plant, Precision, Prior, State};

const DT: f64 = 2e-3;

/// A 10 kg table, 1.2 m × 0.8 m, its mass centre at `com`.
fn table(com: [f64; 2]) -> Model {
    let mut body = Body::from_footprint(&[[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]], 10.0).unwrap();
    body.com = com;
    Model {
        mass: Some(body.mass),
        body,
        dof: [true; 3],
        effects: vec![],
        priors: Default::default(),
        discrepancy: None,
    }
}

fn effect(kind: Kind, values: &[(&str, f64)]) -> Effect {
    values.iter().fold(Effect::free(kind), |effect, (name, value)| effect.with(name, Some(*value)))
}

fn wheel([x, y]: [f64; 2], angle: f64, [mu_x, mu_y]: [f64; 2]) -> Effect {
    let values = [("x", x), ("y", y), ("angle", angle), ("mu_x", mu_x), ("mu_y", mu_y)];
    effect(Kind::ViscousWheel, &values)
}

fn dry(force: f64, static_force: f64) -> Effect {
    effect(Kind::CoulombFriction, &[("x", 0.0), ("y", 0.0), ("force", force), ("static_force", static_force)])
}

fn slope(accel: [f64; 2]) -> Effect {
    effect(Kind::FloorSlope, &[("accel_x", accel[0]), ("accel_y", accel[1])])
}

/// Motion under a constant wrench in object axes, including the initial state.
fn roll(plant: &Plant<f64>, start: State<f64>, wrench: [f64; 3], dt: f64, duration: f64) -> Vec<State<f64>> {
    let steps = (duration / dt).round() as usize;
    let mut motion = vec![start];
    for k in 0..steps {
        let clock = Clock::since_contact(k as f64 * dt);
        motion.push(plant.step(&motion[k], wrench, clock, dt));
    }
    motion
}

fn end(model: &Model, start: State<f64>, wrench: [f64; 3], duration: f64) -> State<f64> {
    let plant = model.resolved().unwrap();
    roll(&plant, start, wrench, DT, duration)[(duration / DT).round() as usize]
}

fn moving(twist: [f64; 3]) -> State<f64> {
    State { twist, ..State::at_rest([0.0; 3]) }
}

/// World position and velocity of a body point.
fn at(state: &State<f64>, [px, py]: [f64; 2]) -> ([f64; 2], [f64; 2]) {
    let (sin, cos) = state.pose[2].sin_cos();
    let (rx, ry) = (cos * px - sin * py, sin * px + cos * py);
    let [vx, vy, spin] = state.twist;
    ([state.pose[0] + rx, state.pose[1] + ry], [vx - spin * ry, vy + spin * rx])
}

fn assert_close(got: f64, expected: f64, tolerance: f64) {
    assert!((got - expected).abs() <= tolerance, "{got} is not {expected} within {tolerance}");
}

#[test]
fn a_locked_wheel_is_stable_at_any_step() {
    let plant = table([0.05, -0.1]).with(wheel([-0.5, -0.3], 0.2, [1e5, 1e5])).resolved().unwrap();
    for dt in [2e-3, 1e-2] {
        // The wrench has no moment about the wheel, so that the spin is constant after the first steps.
        let motion = roll(&plant, moving([0.5, -0.3, 1.0]), [20.0, -30.0, 21.0], dt, 5.0);
        for state in &motion {
            assert!(state.twist.iter().all(|v| v.abs() < 2.0), "{state:?} at dt = {dt}");
        }
        // The velocity of the wheel vanishes within a few steps except for ω² r dt/2: the damping acts at the middle of
        // a step.
        for state in &motion[5..] {
            let (_, velocity) = at(state, [-0.5, -0.3]);
            assert!(velocity[0].hypot(velocity[1]) < 0.01, "the wheel moves at {velocity:?}, dt = {dt}");
        }
    }
}

#[test]
fn halving_the_step_quarters_the_error() {
    let plant = table([0.1, -0.05])
        .with(wheel([-0.5, -0.3], 0.2, [15.0, 90.0]))
        .with(effect(Kind::CoulombFriction, &[("x", 0.4), ("y", 0.3), ("force", 3.0)]))
        .resolved()
        .unwrap();
    let last = |dt: f64| *roll(&plant, moving([1.0, 0.2, 0.3]), [40.0, 10.0, 4.0], dt, 1.0).last().unwrap();
    let truth = last(2e-5);
    let error = |dt: f64| {
        let state = last(dt);
        let gaps = state.pose.iter().zip(truth.pose).chain(state.twist.iter().zip(truth.twist));
        gaps.map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
    };
    // Longer steps are halved when the friction changes.
    for dt in [0.004, 0.002, 0.001] {
        let ratio = error(dt) / error(dt / 2.0);
        assert!((3.5..4.6).contains(&ratio), "error falls by {ratio} from dt = {dt}");
    }
}

#[test]
fn viscous_friction_decays_exponentially() {
    let model = table([0.0; 2]).with(wheel([0.0; 2], 0.7, [30.0, 30.0]));
    let state = end(&model, moving([1.0, -2.0, 0.0]), [0.0; 3], 1.0);
    let left = (-3.0f64).exp();
    for (k, v) in [(0, 1.0), (1, -2.0)] {
        assert_close(state.twist[k], v * left, 2e-6);
        assert_close(state.pose[k], v / 3.0 * (1.0 - left), 1e-5);
    }
}

#[test]
fn a_free_body_conserves_momentum_and_energy() {
    let com = [0.2, -0.1];
    let model = table(com);
    let start = moving([0.3, -0.2, 2.0]);
    let ([x, y], velocity) = at(&start, com);
    for (k, state) in roll(&model.resolved().unwrap(), start, [0.0; 3], DT, 3.0).iter().enumerate() {
        let t = k as f64 * DT;
        let (place, now) = at(state, com);
        for axis in 0..2 {
            assert_close(now[axis], velocity[axis], 1e-12);
            assert_close(place[axis], [x, y][axis] + velocity[axis] * t, 1e-12);
        }
        assert_close(state.twist[2], 2.0, 1e-12);
        assert_close((state.pose[0] - place[0]).hypot(state.pose[1] - place[1]), 0.05f64.sqrt(), 1e-12);
    }
}

#[test]
fn an_applied_wrench_rotates_with_the_object() {
    let (force, spin, duration) = (5.0, 1.5, 2.0);
    let state = end(&table([0.0; 2]), moving([0.0, 0.0, spin]), [force, 0.0, 0.0], duration);
    let (sin, cos) = (spin * duration).sin_cos();
    assert_close(state.twist[0], force / 10.0 * sin / spin, 1e-6);
    assert_close(state.twist[1], force / 10.0 * (1.0 - cos) / spin, 1e-6);
}

#[test]
fn a_torque_rotates_a_body_about_its_mass_centre() {
    let com = [0.2, -0.1];
    let model = table(com);
    let state = end(&model, State::at_rest([0.0; 3]), [0.0, 0.0, 3.0], 0.5);
    let (place, _) = at(&state, com);
    assert_close(place[0], com[0], 1e-12);
    assert_close(place[1], com[1], 1e-12);
    assert_close(state.pose[2], 3.0 / model.body.inertia() * 0.125, 1e-12);
}

#[test]
fn a_force_through_the_mass_centre_causes_no_rotation() {
    let (com, [fx, fy]) = ([0.2, -0.1], [6.0, 4.0]);
    let model = table(com);
    let spin = |torque: f64| end(&model, State::at_rest([0.0; 3]), [fx, fy, torque], 0.5).twist[2];
    let moment = com[0] * fy - com[1] * fx;
    assert_close(spin(moment), 0.0, 1e-12);
    assert_close(spin(0.0), -moment / model.body.inertia() * 0.5, 1e-12);
}

#[test]
fn a_slope_accelerates_the_mass_centre_after_contact() {
    let (com, accel) = ([0.2, -0.1], [0.3, -0.2]);
    let model = table(com).with(slope(accel));
    let start = moving([0.1, 0.2, 0.7]);
    let (from, velocity) = at(&start, com);
    let last = end(&model, start, [0.0; 3], 2.0);
    assert_close(last.twist[2], 0.7, 1e-12);
    let (to, _) = at(&last, com);
    for k in 0..2 {
        assert_close(to[k], from[k] + velocity[k] * 2.0 + accel[k] * 2.0, 1e-11);
    }
    let plant = model.resolved().unwrap();
    let before = plant.step(&State::at_rest([0.0; 3]), [0.0; 3], Clock::since_contact(-DT), DT);
    assert_eq!(before, State::at_rest([0.0; 3]));
}

#[test]
fn dry_friction_stops_a_body_at_the_stopping_distance() {
    let model = table([0.0; 2]).with(dry(20.0, 0.0));
    let stopped = end(&model, moving([0.6, 0.8, 0.0]), [0.0; 3], 1.0);
    let distance = 10.0 / (2.0 * 20.0);
    assert_close(stopped.pose[0].hypot(stopped.pose[1]), distance, 5e-5);
    let later = end(&model, stopped, [0.0; 3], 5.0);
    assert_close((later.pose[0] - stopped.pose[0]).hypot(later.pose[1] - stopped.pose[1]), 0.0, 1e-9);
}

#[test]
fn dry_friction_never_reverses_a_body() {
    let plant = table([0.0; 2]).with(dry(50.0, 80.0)).resolved().unwrap();
    for dt in [2e-3, 1e-2] {
        for state in roll(&plant, moving([0.3, 0.0, 0.0]), [0.0; 3], dt, 1.0) {
            assert!(state.twist[0] >= -1e-12, "{state:?} at dt = {dt}");
        }
    }
}

#[test]
fn fit_precision_follows_stick_slip_to_a_millimetre() {
    let foot = effect(Kind::CoulombFriction, &[("x", 0.4), ("y", 0.3), ("force", 12.0)]);
    let plant =
        table([0.1, -0.05]).with(wheel([-0.5, -0.3], 0.2, [15.0, 90.0])).with(foot).resolved().unwrap();
    let end = |precision: Precision| {
        let mut state = State::at_rest([0.0; 3]);
        for k in 0..300 {
            let t = 0.01 * k as f64;
            let wrench = [40.0 * (2.1 * t).sin(), 25.0 * (1.3 * t).cos(), 12.0 * (3.0 * t).sin()];
            plant.step_with_precision(precision, &mut state, &wrench, Clock::since_contact(t), 0.01);
        }
        state.pose
    };
    let (exact, fit) = (end(Precision::Exact), end(Precision::Fit));
    assert!(exact[0].hypot(exact[1]) > 0.1, "{exact:?}");
    for (k, tolerance) in [1e-3, 1e-3, 2e-3].into_iter().enumerate() {
        assert_close(fit[k], exact[k], tolerance);
    }
    assert_ne!(fit, exact);
}

#[test]
fn stiction_holds_below_breakaway_and_slides_above() {
    let model = table([0.0; 2]).with(dry(20.0, 30.0));
    let rest = State::at_rest([0.0; 3]);
    // Below breakaway the body creeps at the speed at which the smoothed friction equals the load, under 0.2 mm/s.
    assert!(end(&model, rest, [25.0, 0.0, 0.0], 5.0).pose[0] < 1e-3);
    let sliding = end(&model, rest, [35.0, 0.0, 0.0], 2.0);
    assert_close(sliding.twist[0], 1.5 * 2.0, 0.1);
    let held = table([0.0; 2]).with(dry(20.0, 0.0));
    assert!(end(&held, rest, [10.0, 0.0, 0.0], 5.0).pose[0] < 3e-4);
}

#[test]
fn a_rail_blocks_lateral_motion_and_rotation_exactly() {
    let mut model = table([0.1, -0.1]).with(wheel([0.3, 0.2], 0.4, [10.0, 300.0])).with(slope([0.1, 0.5]));
    model.dof = [true, false, false];
    let state = end(&model, State::at_rest([0.0; 3]), [10.0, 25.0, 4.0], 2.0);
    assert_eq!([state.pose[1], state.pose[2], state.twist[1], state.twist[2]], [0.0; 4]);
    // One axis remains: damping c = μ_x cos² + μ_y sin², force F + m a.
    let drag = 10.0 * 0.4f64.cos().powi(2) + 300.0 * 0.4f64.sin().powi(2);
    assert_close(state.twist[0], 11.0 / drag * (1.0 - (-drag / 10.0 * 2.0).exp()), 1e-5);
}

#[test]
fn a_table_rotates_about_a_locked_wheel() {
    let locked = [-0.5, -0.3];
    let model = table([0.0; 2]).with(wheel(locked, 0.0, [1e5, 1e5]));
    let state = end(&model, State::at_rest([0.0; 3]), [0.0, 4.0, 4.0 * 0.6], 1.5);
    let (place, _) = at(&state, locked);
    assert!((place[0] - locked[0]).hypot(place[1] - locked[1]) < 5e-4, "the wheel went to {place:?}");
    // τ about the wheel is 4 N at 1.1 m; the inertia about it by Steiner.
    let inertia = model.body.inertia() + 10.0 * (0.25 + 0.09);
    assert_close(state.pose[2], 4.0 * 1.1 / inertia * 1.5f64.powi(2) / 2.0, 2e-3);
}

#[test]
fn a_step_is_halved_when_dry_friction_reverses_a_body() {
    // A table with dry friction is pushed back and forth for six seconds and stops repeatedly. With undivided steps of
    // 4 ms its final error is 4 mm.
    let wheel = [("x", -0.5), ("y", -0.3), ("angle", 0.2), ("mu_x", 15.0), ("mu_y", 180.0)];
    let foot = [("x", 0.45), ("y", 0.31), ("force", 14.0)];
    let with = |kind, values: &[(&str, f64)]| {
        values.iter().fold(Effect::free(kind), |effect, (name, value)| effect.with(name, Some(*value)))
    };
    let footprint = [[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]];
    let body = Body::from_footprint(&footprint, 22.0).unwrap();
    let effects = vec![with(Kind::ViscousWheel, &wheel), with(Kind::CoulombFriction, &foot)];
    let plant = Model {
        body,
        mass: Some(22.0),
        dof: [true; 3],
        effects,
        priors: Default::default(),
        discrepancy: None,
    }
    .resolved()
    .unwrap();
    let end = |dt: f64| {
        let mut state = State::at_rest([0.0; 3]);
        for k in 0..(6.0 / dt).round() as usize {
            let t = (k as f64 + 0.5) * dt;
            let push = [
                25.0 * (2.0 * t).sin() + 8.0 * (5.0 * t).cos(),
                15.0 * (3.1 * t).sin(),
                6.0 * (1.7 * t).cos(),
            ];
            state = plant.step(&state, push, Clock::since_contact(t), dt);
        }
        state.pose
    };
    let (truth, seen) = (end(2e-5), end(4e-3));
    let off = (truth[0] - seen[0]).hypot(truth[1] - seen[1]);
    assert!(off < 5e-4, "off by {off} m");
}

/// A valid value for each free parameter.
fn some_values(model: &Model) -> Vec<f64> {
    let one = |prior| match prior {
        Prior::Normal { mean, sd } => mean + 0.7 * sd,
        Prior::LogNormal { median, .. } => median,
        Prior::Uniform | Prior::OnBody(_) => 0.2,
        Prior::Angle(_) => 0.4,
    };
    model.slots().into_iter().map(|slot| slot.value.unwrap_or_else(|| one(slot.prior))).collect()
}

#[test]
fn pose_invariant_laws_are_independent_of_the_pose() {
    let (turn, [sin, cos]) = (2.0f64, [2.0f64.sin(), 2.0f64.cos()]);
    let turned = |[x, y, z]: [f64; 3]| [cos * x - sin * y, sin * x + cos * y, z];
    let mut count = 0;
    for &kind in Kind::ALL {
        let model = table([0.05, -0.03]).with(Effect::free(kind));
        let plant = model.plant(&some_values(&model)).unwrap();
        if !plant.is_pose_invariant() {
            continue;
        }
        count += 1;
        let here = State { twist: [0.4, -0.3, 0.9], ..State::at_rest([0.3, -0.2, 0.5]) };
        let [x, y, theta] = turned(here.pose);
        let there = State { twist: turned(here.twist), ..State::at_rest([x + 1.5, y - 0.7, theta + turn]) };
        let step = |from: &State<f64>| plant.step(from, [9.0, -4.0, 1.2], Clock::since_contact(0.3), 0.01);
        let (ours, theirs) = (step(&here), step(&there));
        let [x, y, theta] = turned(ours.pose);
        let expected = [[x + 1.5, y - 0.7, theta + turn], turned(ours.twist)];
        for (a, b) in expected.iter().flatten().zip([theirs.pose, theirs.twist].iter().flatten()) {
            assert!((a - b).abs() < 1e-12, "{kind:?}: {a} {b}");
        }
    }
    assert!(count >= 7, "only {count} laws are pose invariant");
}
