//! Costs and their derivatives, compared with finite differences.

use super::*;
use crate::{Pushes, noisy, transitions};
use trundle_model::{Body, Effect, FreeMotion, Kind, ModelInstance, State};
use trundle_record::{Counts, PoseSample, WrenchSample};

const NOISE: Noise = Noise { pose: [1e-3; 3], force: 0.4, torque: 0.05, time: 0.0, stated: true };
const CUTS: [Cut; 3] = [Cut::Steps { stride: 2 }, Cut::Final, Cut::Windows { length: 0.3 }];

fn model() -> Model {
    let footprint = [[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]];
    Model::nominal(Body::from_footprint(&footprint, 22.0).unwrap(), None, [true; 3])
        .with(Effect::free(Kind::CoulombFriction))
        .with(Effect::free(Kind::ForceBias))
}

/// A synthetic motion that turns by more than one revolution.
fn episode(name: &str, rate: f64) -> Prepared {
    let wrench = |k: usize| {
        let t = k as f64 * 0.01;
        let reading = [20.0 * (3.0 * t).sin(), 9.0 * (5.0 * t).cos(), (4.0 * t).sin()];
        WrenchSample { t, reading, frame: [-0.6, 0.1, 0.2], ..Default::default() }
    };
    let pose = |k: usize| {
        let t = k as f64 / rate;
        PoseSample { t, pose: [0.5 * t, 0.1 * t * t, 6.0 + 0.9 * t] }
    };
    Prepared {
        ordinal: 0,
        name: name.to_owned(),
        wrench: (0..100).map(wrench).collect(),
        pose: (0..(rate as usize)).map(pose).collect(),
        contact: 0.0,
        tare_sd: [0.04; 3],
        at_rest: false,
        counts: Counts::default(),
        ..Default::default()
    }
}

fn all() -> Vec<Shooting<'static>> {
    let episodes = [episode("fast", 50.0), episode("slow", 30.0)];
    let of = |cut| Shooting::new(&episodes, &NOISE, [true; 3], cut).unwrap();
    let mut model = model();
    model.effects.truncate(1);
    let truth = model.with_values(&[22.0, -0.5, -0.3, 0.2, 15.0, 180.0]).unwrap();
    let data = noisy(&transitions(&truth, 20, 1, &Pushes::default()).unwrap(), &[0.01; 6], 2);
    CUTS.into_iter().map(of).chain([Shooting::of_transitions(&data).unwrap()]).collect()
}

fn values(likelihood: &Shooting<'_>) -> Vec<f64> {
    let coordinates = crate::Coordinates::new(&model());
    let z: Vec<f64> = (0..coordinates.free().len()).map(|k| 0.6 * (1.7 * k as f64).sin()).collect();
    let scatter = [0.02, 0.03, 0.05, 0.08].into_iter().take(likelihood.noise().len());
    coordinates.values(&z).0.into_iter().chain(scatter).collect()
}

fn model_slots() -> usize {
    model().slots().len()
}

fn numeric(likelihood: &Shooting<'_>, values: &[f64], slot: usize) -> f64 {
    let h = 1e-6 * values[slot].abs().max(1e-2);
    let cost = |sign: f64| {
        let mut moved = values.to_vec();
        moved[slot] += sign * h;
        likelihood.cost(&model(), &moved).unwrap()
    };
    (cost(1.0) - cost(-1.0)) / (2.0 * h)
}

#[test]
fn gradient_matches_finite_differences() {
    for likelihood in all() {
        for loss in [Loss::Gaussian, Loss::STUDENT] {
            let likelihood = likelihood.clone().with_loss(loss);
            let values = values(&likelihood);
            let free: Vec<usize> = (0..values.len()).collect();
            let at = likelihood.linearise(&model(), &values, &free).unwrap();
            assert!((at.cost - likelihood.cost(&model(), &values).unwrap()).abs() < 1e-9 * at.cost.abs());
            for slot in 0..values.len() {
                let (exact, numeric) = (at.gradient[slot], numeric(&likelihood, &values, slot));
                let scale = at.gradient.amax().max(1.0);
                let error = (exact - numeric).abs();
                assert!(error < 5e-4 * numeric.abs() + 1e-7 * scale, "{loss:?} {slot}: {exact} {numeric}");
            }
        }
    }
}

#[test]
fn a_simulator_without_slopes_gives_nearly_the_same_gradient() {
    for likelihood in all() {
        let values = values(&likelihood);
        let free: Vec<usize> = (0..values.len()).collect();
        let exact = likelihood.linearise(&model(), &values, &free).unwrap();
        let stepped = likelihood.clone().simulated_by(&FreeMotion);
        let differences = stepped.linearise(&model(), &values, &free).unwrap();
        assert_eq!(exact.cost, differences.cost);
        for k in 0..values.len() {
            let error = (exact.gradient[k] - differences.gradient[k]).abs();
            let scale = exact.curvature[(k, k)].sqrt() + exact.gradient[k].abs();
            // Between two values of a parameter, a step that dry friction divides may be divided once more.
            assert!(error <= 3e-2 * scale, "{k}: {} {}", exact.gradient[k], differences.gradient[k]);
        }
    }
}

#[test]
fn the_curvature_of_the_scatter_has_the_expectation_of_the_second_derivative() {
    // At the scatter that the residuals have, Fisher's information is the second derivative for the normal.
    let likelihood = &all()[2];
    let mut values = values(likelihood);
    let first = model_slots();
    let free = vec![first, first + 1];
    for _ in 0..40 {
        let at = likelihood.linearise(&model(), &values, &free).unwrap();
        for k in 0..2 {
            // A Newton step in the logarithm.
            values[first + k] *= (-at.gradient[k] / (at.curvature[(k, k)] * values[first + k])).exp();
        }
    }
    let at = likelihood.linearise(&model(), &values, &free).unwrap();
    let h = 1e-4 * values[first];
    let mut moved = values.clone();
    moved[first] += h;
    let slope = likelihood.linearise(&model(), &moved, &free).unwrap().gradient[0];
    assert!((slope / h / at.curvature[(0, 0)] - 1.0).abs() < 1e-2);
}

#[test]
fn turning_the_recording_by_whole_turns_changes_nothing() {
    let turned = |turns: f64| {
        let mut episode = Prepared { at_rest: true, ..episode("push", 50.0) };
        for p in &mut episode.pose[20..] {
            p.pose[2] += turns * std::f64::consts::TAU;
        }
        Shooting::new(&[episode], &NOISE, [true; 3], Cut::Final).unwrap()
    };
    let (plain, wound) = (turned(0.0), turned(-2.0));
    let values = values(&plain);
    let costs = [&plain, &wound].map(|l| l.cost(&model(), &values).unwrap());
    assert!((costs[0] - costs[1]).abs() < 1e-6 * costs[0].abs(), "{costs:?}");
}

#[test]
fn windows_share_their_ends_and_cover_the_episode() {
    let likelihood =
        Shooting::new(&[episode("push", 50.0)], &NOISE, [true; 3], Cut::Windows { length: 0.3 }).unwrap();
    assert_eq!(likelihood.observations(), 49);
    assert_eq!(likelihood.segments(), 4);
    for pair in likelihood.segments.windows(2) {
        let length: f64 = pair[0].inputs.iter().map(|i| i.dt).sum();
        assert!((pair[0].t + length - pair[1].t).abs() < 1e-9);
    }
}

#[test]
fn a_simulator_that_fails_is_an_error_with_place_and_time() {
    struct Broken;
    impl Stepper for Broken {
        fn rollout(
            &self,
            _: &ModelInstance<'_>,
            _: &State<f64>,
            inputs: &[trundle_model::StepInput],
        ) -> Result<Vec<State<f64>>, StepError> {
            Err(StepError { step: inputs.len() / 2, reason: "returned [nan]".to_owned() })
        }
    }
    let likelihood = Shooting::new(&[episode("push", 50.0)], &NOISE, [true; 3], Cut::Final).unwrap();
    let likelihood = likelihood.simulated_by(&Broken);
    let error = likelihood.cost(&model(), &values(&likelihood)).unwrap_err().to_string();
    assert!(error.contains("push") && error.contains("0.48") && error.contains("nan"), "{error}");
}

#[test]
fn invalid_segments_and_transitions_are_errors() {
    let refused = |cut| Shooting::new(&[episode("push", 50.0)], &NOISE, [true; 3], cut).err().unwrap();
    assert!(refused(Cut::Windows { length: f64::NAN }).to_string().contains("NaN"));
    assert!(refused(Cut::Steps { stride: 0 }).to_string().contains("steps of 0"));
    assert!(Shooting::of_transitions(&[]).err().unwrap().to_string().contains("no transition"));
    let still = Transition { before: [0.0; 6], wrench: [0.0; 3], dt: 0.0, after: [0.0; 6] };
    assert!(Shooting::of_transitions(&[still]).err().unwrap().to_string().contains("transition 0"));
}
