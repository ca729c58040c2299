//! Two models that a recording cannot distinguish, the discriminating experiment, and the diagnosis after it.

use super::setup::{Instruments, Limits, Setup};
use super::synthetic::simulate_push;
use super::{CompetingModel, Experiment, Profile, Push, certificate, experiment};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use trundle_infer::{Comparison, Fit, FitOptions, Quiet, fit};
use trundle_model::{Body, Effect, Kind, Model};
use trundle_record::{Dataset, Noise, Prepared};

const NOISE: Noise = Noise { pose: [5e-4, 5e-4, 1.75e-3], force: 0.4, torque: 0.05, time: 0.0, stated: true };

fn table(effects: Vec<Effect>) -> Model {
    let corners = [[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]];
    let body = Body::from_footprint(&corners, 22.0).unwrap();
    Model { body, mass: None, dof: [true; 3], effects, priors: Default::default(), discrepancy: None }
}

fn effect(kind: Kind, values: &[(&str, f64)]) -> Effect {
    values.iter().fold(Effect::free(kind), |e, (name, value)| e.with(name, Some(*value)))
}

/// A table with support drag on a sloping floor.
fn truth() -> Model {
    let drag = effect(Kind::SupportDrag, &[("mu", 25.0), ("spread", 1.0)]);
    let slope = effect(Kind::FloorSlope, &[("accel_x", 0.03), ("accel_y", -0.02)]);
    Model { mass: Some(22.0), ..table(vec![drag, slope]) }
}

fn competing_models() -> [Model; 2] {
    [Kind::FloorSlope, Kind::ForceBias]
        .map(|kind| table(vec![Effect::free(Kind::SupportDrag), Effect::free(kind)]))
}

/// A noisy recording of a push.
fn recorded(push: &Push, ordinal: usize) -> Prepared {
    let instruments = Instruments::with(NOISE);
    let mut episode = simulate_push(&truth().resolved().unwrap(), push, &instruments, ordinal);
    let mut rng = ChaCha8Rng::seed_from_u64(ordinal as u64);
    let mut normal = |sd: f64| sd * rng.sample::<f64, _>(StandardNormal);
    let tare = instruments.tare.map(&mut normal);
    for sample in &mut episode.wrench {
        let sd = [NOISE.force, NOISE.force, NOISE.torque];
        sample.reading = [0, 1, 2].map(|k| sample.reading[k] + tare[k] + normal(sd[k]));
    }
    for sample in &mut episode.pose {
        sample.pose = [0, 1, 2].map(|k| sample.pose[k] + normal(NOISE.pose[k]));
    }
    episode
}

/// Pushes along the table's x at the middle of its short side, always from the same pose, so that nothing
/// rotates.
fn same_start_pushes() -> Dataset {
    let push = |profile, force| Push {
        grasp: [0.57, 0.0],
        direction: 0.0,
        start: [0.0; 3],
        profile,
        force,
        torque: 0.0,
        duration: 4.0,
    };
    let pushes = [
        push(Profile::ThereAndBack, 12.0),
        push(Profile::Shuttle, 20.0),
        push(Profile::Steady, 9.0),
        push(Profile::Pulses, 15.0),
    ];
    let training = pushes.iter().enumerate().map(|(k, push)| recorded(push, k)).collect();
    Dataset {
        name: "table".to_owned(),
        body: truth().body,
        dof: [true; 3],
        noise: NOISE,
        point_contact: false,
        commanded: false,
        wrench_pose: Default::default(),
        mass_given: None,
        training,
        held_out: vec![],
        obstacles: vec![],
    }
}

fn fitted(data: &Dataset) -> (Comparison, [Fit; 2]) {
    let comparison = Comparison::of(data).unwrap();
    let fits = competing_models().map(|m| fit(&comparison, &m, &[], &FitOptions::default(), &Quiet).unwrap());
    (comparison, fits)
}

fn designed(data: &Dataset, fits: &[Fit; 2], count: usize) -> Experiment {
    let setup = Setup::from_recording(data, &fits[0].channels, Limits::default());
    let [a, b] =
        [CompetingModel::from_fit("floor_slope", &fits[0]), CompetingModel::from_fit("force_bias", &fits[1])];
    experiment(&setup, &a, &b, count, &Quiet).unwrap()
}

#[test]
fn the_designed_push_discriminates_between_indistinguishable_models() {
    let mut data = same_start_pushes();
    let (comparison, fits) = fitted(&data);
    let tie = certificate(&comparison, ["floor_slope", "force_bias"], [&fits[0], &fits[1]]).unwrap();
    assert!(tie.same && tie.sigmas < 0.5, "{tie:?}");

    let plan = designed(&data, &fits, 1);
    let push = plan.pushes[0].push;
    assert!(plan.sure > 0.95 && plan.repeats == Some(1));
    let turned = (push.start[2] - data.training[0].pose[0].pose[2]).abs() > 0.5;
    assert!(turned || push.profile.turns() || push.grasp[1].abs() > 0.3, "its heading must change: {push:?}");

    data.training.push(recorded(&push, 4));
    let (comparison, fits) = fitted(&data);
    let after = certificate(&comparison, ["floor_slope", "force_bias"], [&fits[0], &fits[1]]).unwrap();
    assert!(!after.same && after.sigmas > 5.0 && after.position > Some(0.01), "{after:?}");
    assert!(after.log_likelihood_difference > 0.3 * plan.separation[0], "{after:?}");
}

#[test]
fn repeating_recorded_pushes_separates_less_than_the_designed_push() {
    let data = same_start_pushes();
    let (_, fits) = fitted(&data);
    let best = designed(&data, &fits, 1);
    let [a, b] = [CompetingModel::from_fit("a", &fits[0]), CompetingModel::from_fit("b", &fits[1])];
    let setup = Setup::from_recording(&data, &fits[0].channels, Limits::default());
    let search = super::search::PushSearch::new(&setup, [&a, &b], &Quiet).unwrap();
    let usual = Push { force: 12.0, profile: Profile::ThereAndBack, ..best.pushes[0].push };
    let usual =
        Push { grasp: [0.57, 0.0], direction: 0.0, start: [0.0; 3], duration: 4.0, torque: 0.0, ..usual };
    let [repeated, _] = search.separations_after_refit(&[usual]).unwrap();
    assert!(repeated < 0.05 * best.separation[0], "{repeated} {:?}", best.separation);
}

#[test]
fn a_drifting_object_gets_a_shorter_push() {
    let data = same_start_pushes();
    let (_, fits) = fitted(&data);
    let [a, b] =
        [CompetingModel::from_fit("floor_slope", &fits[0]), CompetingModel::from_fit("force_bias", &fits[1])];
    let limits = Limits { distance: 0.1, ..Limits::default() };
    let plan =
        experiment(&Setup::from_recording(&data, &fits[0].channels, limits), &a, &b, 1, &Quiet).unwrap();
    assert!(plan.is_informative(), "{plan:?}");
    assert!(plan.pushes[0].push.duration < 4.0, "{:?}", plan.pushes[0].push);
}

#[test]
fn tracker_noise_does_not_raise_the_limit_of_spin() {
    // The object moves along a line: its apparent rotation is noise, here three times as large, and the default
    // applies.
    let mut data = same_start_pushes();
    data.noise.pose[2] *= 3.0;
    data.training.iter_mut().flat_map(|e| &mut e.pose).for_each(|p| p.pose[2] *= 3.0);
    assert_eq!(Limits::from_recording(&data).spin, Limits::default().spin);
}

#[test]
fn no_push_separates_a_model_from_itself() {
    let data = same_start_pushes();
    let (_, fits) = fitted(&data);
    let plan = designed(&data, &[fits[0].clone(), fits[0].clone()], 1);
    assert!(!plan.is_informative() && plan.repeats.is_none(), "{plan:?}");
    assert!(plan.sentence.starts_with("No push"));
}

#[test]
#[ignore = "slow: two diagnoses; tests/design/test_loop.py makes the same ones"]
fn the_push_that_a_diagnosis_proposes_resolves_the_tie() {
    let mut data = same_start_pushes();
    let nominal = table(vec![Effect::free(Kind::SupportDrag)]);
    let options = crate::Options { model: Some(nominal), ..Default::default() };
    let answer = crate::diagnose(&data, &options, &Quiet).unwrap().answer;
    let tied: Vec<&str> = answer.tied.iter().flatten().map(String::as_str).collect();
    assert!(tied.contains(&"floor_slope") && tied.contains(&"force_bias"), "{:?}", answer.tied);
    assert!(answer.certificates.iter().any(|c| c.same), "{:?}", answer.certificates);
    let between = |e: &&Experiment| e.models.iter().all(|name| tied.contains(&name.as_str()));
    let plan = answer.experiments.iter().find(between).expect("an experiment for the tie");
    assert!(answer.alternatives.iter().any(|a| a.experiment == plan.sentence));

    data.training.push(recorded(&plan.pushes[0].push, 4));
    let answer = crate::diagnose(&data, &options, &Quiet).unwrap().answer;
    assert_eq!(answer.missing.iter().map(|m| m.effect.as_str()).collect::<Vec<_>>(), ["floor_slope"]);
    assert!(answer.tied.is_empty(), "{:?}", answer.tied);
}
