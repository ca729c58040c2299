//! Laws that change mass, readings or wheels, compared with equivalent models and conservation laws.

#![allow(clippy::unwrap_used)]

use trundle_model::{Body, Clock, Effect, Kind, Model, Plant, State, to_body, to_world};

const DT: f64 = 2e-3;

/// A table with an offset mass centre.
fn table(mass: f64) -> Model {
    let body = Body::from_footprint(&[[-0.5, -0.4], [0.7, -0.4], [0.7, 0.3], [-0.5, 0.3]], mass).unwrap();
    Model {
        mass: Some(mass),
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

fn wheel(mu_x: f64, mu_y: f64) -> Effect {
    let values = [("x", -0.4), ("y", -0.3), ("angle", 0.2), ("mu_x", mu_x), ("mu_y", mu_y)];
    effect(Kind::ViscousWheel, &values)
}

/// A clock whose time in the recording counts from contact.
fn clock(t: f64, dt: f64) -> Clock {
    Clock { dt, ..Clock::since_contact(t) }
}

/// A push that rotates and reverses, object axes.
fn wrench(t: f64) -> [f64; 3] {
    [40.0 * (3.0 * t).sin(), 25.0 * (5.0 * t).cos(), 9.0 * (4.0 * t).sin()]
}

/// Motion under [`wrench`], including the initial state.
fn roll(
    plant: &Plant<f64>,
    start: State<f64>,
    steps: usize,
    clock: impl Fn(f64) -> Clock,
) -> Vec<State<f64>> {
    let mut motion = vec![start];
    for k in 0..steps {
        let t = (k as f64 + 0.5) * DT;
        motion.push(plant.step(&motion[k], wrench(t), clock(t), DT));
    }
    motion
}

#[track_caller]
fn assert_same(a: &[State<f64>], b: &[State<f64>], tolerance: f64) {
    assert_eq!(a.len(), b.len());
    for (k, (a, b)) in a.iter().zip(b).enumerate() {
        let gaps = a.pose.iter().zip(b.pose).chain(a.twist.iter().zip(b.twist)).map(|(a, b)| (a - b).abs());
        assert!(gaps.fold(0.0, f64::max) <= tolerance, "step {k}: {a:?} is not {b:?}");
    }
}

fn start() -> State<f64> {
    State::moving([0.3, -0.2, 0.7], [0.1, 0.0, -0.3])
}

#[test]
fn an_offset_mass_centre_equals_a_body_with_that_mass_centre() {
    let offset = table(22.0)
        .with(wheel(15.0, 180.0))
        .with(effect(Kind::ComOffset, &[("com_x", 0.25), ("com_y", -0.1)]));
    let mut moved = table(22.0).with(wheel(15.0, 180.0));
    moved.body.com = [0.25, -0.1];
    let motion = |model: &Model| roll(&model.resolved().unwrap(), start(), 500, |t| clock(t, DT));
    assert_same(&motion(&offset), &motion(&moved), 1e-11);
}

#[test]
fn another_spread_of_the_mass_equals_a_body_with_that_inertia() {
    let spread =
        table(22.0).with(wheel(15.0, 180.0)).with(effect(Kind::MassSpread, &[("inertia_factor", 1.44)]));
    let mut wide = table(22.0).with(wheel(15.0, 180.0));
    wide.body.gyration *= 1.2;
    let motion = |model: &Model| roll(&model.resolved().unwrap(), start(), 500, |t| clock(t, DT));
    assert_same(&motion(&spread), &motion(&wide), 1e-11);
}

#[test]
fn a_gripper_adds_its_inertia_to_another_spread_in_any_order() {
    let (spread, gripper) = (
        effect(Kind::MassSpread, &[("inertia_factor", 1.5)]),
        effect(Kind::GripperInertia, &[("mass", 2.0)]),
    );
    let inertia = |model: Model| model.resolved().unwrap().rigid(clock(1.0, DT)).inertia;
    let first = inertia(table(22.0).with(spread.clone()).with(gripper.clone()));
    assert_eq!(first, inertia(table(22.0).with(gripper.clone()).with(spread)));
    let own = table(22.0).resolved().unwrap().object(clock(1.0, DT)).inertia;
    let bare = inertia(table(22.0).with(gripper));
    assert!((first - bare - 0.5 * own).abs() < 1e-12, "{first} is not {bare} + half of {own}");
}

#[test]
fn an_added_load_keeps_the_velocity_and_scales_the_inertia() {
    let load = [("episode", 1.0), ("time", 0.5), ("mass", 7.0)];
    let plant = table(22.0).with(effect(Kind::MassChange, &load)).resolved().unwrap();
    let [light, heavy] = [22.0, 29.0].map(|mass| table(mass).resolved().unwrap());
    let motion = roll(&plant, start(), 500, |t| Clock { episode: 1.0, ..clock(t, DT) });
    assert_same(&motion[..=250], &roll(&light, start(), 250, |t| clock(t, DT)), 1e-11);
    // After the event the motion is that of the heavier body from the same state.
    let mut state = motion[250];
    for (k, after) in motion.iter().enumerate().skip(251) {
        let t = (k as f64 - 0.5) * DT;
        state = heavy.step(&state, wrench(t), clock(t, DT), DT);
        assert_same(&[*after], &[state], 1e-11);
    }
    let of = |episode: f64| plant.rigid(Clock { episode, ..clock(0.2, DT) }).mass;
    assert_eq!([of(0.0), of(1.0), of(2.0)], [22.0, 22.0, 29.0]);
}

#[test]
fn an_event_within_a_step_acts_in_proportion() {
    let load = [("time", 1.0005), ("mass", 8.0)];
    let plant = table(22.0).with(effect(Kind::MassChange, &load)).resolved().unwrap();
    assert!((plant.rigid(clock(1.0, DT)).mass - 24.0).abs() < 1e-9);
}

#[test]
fn the_mass_stays_positive_when_too_much_is_removed() {
    let load = [("time", 0.0), ("mass", -30.0)];
    let rigid = table(22.0).with(effect(Kind::MassChange, &load)).resolved().unwrap().rigid(clock(1.0, DT));
    assert!(rigid.mass > 0.0 && rigid.inertia > 0.0, "{rigid:?}");
}

#[test]
fn a_wheel_event_equals_another_wheel_afterwards() {
    let event = [("episode", 0.0), ("time", 0.5), ("factor_x", 20.0), ("factor_y", 0.5)];
    let plant =
        table(22.0).with(wheel(15.0, 180.0)).with(effect(Kind::WheelEvent, &event)).resolved().unwrap();
    let [before, after] =
        [wheel(15.0, 180.0), wheel(300.0, 90.0)].map(|wheel| table(22.0).with(wheel).resolved().unwrap());
    let motion = roll(&plant, start(), 500, |t| clock(t, DT));
    assert_same(&motion[..=250], &roll(&before, start(), 250, |t| clock(t, DT)), 1e-12);
    let mut state = motion[250];
    for (k, reached) in motion.iter().enumerate().skip(251) {
        let t = (k as f64 - 0.5) * DT;
        state = after.step(&state, wrench(t), clock(t, DT), DT);
        assert_same(&[*reached], &[state], 1e-11);
    }
}

/// World velocity of a point of the object.
fn velocity(state: &State<f64>, [x, y]: [f64; 2]) -> [f64; 2] {
    let [rx, ry, _] = to_world([x, y, 0.0], state.pose[2]);
    let [vx, vy, spin] = state.twist;
    [vx - spin * ry, vy + spin * rx]
}

#[test]
fn gripper_inertia_recovers_the_motion_under_the_true_wrench() {
    const GRASP: [f64; 2] = [0.6, 0.25];
    const GRIPPER: f64 = 1.8;
    let truth = table(22.0).with(wheel(15.0, 60.0)).resolved().unwrap();
    let read = table(22.0).with(wheel(15.0, 60.0)).with(effect(Kind::GripperInertia, &[("mass", GRIPPER)]));
    let read = read.resolved().unwrap();
    let motion = roll(&truth, start(), 500, |t| clock(t, DT));
    let mut state = start();
    for (k, pair) in motion.windows(2).enumerate() {
        // reading = truth + m a at the grasp, with the acceleration of the motion.
        let (a, b) = (velocity(&pair[0], GRASP), velocity(&pair[1], GRASP));
        let heading = (pair[0].pose[2] + pair[1].pose[2]) / 2.0;
        let [fx, fy, _] =
            to_body([0, 1, 2].map(|k| if k < 2 { GRIPPER * (b[k] - a[k]) / DT } else { 0.0 }), heading);
        let t = (k as f64 + 0.5) * DT;
        let [x, y, torque] = wrench(t);
        let reading = [x + fx, y + fy, torque + GRASP[0] * fy - GRASP[1] * fx];
        state = read.step(&state, reading, Clock { grasp: GRASP, ..clock(t, DT) }, DT);
        // Without the law the error reaches a centimetre.
        assert_same(&[state], &[pair[1]], 2e-5);
    }
    let before = Clock { grasp: GRASP, ..clock(-0.1, DT) };
    assert_eq!(read.rigid(before).mass, 22.0, "no gripper mass before contact");
}

#[test]
fn a_gain_divides_the_reading() {
    let gains = [("gain_x", 0.8), ("gain_y", 1.25), ("gain_torque", 2.0)];
    let plant = table(22.0).with(effect(Kind::ForceScale, &gains)).resolved().unwrap();
    assert_eq!(plant.correct([4.0, 5.0, 6.0], clock(1.0, DT)), [5.0, 4.0, 3.0]);
}

#[test]
fn the_first_gain_is_one_if_the_mass_is_free() {
    let weighed = table(22.0).with(Effect::free(Kind::ForceScale));
    let gains = |model: &Model| -> Vec<Option<f64>> { model.slots()[1..].iter().map(|s| s.value).collect() };
    assert_eq!(gains(&weighed), [None, None, None]);
    let unknown = Model { mass: None, ..weighed };
    assert_eq!(gains(&unknown), [Some(1.0), None, None]);
}

/// Composition of poses: `inner` is given in the frame `outer`.
fn compose(outer: [f64; 3], inner: [f64; 3]) -> [f64; 3] {
    let [x, y, _] = to_world([inner[0], inner[1], 0.0], outer[2]);
    [outer[0] + x, outer[1] + y, outer[2] + inner[2]]
}

#[test]
fn a_tracker_offset_changes_only_the_tracked_frame() {
    const OFFSET: [f64; 3] = [0.06, -0.03, 0.2];
    let standing = |mut model: Model| {
        model.body = model.body.with_feet(&[[-0.4, -0.3], [0.6, -0.3], [0.1, 0.2]]);
        let dry = effect(Kind::SupportFriction, &[("force", 9.0)]);
        model
            .with(wheel(15.0, 180.0))
            .with(dry)
            .with(effect(Kind::FloorSlope, &[("accel_x", 0.2), ("accel_y", 0.1)]))
    };
    let offset = [("offset_x", OFFSET[0]), ("offset_y", OFFSET[1]), ("offset_theta", OFFSET[2])];
    let object = standing(table(22.0)).resolved().unwrap();
    let tracked = standing(table(22.0)).with(effect(Kind::TrackerOffset, &offset)).resolved().unwrap();
    let mut own = start();
    let mut seen = State::moving(compose(own.pose, OFFSET), {
        let [vx, vy] = velocity(&own, [OFFSET[0], OFFSET[1]]);
        [vx, vy, own.twist[2]]
    });
    for k in 0..500 {
        let t = (k as f64 + 0.5) * DT;
        // The same wrench, about the tracked frame's origin in its axes.
        let [fx, fy, torque] = wrench(t);
        let moved = to_body([fx, fy, torque - OFFSET[0] * fy + OFFSET[1] * fx], OFFSET[2]);
        own = object.step(&own, wrench(t), clock(t, DT), DT);
        seen = tracked.step(&seen, moved, clock(t, DT), DT);
        let expected = compose(own.pose, OFFSET);
        for axis in 0..3 {
            assert!(
                (seen.pose[axis] - expected[axis]).abs() < 1e-10,
                "step {k}: {seen:?} is not {expected:?}"
            );
        }
    }
}

#[test]
fn cogging_conserves_energy() {
    let cogging = [("amplitude", 12.0), ("period", 0.08), ("phase", 0.4), ("angle", 0.6)];
    let plant = table(22.0).with(effect(Kind::Cogging, &cogging)).resolved().unwrap();
    // Potential A p/2π cos(2π s/p + φ) plus kinetic energy.
    let wave = std::f64::consts::TAU / 0.08;
    let height =
        |pose: [f64; 3]| 12.0 / wave * (wave * (0.6f64.cos() * pose[0] + 0.6f64.sin() * pose[1]) + 0.4).cos();
    let energy = |s: &State<f64>| {
        let [vx, vy] = velocity(s, plant.com);
        0.5 * 22.0 * (vx * vx + vy * vy) + 0.5 * plant.inertia * s.twist[2].powi(2) + height(s.pose)
    };
    let mut state = State::moving([0.0; 3], [0.3, 0.1, 0.0]);
    let (first, mut fastest) = (energy(&state), 0.0f64);
    for k in 0..4000 {
        state = plant.step(&state, [0.0; 3], clock(k as f64 * 5e-4, 5e-4), 5e-4);
        fastest = state.twist[0].hypot(state.twist[1]).max(fastest);
        assert!((energy(&state) - first).abs() < 1e-4, "{} J became {} J", first, energy(&state));
    }
    assert!(fastest > 0.34, "no potential was converted: {fastest} m/s");
}

#[test]
fn quadratic_drag_slows_down_hyperbolically() {
    let mut model = table(10.0).with(effect(Kind::QuadraticDrag, &[("drag", 40.0)]));
    model.dof = [true, false, false];
    let plant = model.resolved().unwrap();
    let mut state = State::moving([0.0; 3], [0.5, 0.0, 0.0]);
    for k in 0..1000 {
        state = plant.step(&state, [0.0; 3], clock(k as f64 * DT, DT), DT);
    }
    let expected = 0.5 / (1.0 + 40.0 / 10.0 * 0.5 * 2.0);
    assert!((state.twist[0] - expected).abs() < 2e-5, "{} is not {expected} m/s", state.twist[0]);
}

#[test]
fn every_effect_round_trips_through_a_file() {
    for &kind in Kind::ALL {
        let value =
            |p: &trundle_model::Param| if p.role.is_choice() { 3.0 } else { 0.2f64.clamp(p.lower, p.upper) };
        let given = kind.spec().params.iter().fold(Effect::free(kind), |e, p| e.with(p.name, Some(value(p))));
        let model = table(22.0).with(given);
        let (again, _) = Model::from_toml(&model.to_toml(None).unwrap()).unwrap();
        assert_eq!(again, model, "{}", kind.spec().kind);
    }
}

#[test]
fn on_a_rail_every_effect_is_finite() {
    for &kind in Kind::ALL {
        let mut model = table(22.0).with(wheel(15.0, 180.0)).with(Effect::free(kind));
        model.dof = [true, false, false];
        let values: Vec<f64> = model.slots().iter().map(|s| s.value.unwrap_or(0.2)).collect();
        let plant = model.plant(&values).unwrap();
        let applied = plant.correct([12.0, 0.0, 0.0], clock(1.0, DT));
        let State { pose, twist, .. } = plant.step(&State::at_rest([0.0; 3]), applied, clock(1.0, DT), DT);
        let name = kind.spec().kind;
        assert!(pose.iter().chain(&twist).all(|v| v.is_finite()), "{name}: {pose:?} {twist:?}");
        assert_eq!([pose[1], pose[2], twist[1], twist[2]], [0.0; 4], "{name}");
    }
}
