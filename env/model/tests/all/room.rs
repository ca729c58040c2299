//! Laws of floor and obstacles compared with known motions: contact, tether, doorsill, patch and grain.

#![allow(clippy::unwrap_used)]

use trundle_model::{Body, Clock, Effect, Fixture, Kind, Model, Plant, State};

fn clock(t: f64, dt: f64) -> Clock {
    Clock { dt, ..Clock::since_contact(t) }
}

fn effect(kind: Kind, values: &[(&str, f64)]) -> Effect {
    values.iter().fold(Effect::free(kind), |effect, (name, value)| effect.with(name, Some(*value)))
}

fn rectangle([x, y]: [f64; 2], [w, h]: [f64; 2]) -> Fixture {
    Fixture::Polygon { vertices: vec![[x, y], [x + w, y], [x + w, y + h], [x, y + h]], density: 1.0 }
}

fn model(body: Body, effects: Vec<Effect>) -> Model {
    Model {
        mass: Some(body.mass),
        body,
        dof: [true; 3],
        effects,
        priors: Default::default(),
        discrepancy: None,
    }
}

fn table(mass: f64) -> Body {
    Body::from_fixtures(vec![rectangle([-0.6, -0.4], [1.2, 0.8])], mass).unwrap()
}

fn post(x: f64, y: f64) -> Effect {
    effect(Kind::ObstacleContact, &[("x", x), ("y", y)])
}

fn moving(twist: [f64; 3]) -> State<f64> {
    State::moving([0.0; 3], twist)
}

/// Motion under a constant wrench, object axes, including the initial state.
fn roll(plant: &Plant<f64>, start: State<f64>, wrench: [f64; 3], dt: f64, duration: f64) -> Vec<State<f64>> {
    let mut motion = vec![start];
    for k in 0..(duration / dt).round() as usize {
        motion.push(plant.step(&motion[k], wrench, clock(k as f64 * dt, dt), dt));
    }
    motion
}

/// Kinetic energy of a body whose mass centre is its origin, J.
fn kinetic(body: &Body, state: &State<f64>) -> f64 {
    let [vx, vy, spin] = state.twist;
    (body.mass * (vx * vx + vy * vy) + body.inertia() * spin * spin) / 2.0
}

/// Penetration depth of a round obstacle into the body's shape, m.
fn depth(body: &Body, state: &State<f64>, [x, y]: [f64; 2], radius: f64) -> f64 {
    let (sin, cos) = state.pose[2].sin_cos();
    let (dx, dy) = (x - state.pose[0], y - state.pose[1]);
    radius - body.outside([cos * dx + sin * dy, cos * dy - sin * dx]).0
}

#[test]
fn a_post_stops_light_and_heavy_tables_at_long_steps() {
    for mass in [5.0, 22.0, 50.0] {
        for dt in [2e-3, 8e-3] {
            // In the middle of the front, near a corner, and at the corner itself.
            for y in [0.0, 0.37, 0.41] {
                let body = table(mass);
                let plant = model(body.clone(), vec![post(0.75, y)]).resolved().unwrap();
                let motion = roll(&plant, moving([0.4, 0.0, 0.1]), [0.0; 3], dt, 2.0);
                let start = kinetic(&body, &motion[0]);
                let deepest = motion.iter().map(|s| depth(&body, s, [0.75, y], 0.05)).fold(0.0, f64::max);
                assert!(deepest < 0.012, "{mass} kg, {dt} s, y = {y}: {deepest} m deep");
                for state in &motion {
                    assert!(kinetic(&body, state) <= start * (1.0 + 1e-3), "{mass} kg, {dt} s: {state:?}");
                }
            }
        }
    }
}

#[test]
fn a_push_against_a_post_comes_to_rest() {
    let plant = model(table(22.0), vec![post(0.75, 0.0)]).resolved().unwrap();
    let last = *roll(&plant, State::at_rest([0.0; 3]), [50.0, 0.0, 0.0], 4e-3, 4.0).last().unwrap();
    assert!(last.twist.iter().all(|v| v.abs() < 1e-4), "{last:?}");
    // 50 N on 3·10⁴ N/m: 1.7 mm.
    assert!((last.pose[0] - 0.1 - 50.0 / 3e4).abs() < 3e-4, "{last:?}");
}

#[test]
fn an_l_of_two_fixtures_behaves_like_one_fixture() {
    let corner = [[0.0, 0.0], [1.0, 0.0], [1.0, 0.5], [0.5, 0.5], [0.5, 1.0], [0.0, 1.0]];
    let whole = Body::from_footprint(&corner, 20.0).unwrap();
    let parts = vec![rectangle([0.0, 0.0], [1.0, 0.5]), rectangle([0.0, 0.5], [0.5, 0.5])];
    let parts = Body::from_fixtures(parts, 20.0).unwrap();
    let wheel = [("x", 0.4), ("y", 0.4), ("angle", 0.0), ("mu_x", 40.0), ("mu_y", 40.0)];
    let end = |body: Body| {
        let effects = vec![post(0.7, 0.72), effect(Kind::ViscousWheel, &wheel)];
        let spin = effect(Kind::SpinDrag, &[("spin", 1e4)]);
        let plant = model(body, effects).with(spin).resolved().unwrap();
        *roll(&plant, State::at_rest([0.0; 3]), [30.0, 36.0, 2.4], 4e-3, 6.0).last().unwrap()
    };
    let (one, other) = (end(whole), end(parts));
    for k in 0..3 {
        assert!((one.pose[k] - other.pose[k]).abs() < 1e-6, "{one:?} {other:?}");
        assert!(one.twist[k].abs() < 1e-3, "still moving: {one:?}");
    }
    // The post lies in the notch, a radius from both sides except for its compliance.
    let (sin, cos) = one.pose[2].sin_cos();
    let (dx, dy) = (0.7 - one.pose[0], 0.72 - one.pose[1]);
    let place = [cos * dx + sin * dy, cos * dy - sin * dx];
    assert!(place.iter().all(|v| (v - 0.55).abs() < 3e-3), "{place:?}");
}

#[test]
fn friction_at_a_post_slows_sliding_along_it() {
    let slide = |friction: f64| {
        let post = post(0.1, 0.45).with("friction", Some(friction));
        let wheel = [("x", 0.0), ("y", 0.0), ("angle", 0.0), ("mu_x", 20.0), ("mu_y", 20.0)];
        let effects =
            vec![post, effect(Kind::ViscousWheel, &wheel), effect(Kind::SpinDrag, &[("spin", 1e4)])];
        let plant = model(table(22.0), effects).resolved().unwrap();
        roll(&plant, State::at_rest([0.0; 3]), [20.0, 30.0, 0.0], 4e-3, 1.0).last().unwrap().twist[0]
    };
    let left = 1.0 - (-20.0 / 22.0f64).exp();
    assert!((slide(0.0) - left).abs() < 5e-3);
    // A normal force of 30 N and a coefficient of 0.4 leave 8 of 20 N.
    assert!((slide(0.4) - 0.4 * left).abs() < 0.02, "{}", slide(0.4));
}

#[test]
fn a_doorsill_conserves_energy() {
    let feet = [[-0.5, -0.3], [0.5, -0.3], [0.5, 0.3], [-0.5, 0.3]];
    let body = table(20.0).with_feet(&feet);
    let sill = effect(Kind::Doorsill, &[("angle", 0.0), ("offset", 0.7), ("height", 0.005)]);
    let plant = model(body, vec![sill]).resolved().unwrap();
    let fast = roll(&plant, moving([0.4, 0.0, 0.0]), [0.0; 3], 2e-3, 4.0);
    assert!(fast[fast.len() - 1].pose[0] > 1.3, "the feet are past the sill");
    assert!((fast[fast.len() - 1].twist[0] - 0.4).abs() < 1e-4);
    // At the top two of four feet are raised by 5 mm: v² = v₀² − g h.
    let top = fast.iter().map(|s| s.twist[0]).fold(f64::INFINITY, f64::min);
    assert!((top - (0.16f64 - 9.81 * 0.005).sqrt()).abs() < 1e-3, "{top}");
    let slow = roll(&plant, moving([0.2, 0.0, 0.0]), [0.0; 3], 2e-3, 4.0);
    assert!((slow[slow.len() - 1].twist[0] + 0.2).abs() < 1e-4, "the table rolls back");
}

#[test]
fn a_tether_is_slack_and_then_a_spring() {
    let values = [
        ("x", 0.0),
        ("y", 0.0),
        ("anchor_x", -1.0),
        ("anchor_y", 0.0),
        ("stiffness", 80.0),
        ("rest_length", 1.5),
    ];
    let plant = model(table(20.0), vec![effect(Kind::Tether, &values)]).resolved().unwrap();
    let motion = roll(&plant, moving([0.5, 0.0, 0.0]), [0.0; 3], 2e-3, 4.0);
    assert!((motion[400].twist[0] - 0.5).abs() < 1e-9, "slack until 0.5 m");
    let farthest = motion.iter().map(|s| s.pose[0]).fold(0.0, f64::max);
    // ½ k e² = ½ m v², up to the smoothing of the corner.
    assert!((farthest - 0.5 - 0.5 * (20.0f64 / 80.0).sqrt()).abs() < 2e-3, "{farthest}");
    assert!((motion[motion.len() - 1].twist[0] + 0.5).abs() < 1e-4, "the tether conserves energy");
}

#[test]
fn a_patch_acts_on_the_corners_inside_it() {
    let values = [
        ("x", 2.0),
        ("y", 0.0),
        ("half_length", 1.0),
        ("half_width", 0.2),
        ("angle", std::f64::consts::FRAC_PI_2),
        ("mu", 10.0),
    ];
    let plant = model(table(20.0), vec![effect(Kind::FloorPatch, &values)]).resolved().unwrap();
    let drag = |x: f64| {
        let state = State::moving([x, 0.0, 0.0], [1.0, 0.0, 0.0]);
        -plant.generalised_force(&state, clock(0.0, 2e-3)).wrench([1.0, 0.0, 0.0])[0]
    };
    for (x, expected) in [(0.0, 0.0), (1.4, 20.0), (2.0, 0.0), (2.6, 20.0), (4.0, 0.0)] {
        assert!((drag(x) - expected).abs() < 1e-6, "at {x}: {} N", drag(x));
    }
}

#[test]
fn a_grain_keeps_its_direction_in_the_world() {
    let grain = effect(Kind::FloorGrain, &[("mu", 12.0), ("angle", 0.5)]);
    let plant = model(table(20.0), vec![grain]).resolved().unwrap();
    for heading in [0.0, 1.0, -2.5] {
        let state = State::moving([0.3, 0.1, heading], [0.2, 0.5, 0.0]);
        let along = 0.2 * 0.5f64.cos() + 0.5 * 0.5f64.sin();
        let body = trundle_model::to_body(state.twist, heading);
        let force =
            trundle_model::to_world(plant.generalised_force(&state, clock(0.0, 2e-3)).wrench(body), heading);
        assert!((force[0] + 12.0 * along * 0.5f64.cos()).abs() < 1e-12);
        assert!((force[1] + 12.0 * along * 0.5f64.sin()).abs() < 1e-12 && force[2].abs() < 1e-12);
    }
}
