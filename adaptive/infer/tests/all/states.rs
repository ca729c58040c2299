//! Laws with own states: the initial states are estimated from the first second, which the error metrics
//! exclude.
#![allow(clippy::unwrap_used)]

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use trundle_fixtures::{NOISE, effect, locked, table};
use trundle_infer::{
    Channels, Fit, FitOptions, MotionLikelihood, Quiet, Score, fit, open_loop, score, score_compared,
    unscored_time,
};
use trundle_model::{Clock, Effect, Kind, Model, Plant, State, transport};
use trundle_record::{Counts, PoseSample, Prepared, WrenchSample};

const CONTACT: f64 = 0.4;
const DT: f64 = 5e-4;
const GRASPS: [[f64; 3]; 3] = [[-0.6, 0.1, 0.0], [0.2, -0.4, 1.2], [0.6, 0.2, -2.8]];

fn force(t: f64) -> [f64; 3] {
    let on = ((t - CONTACT) / 0.1).clamp(0.0, 1.0);
    [on * (14.0 + 22.0 * (2.4 * t).sin()), on * 10.0 * (3.7 * t).cos(), on * (2.1 * t).sin()]
}

/// A push of five seconds that starts with the laws' own states at `own`; `quiet` scales the noise.
fn push(plant: &Plant<f64>, own: &[f64], quiet: f64) -> Prepared {
    push_at(0, plant, own, quiet)
}

/// The same at one of the grasps.
fn push_at(ordinal: usize, plant: &Plant<f64>, own: &[f64], quiet: f64) -> Prepared {
    let grasp = GRASPS[ordinal % 3];
    let mut rng = ChaCha8Rng::seed_from_u64(3 + ordinal as u64);
    let mut normal = |sd: f64| quiet * sd * rng.sample::<f64, _>(StandardNormal);
    let mut inner = [0.0; trundle_model::MAX_INNER_STATES];
    inner[..own.len()].copy_from_slice(own);
    let mut state = State::at_rest([0.2, -0.1, 0.4]).with_inner(inner);
    let (mut wrench, mut pose) = (vec![], vec![]);
    for k in 0..10_000 {
        let t = k as f64 * DT;
        if k % 8 == 0 {
            let (clean, sd) = (force(t), [NOISE.force, NOISE.force, NOISE.torque]);
            wrench.push(WrenchSample {
                t,
                reading: [0, 1, 2].map(|i| clean[i] + normal(sd[i])),
                frame: grasp,
                ..Default::default()
            });
        }
        if k % 32 == 0 {
            pose.push(PoseSample { t, pose: [0, 1, 2].map(|i| state.pose[i] + normal(NOISE.pose[i])) });
        }
        let clock = Clock { t: t + DT / 2.0, dt: DT, ..Clock::since_contact(t - CONTACT) };
        state = plant.step(&state, transport(force(t + DT / 2.0), grasp), clock, DT);
    }
    Prepared {
        name: format!("push_{ordinal}"),
        ordinal,
        wrench,
        pose,
        contact: CONTACT,
        tare_sd: [0.04, 0.04, 0.005],
        at_rest: true,
        counts: Counts::default(),
        ..Default::default()
    }
}

/// The table on one rolling wheel and a caster.
fn on_a_caster() -> Model {
    let caster = [("x", 0.5), ("y", 0.3), ("trail", 0.05), ("mu_side", 80.0)];
    locked().with(effect(Kind::CasterSwivel, &caster))
}

fn loaded() -> Model {
    let load = [("x", 0.3), ("y", -0.2), ("mass", 6.0), ("frequency", 1.3), ("damping_ratio", 0.02)];
    locked().with(effect(Kind::SwingingLoad, &load))
}

fn values(model: &Model) -> Vec<f64> {
    model.slots().iter().map(|slot| slot.value.unwrap()).collect()
}

fn scored(model: &Model, episode: &Prepared) -> Score {
    let channels = Channels::of(&NOISE);
    score(model, &values(model), &channels, std::slice::from_ref(episode), &NOISE, false).unwrap()
}

#[test]
fn a_casters_first_angle_is_found_in_open_loop() {
    let plant = on_a_caster().resolved().unwrap();
    for first in [2.2, -0.6, -2.9, 0.4] {
        let episode = push(&plant, &[first], 0.0);
        let simulated = open_loop(&plant, &episode);
        let farthest =
            simulated.iter().zip(&episode.pose).map(|(a, b)| (a[0] - b.pose[0]).hypot(a[1] - b.pose[1]));
        let farthest = farthest.fold(0.0, f64::max);
        assert!(farthest < 1e-3, "from {first}: {farthest} m off");
    }
}

#[test]
fn the_initial_caster_angle_changes_the_motion() {
    // This shows that the previous test can fail.
    let plant = on_a_caster().resolved().unwrap();
    let ends: Vec<_> = [2.2, 0.4].map(|first| push(&plant, &[first], 0.0).pose.last().unwrap().pose).to_vec();
    assert!((ends[0][0] - ends[1][0]).hypot(ends[0][1] - ends[1][1]) > 0.01, "{ends:?}");
}

#[test]
fn the_first_second_is_excluded_for_both() {
    assert_eq!(
        [unscored_time(&on_a_caster()), unscored_time(&loaded()), unscored_time(&locked())],
        [1.0, 0.0, 0.0]
    );
    let clean = push(&on_a_caster().resolved().unwrap(), &[2.2], 1.0);
    let mut moved = clean.clone();
    for sample in moved.pose.iter_mut().filter(|p| p.t > CONTACT && p.t < CONTACT + 1.0) {
        sample.pose[1] += 0.05;
    }
    moved.motion_cache = Default::default();
    let (model, channels) = (locked(), Channels::of(&NOISE));
    let compared = |episode: &Prepared, other: &Model| {
        let (episodes, other_values) = (std::slice::from_ref(episode), values(other));
        let other = Some((other, &other_values[..]));
        score_compared(&model, &values(&model), &channels, episodes, &NOISE, false, other).unwrap()
    };
    let caster = on_a_caster();
    assert_eq!(compared(&clean, &caster).position_rmse, compared(&moved, &caster).position_rmse);
    assert_ne!(compared(&clean, &model).position_rmse, compared(&moved, &model).position_rmse);
}

#[test]
fn windows_start_alike_with_and_without_states() {
    let light = [("x", 0.3), ("y", -0.2), ("mass", 1e-6), ("frequency", 1.3), ("damping_ratio", 0.02)];
    let light = locked().with(effect(Kind::SwingingLoad, &light));
    let episode = push(&loaded().resolved().unwrap(), &[], 1.0);
    let [with, without] = [&light, &locked()].map(|model| scored(model, &episode));
    let [with, without] = [with, without].map(|score| score.window_position_rmse.unwrap());
    assert!((with / without - 1.0).abs() < 1e-3, "{with} {without}");
}

#[test]
fn errors_of_the_true_model_are_those_of_noise() {
    for (model, own) in [(on_a_caster(), vec![2.2]), (loaded(), vec![])] {
        let episode = push(&model.resolved().unwrap(), &own, 1.0);
        let (with, without) = (scored(&model, &episode), scored(&locked(), &episode));
        for (name, with, without, most) in [
            ("open loop", with.position_rmse, without.position_rmse, 0.01),
            ("window", with.window_position_rmse, without.window_position_rmse, 0.01),
            ("force", with.force_rmse, without.force_rmse, 3.0),
        ] {
            let (with, without) = (with.unwrap(), without.unwrap());
            assert!(with < most && 2.0 * with < without, "{name}: {with} with, {without} without");
        }
        assert!(with.log_predictive_density > without.log_predictive_density);
    }
}

/// Three pushes fitted with the last effect of the truth free and the mass known.
fn fitted(truth: &Model, starts: [&[f64]; 3]) -> Fit {
    let plant = truth.resolved().unwrap();
    let episodes: Vec<_> = starts.iter().enumerate().map(|(k, own)| push_at(k, &plant, own, 1.0)).collect();
    let likelihood = MotionLikelihood::new(&episodes, &NOISE).unwrap();
    let kind = truth.effects.last().unwrap().kind;
    let model = Model::nominal(table(), Some(22.0), [true; 3]).with(Effect::free(kind));
    fit(&likelihood, &model, &[], &FitOptions::default(), &Quiet).unwrap()
}

#[track_caller]
fn assert_found(fit: &Fit, name: &str, truth: f64, tolerance: f64) {
    let estimate = fit.estimates.iter().find(|e| e.name == name).unwrap();
    assert!((estimate.mean - truth).abs() < tolerance, "{name}: {} ± {}", estimate.mean, estimate.sd);
}

#[test]
fn a_caster_comes_back_from_three_pushes() {
    let fit = fitted(&on_a_caster(), [&[2.2], &[-1.0], &[0.3]]);
    for (name, truth, tolerance) in
        [("x", 0.5, 0.05), ("y", 0.3, 0.05), ("trail", 0.05, 0.02), ("mu_side", 80.0, 20.0)]
    {
        assert_found(&fit, &format!("caster_swivel.{name}"), truth, tolerance);
    }
}

#[test]
fn a_swinging_load_comes_back_from_three_pushes() {
    let fit = fitted(&loaded(), [&[], &[], &[]]);
    for (name, truth, tolerance) in
        [("x", 0.3, 0.05), ("y", -0.2, 0.05), ("mass", 6.0, 0.6), ("frequency", 1.3, 0.05)]
    {
        assert_found(&fit, &format!("swinging_load.{name}"), truth, tolerance);
    }
}
