//! A table's parameters come back from its pushes.

mod common;

use common::{NOISE, locked, pushes, table};
use trundle_infer::{FitOptions, MotionLikelihood, Quiet, fit};
use trundle_model::{Effect, Kind, Model};

#[test]
fn a_locked_wheel_is_found_with_honest_intervals() {
    let episodes = pushes(&locked(), 8, 1);
    let likelihood = MotionLikelihood::new(&episodes, &NOISE).unwrap();
    let model = Model::nominal(table(), None, [true; 3]);
    let t = std::time::Instant::now();
    let found = fit(&likelihood, &model, &[], &FitOptions::default(), &Quiet).unwrap();
    println!(
        "{:?} cost {} evidence {} conv {} agree {:?}",
        t.elapsed(),
        found.cost,
        found.log_evidence,
        found.converged,
        found.agreement
    );
    let truth = [22.0, -0.5, -0.3, 0.2, 15.0, 180.0];
    for (estimate, truth) in found.estimates.iter().zip(truth) {
        println!("{estimate:?} truth {truth} off {:.2} sd", (estimate.mean - truth) / estimate.sd);
    }
    let with = model.with(Effect::free(Kind::CoulombFriction));
    let t = std::time::Instant::now();
    let more = fit(&likelihood, &with, &[], &FitOptions::default(), &Quiet).unwrap();
    println!("{:?} cost {} evidence {}", t.elapsed(), more.cost, more.log_evidence);
    for e in &more.estimates {
        println!("{e:?}");
    }
}
