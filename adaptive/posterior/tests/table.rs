//! Posteriors of a pushed table.
#![allow(clippy::unwrap_used, clippy::expect_used)]

use trundle_fixtures::{NOISE, World, locked, table};
use trundle_infer::{Likelihood, MotionLikelihood, Quiet, Watch};
use trundle_model::Model;
use trundle_posterior::{Method, Posterior, PosteriorError, SampleOptions, predictive, sample};

fn short(method: Method) -> SampleOptions {
    SampleOptions { method, chains: 2, draws: 150, warmup: 80, ..SampleOptions::default() }
}

fn likelihood() -> MotionLikelihood {
    MotionLikelihood::new(&World::of(locked()).pushes(1, 1), &NOISE).unwrap()
}

fn posterior(options: &SampleOptions) -> Posterior {
    let model = Model::nominal(table(), None, [true; 3]);
    sample(&likelihood(), &model, options, &Quiet).unwrap()
}

/// Mean and standard deviation of a parameter.
fn moments(posterior: &Posterior, k: usize) -> (f64, f64) {
    let all: Vec<f64> = posterior.draws.iter().flatten().map(|d| d[k]).collect();
    let mean = all.iter().sum::<f64>() / all.len() as f64;
    (mean, (all.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / all.len() as f64).sqrt())
}

#[test]
fn nuts_agrees_with_laplace_where_all_parameters_are_identified() {
    let (nuts, laplace) = (posterior(&short(Method::Nuts)), posterior(&short(Method::Laplace)));
    for (k, slot) in nuts.slots.iter().enumerate() {
        let ((mean, sd), (at, spread)) = (moments(&nuts, k), moments(&laplace, k));
        assert!((mean - at).abs() < 0.5 * spread, "{}: mean {mean} {at} ± {spread}", slot.name);
        assert!((0.7..1.4).contains(&(sd / spread)), "{}: sd {sd} {spread}", slot.name);
    }
    assert!(nuts.identified.iter().all(|i| *i));
    assert_eq!(nuts.chains.iter().flat_map(|c| &c.diverging).filter(|d| **d).count(), 0);
    // The gradient neglects the dependence of the filter's gains. Its accuracy shows in step sizes of order
    // one.
    assert!(nuts.chains.iter().all(|c| c.step_size > 0.3));
}

#[test]
fn same_seed_same_bytes_on_one_thread_or_two() {
    for method in [Method::Nuts, Method::Metropolis] {
        let run = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let options = SampleOptions { draws: 20, warmup: 50, ..short(method) };
            pool.install(|| posterior(&options).draws)
        };
        assert_eq!(run(1), run(2));
    }
}

#[test]
fn predictions_cover_the_recorded_poses() {
    let found = posterior(&short(Method::Laplace));
    let episode = &World::of(locked()).pushes(1, 1)[0];
    let values: Vec<_> = found.values.iter().flatten().take(40).cloned().collect();
    let drawn = predictive(&found.model, &values, &found.channels, episode, (0, 0)).unwrap();
    let (last, seen) = (episode.pose.len() - 1, episode.pose.last().unwrap().pose);
    for k in 0..3 {
        let ends: Vec<f64> = drawn.iter().map(|d| d[last][k]).collect();
        let mean = ends.iter().sum::<f64>() / 40.0;
        let sd = (ends.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / 40.0).sqrt();
        assert!((seen[k] - mean).abs() < 4.0 * sd, "axis {k}: {} ± {sd} from {}", mean, seen[k]);
        assert!(sd > NOISE.pose[k], "axis {k}: the wrench's noise adds to the tracker's, {sd}");
    }
}

#[test]
fn log_likelihoods_of_the_episodes_add_up_to_that_of_all() {
    let likelihood = MotionLikelihood::new(&World::of(locked()).pushes(3, 1), &NOISE).unwrap();
    let model = Model::nominal(table(), None, [true; 3]);
    let options = SampleOptions { draws: 4, ..short(Method::Laplace) };
    let found = sample(&likelihood, &model, &options, &Quiet).unwrap();
    let pointwise = found.log_likelihood(&likelihood).unwrap();
    assert_eq!(pointwise.episodes.len(), 3);
    let draws = found.values.iter().flatten().zip(pointwise.chains.iter().flatten());
    for (values, by_episode) in draws {
        let whole = -likelihood.cost(&model, values).unwrap();
        let sum: f64 = by_episode.iter().sum();
        assert!((sum - whole).abs() < 1e-9 * whole.abs(), "{sum} {whole}");
        assert!(by_episode.iter().all(|one| (one - whole / 3.0).abs() < 0.5 * whole.abs()));
    }
}

#[test]
fn a_per_episode_parameter_has_its_own_value_in_the_log_likelihood_of_each_episode() {
    let likelihood = MotionLikelihood::new(&World::of(locked()).pushes(2, 1), &NOISE).unwrap();
    let model = Model::nominal(table(), None, [true; 3]);
    let mut options = SampleOptions { draws: 4, ..short(Method::Laplace) };
    options.fit.per_episode.insert("body.mass".to_owned());
    let found = sample(&likelihood, &model, &options, &Quiet).unwrap();
    let pointwise = found.log_likelihood(&likelihood).unwrap();
    // `values` holds the mass of the first episode.
    let (first, second) = (likelihood.only(|k| k == 0), likelihood.only(|k| k == 1));
    let (values, by_episode) = (&found.values[0][0], &pointwise.chains[0][0]);
    let at_first_mass = [first, second].map(|one| -one.cost(&model, values).unwrap());
    assert!((by_episode[0] - at_first_mass[0]).abs() < 1e-9 * by_episode[0].abs());
    assert!((by_episode[1] - at_first_mass[1]).abs() > 1e-6);
}

#[test]
fn an_invalid_setting_is_an_error_that_names_it() {
    let refused = |options: SampleOptions, model: &Model| {
        sample(&likelihood(), model, &options, &Quiet).unwrap_err().to_string()
    };
    let free = Model::nominal(table(), None, [true; 3]);
    let no_chains = SampleOptions { chains: 0, ..short(Method::Nuts) };
    assert!(refused(no_chains, &free).contains("chains = 0"));
    let no_warmup = SampleOptions { warmup: 3, ..short(Method::Nuts) };
    assert!(refused(no_warmup, &free).contains("warmup = 3"));
    assert!(refused(short(Method::Nuts), &locked()).contains("no parameter of the model is free"));
}

#[test]
fn sampling_stops_when_asked() {
    struct Impatient;
    impl Watch for Impatient {
        fn progress(&self, _: &str, _: f64) {}
        fn cancelled(&self) -> bool {
            true
        }
    }
    let model = Model::nominal(table(), None, [true; 3]);
    let stopped = sample(&likelihood(), &model, &short(Method::Nuts), &Impatient);
    assert!(stopped.is_err_and(|e: PosteriorError| e.is_interrupt()));
}
