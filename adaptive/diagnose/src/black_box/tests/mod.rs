//! Diagnosis of a black-box simulator: the table with its wheel.

mod engine;
mod likelihood;

use super::{BlackBox, Simulator, diagnose};
use crate::answer::{Place, Value, Verdict};
use std::cell::RefCell;
use std::sync::atomic::{AtomicUsize, Ordering};
use trundle_fixtures::{World, effect, locked};
use trundle_infer::{Quiet, StateVector, Watch};
use trundle_model::{Clock, Kind, Model, Plant, Prior, Slot, State};
use trundle_record::Dataset;

/// True parameter values.
const VALUES: [f64; 3] = [22.0, 15.0, 180.0];

thread_local! {
    /// The plant with the values of the last step, which takes longer to build than to step.
    static PLANT: RefCell<Option<(Vec<f64>, Plant<f64>)>> = const { RefCell::new(None) };
}

/// Simulator with the parameters mass and the two frictions of the wheel. The wheel's place and angle are constants.
struct Wheeled {
    calls: AtomicUsize,
    fails: bool,
}

impl Simulator for Wheeled {
    fn step(
        &self,
        state: &StateVector,
        wrench: &[f64; 3],
        dt: f64,
        values: &[f64],
    ) -> Result<StateVector, String> {
        self.calls.fetch_add(1, Ordering::Relaxed);
        if self.fails && state[0].abs() > 1e-9 {
            return Err("the engine is on fire".to_owned());
        }
        let [x, y, theta, vx, vy, spin] = *state;
        let start = State::moving([x, y, theta], [vx, vy, spin]);
        let State { pose: [x, y, theta], twist: [vx, vy, spin], .. } = PLANT.with_borrow_mut(|kept| {
            if kept.as_ref().is_none_or(|(own, _)| own != values) {
                let [mass, along, across] = [values[0], values[1], values[2]];
                let plant = locked().plant(&[mass, -0.5, -0.3, 0.2, along, across]);
                *kept = Some((values.to_vec(), plant.map_err(|e| e.to_string())?));
            }
            let (_, plant) = kept.as_ref().unwrap();
            Ok::<_, String>(plant.step(&start, *wrench, Clock::since_contact(1.0), dt))
        })?;
        Ok([x, y, theta, vx, vy, spin])
    }
}

fn wheeled() -> Wheeled {
    Wheeled { calls: AtomicUsize::new(0), fails: false }
}

fn slot(name: &str, unit: &'static str, median: f64) -> Slot {
    Slot {
        name: name.to_owned(),
        unit,
        lower: 0.0,
        upper: 1e5,
        prior: Prior::LogNormal { median, sd: 1.5 },
        value: None,
        effect: None,
    }
}

fn under_test(simulator: &Wheeled, given: bool) -> BlackBox<'_> {
    let parameters =
        vec![slot("mass", "kg", 15.0), slot("along", "N·s/m", 30.0), slot("across", "N·s/m", 100.0)];
    BlackBox { simulator, parameters, start: vec![15.0, 30.0, 100.0], given }
}

fn verdict(data: &Dataset, given: bool) -> crate::report::Outcome {
    let simulator = wheeled();
    let begun = std::time::Instant::now();
    let outcome = diagnose(data, &under_test(&simulator, given), 0, &Quiet).unwrap();
    let answer = &outcome.answer;
    println!(
        "{:?} {:?} in {:.1} s, {} calls, {:?} {:?}",
        answer.verdict,
        answer.missing.iter().map(|m| (&m.effect, m.probability, &m.statement)).collect::<Vec<_>>(),
        begun.elapsed().as_secs_f64(),
        simulator.calls.load(Ordering::Relaxed),
        answer.nominal.after,
        [&answer.fit.training.before, &answer.fit.training.after].map(|s| (s.position_rmse, s.r2)),
    );
    outcome
}

fn pushed(truth: Model) -> Dataset {
    shortened(World::of(truth).recording(3))
}

/// Three training pushes instead of four.
fn shortened(mut data: Dataset) -> Dataset {
    data.training.truncate(3);
    data
}

#[test]
fn a_complete_simulator_is_consistent() {
    let outcome = verdict(&pushed(locked()), false);
    assert_eq!(outcome.answer.verdict, Verdict::Consistent);
    let mass = outcome.answer.nominal.after["mass"].mean.unwrap();
    assert!((mass - 22.0).abs() < 0.5, "{mass}");
}

#[test]
fn wrong_given_values_are_reparameterised() {
    let outcome = verdict(&pushed(locked()), true);
    assert_eq!(outcome.answer.verdict, Verdict::Reparameterised);
}

#[test]
#[ignore = "takes a minute"]
fn a_dry_friction_is_named_and_placed() {
    let friction = [("x", 0.4), ("y", 0.3), ("force", 12.0)];
    let outcome = verdict(&pushed(locked().with(effect(Kind::CoulombFriction, &friction))), false);
    let answer = outcome.answer;
    assert_eq!(answer.verdict, Verdict::Explained);
    assert_eq!(answer.missing.len(), 1);
    assert_eq!(answer.missing[0].effect, "coulomb_friction");
    let Place::Point(at) = &answer.missing[0].place.as_ref().unwrap()["body_point"] else {
        panic!("no point")
    };
    assert!((at.mean[0] - 0.4).hypot(at.mean[1] - 0.3) < 0.05, "{at:?}");
    let Value::Number(force) = &answer.missing[0].parameters["force"] else { panic!("no number") };
    assert!((force.mean - 12.0).abs() < 1.2, "{force:?}");
    let pair = answer.fit.held_out.unwrap();
    assert!(pair.after.position_rmse < pair.before.position_rmse.map(|b| 0.5 * b));
}

#[test]
#[ignore = "takes a minute"]
fn a_slope_and_a_bias_are_distinguished() {
    let slope = effect(Kind::FloorSlope, &[("accel_x", 0.25), ("accel_y", -0.15)]);
    let answer = verdict(&pushed(locked().with(slope)), false).answer;
    assert_eq!((answer.verdict, answer.missing.len()), (Verdict::Explained, 1));
    assert_eq!(answer.missing[0].effect, "floor_slope");
    let world = World { bias: [3.0, -2.0, 0.3], ..World::of(locked()) };
    let answer = verdict(&shortened(world.recording(4)), false).answer;
    assert_eq!((answer.verdict, answer.missing.len()), (Verdict::Explained, 1));
    assert_eq!(answer.missing[0].effect, "force_bias");
}

#[test]
#[ignore = "takes minutes"]
fn laws_with_internal_states_are_named() {
    let caster = effect(Kind::CasterSwivel, &[("x", 0.5), ("y", 0.25), ("trail", 0.06), ("mu_side", 60.0)]);
    let values = [("x", 0.3), ("y", -0.2), ("mass", 5.0), ("frequency", 1.2), ("damping_ratio", 0.02)];
    let load = effect(Kind::SwingingLoad, &values);
    for (hidden, name) in [(caster, "caster_swivel"), (load, "swinging_load")] {
        let answer = verdict(&pushed(locked().with(hidden)), false).answer;
        assert_eq!((answer.verdict, answer.missing.len()), (Verdict::Explained, 1), "{name}");
        assert_eq!(answer.missing[0].effect, name);
    }
}

#[test]
#[ignore = "takes a minute"]
fn a_wrench_outside_the_catalogue_is_unexplained() {
    let force = |state: &State<f64>| {
        let beat = (9.0 * state.pose[0]).sin() * (7.0 * state.pose[1]).cos();
        [12.0 * beat, 0.0, 5.0 * beat]
    };
    let world = World { out_of_catalogue: force, ..World::of(locked()) };
    let answer = verdict(&shortened(world.recording(5)), false).answer;
    assert_eq!(answer.verdict, Verdict::Unexplained);
    assert!(!answer.mismatch.windows.is_empty());
}

#[test]
fn the_error_of_a_failing_simulator_locates_it() {
    let broken = Wheeled { fails: true, ..wheeled() };
    let data = pushed(locked());
    let error = diagnose(&data, &under_test(&broken, false), 0, &Quiet).unwrap_err().to_string();
    for words in ["episode_00", "t = ", "on fire", "mass = 15", "dt = "] {
        assert!(error.contains(words), "{error}");
    }
}

#[test]
fn a_diagnosis_can_be_cancelled() {
    struct Cancelled;
    impl Watch for Cancelled {
        fn progress(&self, _: &str, _: f64) {}
        fn cancelled(&self) -> bool {
            true
        }
    }
    let simulator = wheeled();
    let data = pushed(locked());
    assert!(diagnose(&data, &under_test(&simulator, false), 0, &Cancelled).is_err());
    assert!(simulator.calls.load(Ordering::Relaxed) < 100);
}
