//! Random test cases for every kind of effect.

use proptest::prelude::*;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};
use trundle_model::{
    Body, Clock, Effect, GeneralisedForce, Kind, Lags, MAX_INNER_STATES, Model, Param, Plant, Prior, Real,
    State,
};

/// Number of state variables: pose, twist and inner states.
pub const STATE: usize = 6 + MAX_INNER_STATES;
/// Number of derivatives: the state, the mass and up to ten parameters.
pub const COLUMNS: usize = STATE + 11;
pub const DT: f64 = 2e-3;
pub const DRAWS: usize = 10;
/// Number of random cases per kind.
pub const CASES: usize = 64;

/// Random inputs of one step. `draws` are uniform and are mapped to parameter values by their priors.
#[derive(Clone, Debug)]
pub struct Case {
    pub draws: Vec<f64>,
    pub state: [f64; STATE],
    pub applied: [f64; 3],
    pub clock: Clock,
}

pub fn cases() -> impl Strategy<Value = Case> {
    let draws = prop::collection::vec(0.0..1.0f64, DRAWS);
    let own = || -1.5..1.5f64;
    let state = [
        -1.0..1.0f64,
        -1.0..1.0,
        -3.0..3.0,
        -0.5..0.5,
        -0.5..0.5,
        -1.0..1.0,
        own(),
        own(),
        own(),
        own(),
        own(),
    ];
    let applied = [-40.0..40.0f64, -40.0..40.0, -10.0..10.0];
    let grasp = [-0.6..0.8f64, -0.5..0.4];
    (draws, state, applied, 0.0..5.0f64, grasp).prop_map(|(draws, state, applied, since_contact, grasp)| {
        let t = since_contact + 0.4;
        // A trend large enough that every law that uses it has an effect.
        let trend = applied.map(|a| 5.0 * a);
        let clock = Clock { t, dt: DT, grasp, trend, ..Clock::since_contact(since_contact) };
        Case { draws, state, applied, clock }
    })
}

/// Run `check` for every kind on the same random cases.
pub fn for_every_kind(check: impl Fn(Kind, &Case) -> Result<(), TestCaseError>) {
    for &kind in Kind::ALL {
        let config = Config { cases: CASES as u32, failure_persistence: None, ..Config::default() };
        let mut runner = TestRunner::new_with_rng(config, TestRng::deterministic_rng(RngAlgorithm::ChaCha));
        let outcome = runner.run(&cases(), |case| check(kind, &case));
        assert!(outcome.is_ok(), "{}: {}", kind.spec().kind, outcome.unwrap_err());
    }
}

/// The table of [`bare`] with the effect.
pub fn model(kind: Kind) -> Model {
    bare(kind).with(Effect::free(kind))
}

/// A table with an offset mass centre, so that no term vanishes by symmetry. It has a wheel if the effect modifies one.
pub fn bare(kind: Kind) -> Model {
    let body = Body::from_footprint(&[[-0.5, -0.4], [0.7, -0.4], [0.7, 0.3], [-0.5, 0.3]], 22.0).unwrap();
    let effects = if kind == Kind::WheelEvent { vec![wheel()] } else { vec![] };
    Model { body, mass: Some(22.0), dof: [true; 3], effects, priors: Default::default(), discrepancy: None }
}

pub fn wheel() -> Effect {
    Effect { kind: Kind::ViscousWheel, values: [-0.4, -0.3, 0.2, 15.0, 180.0].map(Some).to_vec() }
}

/// Parameter value for a uniform draw `u`. Events lie before the step or well within it, so that the time has a derivative.
pub fn draw(param: &Param, body: &Body, clock: Clock, u: f64) -> f64 {
    let symmetric = 2.0 * u - 1.0;
    if param.role.is_choice() {
        return clock.episode;
    }
    if param.name == "time" {
        return clock.t + DT * if u < 0.3 { -2.0 } else { 0.6 * (u - 0.65) };
    }
    let value = match param.prior {
        Prior::Normal { mean, sd } => mean + 2.0 * sd * symmetric,
        Prior::LogNormal { median, sd } => median * (sd * symmetric).exp(),
        Prior::Uniform => param.lower + u * (param.upper - param.lower),
        Prior::OnBody(axis) => {
            let [low, high] = body.bounds();
            low[axis] + u * (high[axis] - low[axis])
        }
        Prior::Angle(period) => symmetric * period / 2.0,
    };
    value.clamp(param.lower, param.upper)
}

/// Values of all slots: given values, then drawn parameters of the effect. World points are drawn near the body.
pub fn values(kind: Kind, case: &Case) -> Vec<f64> {
    let bare = bare(kind);
    let (body, given) = (&bare.body, bare.slots().into_iter().map(|slot| slot.value.unwrap()));
    let places = places(kind).unwrap_or_default();
    let near = |(k, (p, &u)): (usize, (&Param, &f64))| match places.iter().position(|name| *name == p.name) {
        Some(axis) => case.state[axis] + 1.6 * (u - 0.5),
        None if k == 1 && kind == Kind::Doorsill => {
            let (sin, cos) = draw(&kind.spec().params[0], body, case.clock, case.draws[0]).sin_cos();
            cos * case.state[0] + sin * case.state[1] + 1.2 * (u - 0.5)
        }
        None => draw(p, body, case.clock, u),
    };
    let drawn = kind.spec().params.iter().zip(&case.draws).enumerate().map(near);
    given.chain(drawn).collect()
}

/// Names of the world coordinates of laws that act only near a point.
pub fn places(kind: Kind) -> Option<[&'static str; 2]> {
    match kind {
        Kind::FloorPatch | Kind::ObstacleContact => Some(["x", "y"]),
        Kind::Tether => Some(["anchor_x", "anchor_y"]),
        _ => None,
    }
}

/// Whether a law acts only at some positions or readings.
pub fn is_local(kind: Kind) -> bool {
    matches!(kind, Kind::Doorsill | Kind::Saturation) || places(kind).is_some()
}

/// Whether a law is strongly curved near zero speed along one direction, so that differences need smaller steps.
pub fn is_sharply_curved(kind: Kind) -> bool {
    matches!(kind, Kind::AxisFriction | Kind::BodyAxisFriction)
}

/// [`values`] with neutral values and default refinements.
pub fn neutral(kind: Kind, case: &Case) -> Vec<f64> {
    let spec = kind.spec();
    let (mut values, com) = (values(kind, case), bare(kind).body.com);
    let first = values.len() - spec.params.len();
    for (value, param) in values[first..].iter_mut().zip(spec.params) {
        let stated = spec.neutral.iter().find(|(name, _)| *name == param.name).map(|(_, value)| *value);
        let own = |neutral: f64| match param.prior {
            Prior::OnBody(axis) if neutral.is_nan() => com[axis],
            _ => neutral,
        };
        *value = stated.map(own).or(param.refinement).unwrap_or(*value);
    }
    values
}

pub fn state<T: Real>(flat: &[T]) -> State<T> {
    let motion = State::moving([flat[0], flat[1], flat[2]], [flat[3], flat[4], flat[5]]);
    State { inner: std::array::from_fn(|k| flat[6 + k]), ..motion }
}

pub fn flat<T: Real>(state: &State<T>) -> [T; STATE] {
    let all = [state.pose.as_slice(), &state.twist, &state.inner].concat();
    std::array::from_fn(|k| all[k])
}

/// State after a step under the corrected reading, the delay and the lags.
pub fn outcome<T: Real>(plant: &Plant<T>, flat_state: &[T], case: &Case) -> [T; STATE + 3] {
    let applied = plant.correct(case.applied.map(T::lift), case.clock);
    let after = flat(&plant.step(&state(flat_state), applied, case.clock, DT));
    let delay = plant.delay(case.clock).unwrap_or_else(T::zero);
    let lags = plant.lags().unwrap_or(Lags { sensor: T::zero(), drive: T::zero() });
    let timing = [delay, lags.sensor, lags.drive];
    std::array::from_fn(|k| after.get(k).copied().unwrap_or_else(|| timing[k - STATE]))
}

/// Observable part of an outcome: pose, twist, delay and lags, without inner states.
pub fn shown(outcome: [f64; STATE + 3]) -> [f64; 9] {
    std::array::from_fn(|k| if k < 6 { outcome[k] } else { outcome[STATE + k - 6] })
}

pub fn force(kind: Kind, case: &Case) -> GeneralisedForce<f64> {
    model(kind).plant(&values(kind, case)).unwrap().generalised_force(&state(&case.state), case.clock)
}
