//! Walks the catalogue, so that a new effect is tested on arrival.

#![allow(clippy::unwrap_used)]

use nalgebra::{Matrix3, SymmetricEigen};
use proptest::prelude::*;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};
use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use trundle_model::{
    Acting, Action, Body, Clock, Dual, Effect, INNER, Kind, Lags, Model, Param, Plant, Prior, Real, Rigid,
    State, catalogue, to_body,
};

/// Pose, twist, and the law's own states.
const STATE: usize = 6 + INNER;
/// Derivative columns: the state, the mass and up to ten parameters.
const COLUMNS: usize = STATE + 11;
const DT: f64 = 2e-3;
const DRAWS: usize = 10;
/// Random cases for each kind.
const CASES: usize = 64;

/// Everything random about one step; the draws become parameter values by their priors.
#[derive(Clone, Debug)]
struct Case {
    draws: Vec<f64>,
    state: [f64; STATE],
    applied: [f64; 3],
    clock: Clock,
}

fn cases() -> impl Strategy<Value = Case> {
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
        // As fast as a reading changes, so that no law that looks at it is silent.
        let trend = applied.map(|a| 5.0 * a);
        let clock = Clock { t, dt: DT, grasp, trend, ..Clock::since_contact(since_contact) };
        Case { draws, state, applied, clock }
    })
}

/// Run `check` on the same random cases for every kind.
fn for_every_kind(check: impl Fn(Kind, &Case) -> Result<(), TestCaseError>) {
    for &kind in Kind::ALL {
        let config = Config { cases: CASES as u32, failure_persistence: None, ..Config::default() };
        let mut runner = TestRunner::new_with_rng(config, TestRng::deterministic_rng(RngAlgorithm::ChaCha));
        let outcome = runner.run(&cases(), |case| check(kind, &case));
        assert!(outcome.is_ok(), "{}: {}", kind.spec().kind, outcome.unwrap_err());
    }
}

/// The same table with the effect.
fn model(kind: Kind) -> Model {
    bare(kind).with(Effect::free(kind))
}

/// A table whose mass centre lies off the origin, so that no term vanishes by symmetry; on a wheel where the effect is
/// something that happens to one.
fn bare(kind: Kind) -> Model {
    let body = Body::from_footprint(&[[-0.5, -0.4], [0.7, -0.4], [0.7, 0.3], [-0.5, 0.3]], 22.0).unwrap();
    let effects = if kind == Kind::WheelEvent { vec![wheel()] } else { vec![] };
    Model { body, mass: Some(22.0), dof: [true; 3], effects, priors: Default::default(), unnamed: None }
}

fn wheel() -> Effect {
    Effect { kind: Kind::ViscousWheel, values: [-0.4, -0.3, 0.2, 15.0, 180.0].map(Some).to_vec() }
}

/// An event lies before the step, or well within it, so that its time has a slope.
fn draw(param: &Param, body: &Body, clock: Clock, u: f64) -> f64 {
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

/// Mass and what is given beside the effect, then its parameters as drawn; places in the room within reach of the body.
fn values(kind: Kind, case: &Case) -> Vec<f64> {
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

/// Coordinates of a place in the room, of laws that act near it only.
fn places(kind: Kind) -> Option<[&'static str; 2]> {
    match kind {
        Kind::FloorPatch | Kind::ObstacleContact => Some(["x", "y"]),
        Kind::Tether => Some(["anchor_x", "anchor_y"]),
        _ => None,
    }
}

/// Whether a law acts at some places or readings only: on a stretch of floor, while taut, at the end of a range.
fn is_local(kind: Kind) -> bool {
    matches!(kind, Kind::Doorsill | Kind::Saturation) || places(kind).is_some()
}

/// Whether a law bends within a creep of zero speed along one direction alone, which a small turn crosses.
fn bends(kind: Kind) -> bool {
    matches!(kind, Kind::AxisFriction | Kind::BodyAxisFriction)
}

/// The same with the neutral values in place, refinements left out.
fn neutral(kind: Kind, case: &Case) -> Vec<f64> {
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

fn state<T: Real>(flat: &[T]) -> State<T> {
    let motion = State::moving([flat[0], flat[1], flat[2]], [flat[3], flat[4], flat[5]]);
    State { inner: std::array::from_fn(|k| flat[6 + k]), ..motion }
}

fn flat<T: Real>(state: &State<T>) -> [T; STATE] {
    let all = [state.pose.as_slice(), &state.twist, &state.inner].concat();
    std::array::from_fn(|k| all[k])
}

/// The state after a step under the reading, corrected first, how late the reading is, and the lags.
fn outcome<T: Real>(plant: &Plant<T>, flat_state: &[T], case: &Case) -> [T; STATE + 3] {
    let applied = plant.correct(case.applied.map(T::lift), case.clock);
    let after = flat(&plant.step(&state(flat_state), applied, case.clock, DT));
    let delay = plant.delay(case.clock).unwrap_or_else(T::zero);
    let lags = plant.lags().unwrap_or(Lags { sensor: T::zero(), drive: T::zero() });
    let timing = [delay, lags.sensor, lags.drive];
    std::array::from_fn(|k| after.get(k).copied().unwrap_or_else(|| timing[k - STATE]))
}

/// What of an outcome a recording shows: poses, twists, delay and lags, not the laws' own states.
fn shown(outcome: [f64; STATE + 3]) -> [f64; 9] {
    std::array::from_fn(|k| if k < 6 { outcome[k] } else { outcome[STATE + k - 6] })
}

fn action(kind: Kind, case: &Case) -> Action<f64> {
    model(kind).plant(&values(kind, case)).unwrap().action(&state(&case.state), case.clock)
}

#[test]
fn every_entry_is_complete() {
    let names: BTreeSet<_> = catalogue().map(|spec| spec.kind).collect();
    assert_eq!(names.len(), Kind::ALL.len(), "two kinds share a name");
    for spec in catalogue() {
        let kind = spec.kind;
        assert_eq!(Kind::from_name(kind).map(|k| k.spec().kind), Some(kind));
        for (what, text) in [
            ("effect", spec.effect),
            ("summary", spec.summary),
            ("source", spec.source),
            ("sentence", spec.sentence),
        ] {
            assert!(!text.trim().is_empty(), "{kind}: no {what}");
        }
        assert!(spec.sentence.ends_with('.'), "{kind}: the sentence has no end");
        let names: BTreeSet<_> = spec.params.iter().map(|p| p.name).collect();
        assert_eq!(names.len(), spec.params.len(), "{kind}: two parameters share a name");
        assert!(spec.params.len() <= DRAWS, "{kind}: widen this test");
        for placeholder in placeholders(spec.sentence) {
            assert!(names.contains(placeholder), "{kind}: `{{{placeholder}}}` is no parameter");
        }
    }
}

/// The names in braces.
fn placeholders(sentence: &str) -> impl Iterator<Item = &str> {
    sentence.split('{').skip(1).filter_map(|rest| rest.split('}').next())
}

#[test]
fn every_parameter_has_a_unit_bounds_and_a_prior_inside_them() {
    for spec in catalogue() {
        for p in spec.params {
            let name = format!("{}.{}", spec.kind, p.name);
            assert!(!p.unit.is_empty() && !p.help.is_empty(), "{name}: no unit or no help");
            assert!(p.lower.is_finite() && p.upper.is_finite() && p.lower < p.upper, "{name}: bounds");
            let inside = |value: f64| (p.lower..=p.upper).contains(&value);
            match p.prior {
                Prior::Normal { mean, sd } => assert!(inside(mean) && sd > 0.0, "{name}: prior"),
                Prior::LogNormal { median, sd } => {
                    assert!(p.lower >= 0.0 && median > 0.0 && inside(median) && sd > 0.0, "{name}: prior");
                }
                Prior::Uniform => {}
                Prior::OnBody(axis) => assert!(axis < 2 && p.unit == "m", "{name}: prior"),
                Prior::Angle(period) => {
                    assert!(period > 0.0 && p.upper - p.lower >= period && p.unit == "rad", "{name}: prior");
                }
            }
            assert!(p.refinement.is_none_or(inside), "{name}: refinement");
        }
    }
}

#[test]
fn every_neutral_value_belongs_to_a_parameter_and_is_legal() {
    for spec in catalogue() {
        assert!(!spec.neutral.is_empty(), "{}: nothing makes it vanish", spec.kind);
        for (name, value) in spec.neutral {
            let param = spec.params.iter().find(|p| p.name == *name);
            // The body's own mass centre lies on the body.
            let legal = |p: &Param| {
                (p.lower..=p.upper).contains(value) || matches!(p.prior, Prior::OnBody(_)) && value.is_nan()
            };
            assert!(param.is_some_and(legal), "{}: neutral {name} = {value}", spec.kind);
        }
    }
}

#[test]
fn at_neutral_values_nothing_changes() {
    for_every_kind(|kind, case| {
        let with = model(kind).plant(&neutral(kind, case)).unwrap();
        let without = bare(kind).resolved().unwrap();
        let [with, without] = [with, without].map(|plant| shown(outcome(&plant, &case.state, case)));
        for (a, b) in with.iter().zip(without) {
            prop_assert!((a - b).abs() <= 1e-14 * (1.0 + b.abs()), "{a} is not {b}");
        }
        Ok(())
    });
}

#[test]
fn away_from_neutral_values_something_changes() {
    let silent = RefCell::new(BTreeMap::new());
    for_every_kind(|kind, case| {
        let with = model(kind).plant(&values(kind, case)).unwrap();
        let without = bare(kind).resolved().unwrap();
        let [with, without] = [with, without].map(|plant| shown(outcome(&plant, &case.state, case)));
        let same = with == without;
        prop_assert!(!same || is_local(kind));
        *silent.borrow_mut().entry(kind).or_insert(0) += usize::from(same);
        Ok(())
    });
    // Four cases in five may lie elsewhere.
    assert!(silent.borrow().values().all(|&count| 5 * count < 4 * CASES), "{silent:?}");
}

#[test]
fn gradients_of_a_step_agree_with_finite_differences() {
    for_every_kind(|kind, case| {
        let point: Vec<f64> = case.state.into_iter().chain(values(kind, case)).collect();
        prop_assert!(point.len() <= COLUMNS, "widen this test");
        let seeded: Vec<_> =
            point.iter().enumerate().map(|(k, &v)| Dual::<COLUMNS>::variable(v, k)).collect();
        let exact = outcome(&model(kind).plant(&seeded[STATE..]).unwrap(), &seeded[..STATE], case);
        let first = point.len() - kind.spec().params.len();
        let own = |k: usize| kind.spec().params.get(k.wrapping_sub(first));
        for k in (0..point.len()).filter(|&k| own(k).is_none_or(|p| !p.role.is_choice())) {
            // What begins within a millimetre bends sharply, and where it is stiff rounding grows.
            let (step, least, rounding) = match kind {
                _ if is_local(kind) => (2e-6, 0.5, 2e-12),
                _ if bends(kind) => (2e-6, 0.01, 1e-14),
                _ => (1e-5, 0.01, 1e-14),
            };
            let event = own(k).is_some_and(|p| p.name == "time");
            let h = if event { 1e-3 * DT } else { step * point[k].abs().max(least) };
            let at = |shift: f64| {
                let mut moved = point.clone();
                moved[k] += shift;
                outcome(&model(kind).plant(&moved[STATE..]).unwrap(), &moved[..STATE], case)
            };
            let (plus, minus) = (at(h), at(-h));
            for row in 0..STATE + 3 {
                let difference = (plus[row] - minus[row]) / (2.0 * h);
                let slope = exact[row].eps[k];
                // Rounding of the values, and the curvature of the law.
                let tolerance = rounding / h + 1e-5 * (slope.abs() + 1e-4);
                prop_assert!(
                    (slope - difference).abs() <= tolerance,
                    "row {row} by variable {k}: {slope} is not {difference}"
                );
            }
        }
        Ok(())
    });
}

#[test]
fn what_claims_to_dissipate_never_drives() {
    for_every_kind(|kind, case| {
        let twist = to_body([case.state[3], case.state[4], case.state[5]], case.state[2]);
        let power: f64 = action(kind, case).wrench(twist).iter().zip(twist).map(|(f, v)| f * v).sum();
        prop_assert!(!kind.spec().dissipative || power <= 1e-12, "power {power} W");
        Ok(())
    });
}

#[test]
fn drag_is_positive_semidefinite() {
    for_every_kind(|kind, case| {
        let [xx, xy, yy, tx, ty, tt] = action(kind, case).drag;
        let drag = Matrix3::new(xx, xy, tx, xy, yy, ty, tx, ty, tt);
        let least = SymmetricEigen::new(drag).eigenvalues.min();
        prop_assert!(least >= -1e-12 * drag.trace().max(1.0), "eigenvalue {least}");
        Ok(())
    });
}

#[test]
fn a_law_acts_on_the_object_or_on_the_instruments() {
    for_every_kind(|kind, case| {
        let (plant, bare) = (model(kind).plant(&values(kind, case)).unwrap(), bare(kind).resolved().unwrap());
        let corrects = plant.correct(case.applied, case.clock) != case.applied;
        let reads_otherwise = corrects
            || plant.delay(case.clock).is_some()
            || plant.lags().is_some()
            || plant.mount().is_some();
        let (Action { push, drag }, without) =
            (action(kind, case), bare.action(&state(&case.state), case.clock));
        let pushes = (push, drag) != (without.push, without.drag);
        let [own, whole, plain] =
            [plant.object(case.clock), plant.rigid(case.clock), bare.rigid(case.clock)].map(parts);
        let (weighs, loads) = (own != plain, whole != own && plant.mount().is_none());
        prop_assert!(kind.spec().loads == (weighs || loads), "{own:?} {whole:?} {plain:?}");
        match kind.spec().acting {
            Acting::Object => {
                prop_assert!((pushes || weighs || is_local(kind)) && !reads_otherwise && !loads)
            }
            Acting::Instrument => {
                prop_assert!(!pushes && !weighs && (reads_otherwise || loads || is_local(kind)));
            }
        }
        Ok(())
    });
}

fn parts(rigid: Rigid<f64>) -> [f64; 4] {
    let Rigid { mass, com: [x, y], inertia } = rigid;
    [mass, x, y, inertia]
}

#[test]
fn what_moves_weighs_something() {
    for_every_kind(|kind, case| {
        let rigid = model(kind).plant(&values(kind, case)).unwrap().rigid(case.clock);
        prop_assert!(rigid.mass > 0.0 && rigid.inertia > 0.0, "{rigid:?}");
        Ok(())
    });
}

/// A state seen from a room that is turned by `angle` and moved by `shift`.
fn elsewhere(flat: &[f64; STATE], angle: f64, shift: [f64; 2]) -> [f64; STATE] {
    let (sin, cos) = angle.sin_cos();
    let turned = |x: f64, y: f64| [cos * x - sin * y, sin * x + cos * y];
    let ([x, y], [vx, vy]) = (turned(flat[0], flat[1]), turned(flat[3], flat[4]));
    let mut moved = *flat;
    moved[..5].copy_from_slice(&[x + shift[0], y + shift[1], flat[2] + angle, vx, vy]);
    moved
}

#[test]
fn those_and_only_those_that_claim_it_do_the_same_everywhere() {
    let differing = RefCell::new(BTreeSet::new());
    for_every_kind(|kind, case| {
        let plant = model(kind).plant(&values(kind, case)).unwrap();
        let after = |state: &[f64; STATE]| -> [f64; STATE] {
            let outcome = outcome(&plant, state, case);
            std::array::from_fn(|k| outcome[k])
        };
        let there = after(&elsewhere(&case.state, 0.7, [0.3, -0.2]));
        let expected = elsewhere(&after(&case.state), 0.7, [0.3, -0.2]);
        let same = there.iter().zip(expected).all(|(a, b)| (a - b).abs() <= 1e-11 * (1.0 + b.abs()));
        prop_assert!(same || !plant.same_everywhere(), "{there:?} is not {expected:?}");
        if !same {
            differing.borrow_mut().insert(kind);
        }
        Ok(())
    });
    for &kind in Kind::ALL {
        let claims = model(kind).plant(&draws_of(kind)).unwrap().same_everywhere();
        assert_eq!(claims, !differing.borrow().contains(&kind), "{}", kind.spec().kind);
    }
}

/// Values of a kind's model for which nothing is random.
fn draws_of(kind: Kind) -> Vec<f64> {
    let clock = Clock::since_contact(0.0);
    let case = Case { draws: vec![0.5; DRAWS], state: [0.0; STATE], applied: [0.0; 3], clock };
    values(kind, &case)
}
