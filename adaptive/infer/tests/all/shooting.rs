//! Estimates of the likelihoods of simulated motion, and their accuracy.
#![allow(clippy::unwrap_used, clippy::expect_used)]

use std::collections::BTreeSet;
use trundle_fixtures::{NOISE, World, effect, locked, table};
use trundle_infer::{
    Cut, Fit, FitOptions, Joint, Likelihood, Loss, Pushes, Quiet, Shooting, fit, guided_fit, noisy,
    open_loop, transitions,
};
use trundle_model::{Kind, Model};
use trundle_record::Prepared;

const WINDOWS: Cut = Cut::Windows { length: 1.0 };
const STEPS: Cut = Cut::Steps { stride: 6 };

fn nominal() -> Model {
    Model::nominal(table(), None, [true; 3])
}

fn shooting(episodes: &[Prepared], cut: Cut) -> Shooting<'static> {
    Shooting::new(episodes, &NOISE, [true; 3], cut).unwrap()
}

fn found(likelihood: &dyn Likelihood, model: &Model) -> Fit {
    fit(likelihood, model, &[], &FitOptions::default(), &Quiet).unwrap()
}

fn value(fit: &Fit, name: &str) -> f64 {
    fit.estimate(name).unwrap().mean
}

/// A fit of eq. 9 that starts from a fit over windows.
fn final_states(episodes: &[Prepared], loss: Loss) -> Fit {
    let [guide, ends] = [WINDOWS, Cut::Final].map(|cut| shooting(episodes, cut).with_loss(loss));
    guided_fit(&guide, &ends, &nominal(), &FitOptions::default(), &Quiet).unwrap()
}

fn assert_locked(fit: &Fit, what: &str) {
    let truth = [22.0, -0.5, -0.3, 0.2, 15.0, 180.0];
    let tolerance = [0.3, 0.01, 0.01, 0.01, 0.6, 9.0];
    assert!(fit.converged, "{what}");
    for ((estimate, truth), tolerance) in fit.estimates.iter().zip(truth).zip(tolerance) {
        assert!(estimate.identified, "{what}: {estimate:?}");
        assert!((estimate.mean - truth).abs() < tolerance, "{what}: {estimate:?}");
    }
}

#[test]
fn each_finds_a_locked_wheel() {
    let pushes = World::of(locked()).pushes(8, 1);
    for loss in [Loss::Gaussian, Loss::STUDENT] {
        for cut in [STEPS, Cut::Steps { stride: 1 }, WINDOWS] {
            let fit = found(&shooting(&pushes, cut).with_loss(loss), &nominal());
            assert_locked(&fit, &format!("{cut:?} {loss:?}"));
        }
        assert_locked(&final_states(&pushes, loss), &format!("final {loss:?}"));
    }
}

#[test]
fn the_scatter_of_steps_is_the_trackers_noise() {
    let fit = found(&shooting(&World::of(locked()).pushes(4, 2), STEPS), &nominal());
    for (name, truth) in [("noise.position", NOISE.pose[0]), ("noise.heading", NOISE.pose[2])] {
        let ratio = value(&fit, name) / truth;
        assert!((0.9..1.1).contains(&ratio), "{name}: {ratio} times what the tracker adds");
    }
}

#[test]
fn noisy_transitions_recover_the_model() {
    let sd = [0.01, 0.01, 0.01, 0.02, 0.02, 0.02];
    let data = noisy(&transitions(&locked(), 50, 3, &Pushes::default()).unwrap(), &sd, 4);
    let fit = found(&Shooting::of_transitions(&data).unwrap(), &nominal());
    for (estimate, truth) in
        fit.estimates.iter().zip([22.0, -0.5, -0.3, 0.2, 15.0, 180.0, 0.01, 0.01, 0.02, 0.02])
    {
        assert!((estimate.mean - truth).abs() < 4.0 * estimate.sd, "{estimate:?}");
    }
    assert!((value(&fit, "viscous_wheel.x") + 0.5).abs() < 0.03);
}

#[test]
fn without_dry_friction_final_states_predict_the_ends_better_than_steps() {
    // The paper's finding (figure 5 b, d), on the pushes that were fitted.
    let dry = effect(Kind::CoulombFriction, &[("x", 0.45), ("y", 0.31), ("force", 8.0)]);
    for seed in 1..4 {
        let pushes = World::of(locked().with(dry.clone())).pushes(8, seed);
        let missed = |fit: &Fit| -> f64 {
            let plant = fit.model.resolved().unwrap();
            let one = |episode: &Prepared| {
                let (last, seen) =
                    (open_loop(&plant, episode).pop().unwrap(), episode.pose.last().unwrap().pose);
                (last[0] - seen[0]).hypot(last[1] - seen[1])
            };
            pushes.iter().map(one).sum::<f64>() / pushes.len() as f64
        };
        let steps = missed(&found(&shooting(&pushes, STEPS), &nominal()));
        let ends = missed(&final_states(&pushes, Loss::Gaussian));
        assert!(ends < 0.8 * steps, "{seed}: {ends} m by eq. 9, {steps} m by eq. 8");
    }
}

#[test]
fn episodes_may_differ_in_length_and_rate() {
    let mut pushes = World::of(locked()).pushes(4, 3);
    let thin = |k: usize, every: usize| k.is_multiple_of(every);
    let mut k = 0;
    pushes[1].pose.retain(|_| (k += 1, thin(k, 3)).1);
    k = 0;
    pushes[2].wrench.retain(|_| (k += 1, thin(k, 4)).1);
    pushes[3].pose.truncate(150);
    for cut in [STEPS, WINDOWS] {
        assert_locked(&found(&shooting(&pushes, cut), &nominal()), &format!("{cut:?}"));
    }
}

/// Pushes of the same table, some with a load on it.
fn loaded(masses: &[f64]) -> Vec<Prepared> {
    let one = |(k, &mass): (usize, &f64)| {
        let mut truth = locked();
        truth.mass = Some(mass);
        let mut push = World::of(truth).pushes(1, 20 + k as u64).remove(0);
        push.name = format!("episode_{k:02}");
        push
    };
    masses.iter().enumerate().map(one).collect()
}

#[test]
fn a_mass_per_episode_is_found() {
    let masses = [22.0, 30.0, 22.0, 26.0];
    let likelihood = shooting(&loaded(&masses), WINDOWS);
    let per_episode = BTreeSet::from(["body.mass".to_owned()]);
    let options = FitOptions { per_episode, ..FitOptions::default() };
    let fit = fit(&likelihood, &nominal(), &[], &options, &Quiet).unwrap();
    for (k, mass) in masses.into_iter().enumerate() {
        let found = value(&fit, &format!("body.mass[episode_{k:02}]"));
        assert!((found - mass).abs() < 0.5, "{k}: {found} kg, not {mass} kg");
    }
    assert!((value(&fit, "viscous_wheel.x") + 0.5).abs() < 0.01);
}

#[test]
fn two_recordings_determine_more_than_one() {
    let recordings = [World::of(locked()).pushes(3, 5), World::of(locked()).pushes(3, 6)];
    for cut in [STEPS, WINDOWS] {
        let one = |k: usize| -> Box<dyn Likelihood> { Box::new(shooting(&recordings[k], cut)) };
        let each = [0, 1].map(|k| found(&*one(k), &nominal()));
        let both = found(&Joint::new(vec![one(0), one(1)]).unwrap(), &nominal());
        for k in 0..6 {
            let least = each[0].estimates[k].sd.min(each[1].estimates[k].sd);
            assert!(both.estimates[k].sd < least, "{cut:?} {:?}", both.estimates[k]);
        }
        assert_locked(&both, "both");
    }
}

#[test]
fn outliers_count_less_under_students_t() {
    // Each tenth observation is off by forty standard deviations in every channel.
    let off = |loss: Loss, seed: u64| {
        let mut data = noisy(&transitions(&locked(), 80, seed, &Pushes::default()).unwrap(), &[0.005; 6], 4);
        for (k, transition) in data.iter_mut().enumerate().filter(|(k, _)| k % 10 == 0) {
            transition.after.iter_mut().for_each(|x| *x += if k % 20 == 0 { 0.2 } else { -0.2 });
        }
        let fit = found(&Shooting::of_transitions(&data).unwrap().with_loss(loss), &nominal());
        (value(&fit, "viscous_wheel.x") + 0.5).hypot(value(&fit, "viscous_wheel.y") + 0.3)
    };
    let [normal, student] =
        [Loss::Gaussian, Loss::STUDENT].map(|loss| (0..4).map(|seed| off(loss, seed)).sum::<f64>());
    assert!(student < 0.5 * normal, "{student} m by t, {normal} m by the normal");
}

#[test]
fn same_bytes_on_one_thread_or_two() {
    let pushes = World::of(locked()).pushes(3, 5);
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let values = [22.0, -0.5, -0.3, 0.2, 15.0, 180.0, 1e-3, 2e-3, 4e-3, 5e-3];
        let likelihood = shooting(&pushes, Cut::Steps { stride: 1 });
        let at = pool.install(|| likelihood.linearise(&nominal(), &values, &[0, 1, 2, 3, 4, 5, 6]).unwrap());
        (at.cost, at.gradient, at.curvature)
    };
    assert_eq!(run(1), run(2));
}

#[test]
fn an_object_at_rest_identifies_nothing() {
    let mut pushes = World::of(locked()).pushes(2, 2);
    for push in &mut pushes {
        push.wrench.iter_mut().for_each(|w| w.reading = [0.0; 3]);
        let rest = push.pose[0].pose;
        push.pose.iter_mut().for_each(|p| p.pose = rest);
    }
    for cut in [STEPS, Cut::Final, WINDOWS] {
        let fit = found(&shooting(&pushes, cut), &nominal());
        for estimate in fit.estimates.iter().filter(|e| !e.name.starts_with("noise")) {
            assert!(!estimate.identified, "{cut:?} {estimate:?}");
        }
    }
}

#[test]
fn too_little_data_is_an_error_that_names_the_episode() {
    for cut in [STEPS, Cut::Final, WINDOWS] {
        let refused = |change: fn(&mut Prepared)| {
            let mut pushes = World::of(locked()).pushes(1, 1);
            change(&mut pushes[0]);
            Shooting::new(&pushes, &NOISE, [true; 3], cut).err().unwrap().to_string()
        };
        let message = refused(|p| p.pose.truncate(1));
        assert!(message.contains("episode_00") && message.contains("pose"), "{cut:?}: {message}");
        let message = refused(|p| p.wrench.clear());
        assert!(message.contains("episode_00") && message.contains("wrench"), "{cut:?}: {message}");
        let message = Shooting::new(&[], &NOISE, [true; 3], cut).err().unwrap().to_string();
        assert!(message.contains("no episode"), "{message}");
    }
}
