use super::*;
use crate::{combined, loss_named};
use trundle_fixtures::{World, locked};
use trundle_infer::{Loss, Quiet};

fn request() -> FitRequest<'static> {
    let likelihood = LikelihoodOptions { kind: None, window: 1.0, loss: Loss::Gaussian, obstacles: None };
    let options = FitOptions { starts: 4, ..FitOptions::default() };
    FitRequest { model: None, prior: None, start: None, likelihood, simulator: None, options }
}

fn recording(name: &str) -> Dataset {
    Dataset { name: name.to_owned(), ..World::of(locked()).recording(1) }
}

fn refusal(recordings: &[Dataset], request: &FitRequest<'_>) -> String {
    fit_recordings(recordings, request, &Quiet).unwrap_err().to_string()
}

#[test]
fn a_fit_reports_the_wheel_and_its_test() {
    let report = fit_recordings(&[recording("table")], &request(), &Quiet).unwrap();
    let wheel = report.model.slots().into_iter().find(|s| s.name == "viscous_wheel.x").unwrap();
    assert!((wheel.value.unwrap() + 0.5).abs() < 0.05, "{wheel:?}");
    assert_eq!(report.summary.likelihood, "filter");
    assert!(!report.summary.lack_of_fit.unwrap().found);
    assert!(report.posterior.unwrap().names.contains(&"viscous_wheel.x".to_owned()));
}

#[test]
fn recordings_of_different_objects_are_refused() {
    let (a, mut b) = (recording("a"), recording("b"));
    b.dof = [true, false, false];
    let error = combined(vec![a.clone(), b]).unwrap_err().to_string();
    assert!(error.starts_with("\"a\" and \"b\" show different objects: dof is"), "{error}");
    assert!(matches!(combined(vec![]), Err(EstimateError::NoRecording)));
    let two = combined(vec![a.clone(), a]).unwrap();
    assert!(two[0].training[0].name.starts_with("a#1/") && two[1].training[0].name.starts_with("a#2/"));
}

#[test]
fn starts_must_name_every_free_parameter() {
    let data = [recording("table")];
    let unknown = BTreeMap::from([("wheel.x".to_owned(), 0.0)]);
    let error = refusal(&data, &FitRequest { start: Some(&unknown), ..request() });
    assert!(error.starts_with("start: `wheel.x` is not a free parameter; free are body.mass"), "{error}");
    let partial = BTreeMap::from([("body.mass".to_owned(), 20.0)]);
    let error = refusal(&data, &FitRequest { start: Some(&partial), ..request() });
    assert!(error.starts_with("start: `viscous_wheel.x` is missing"), "{error}");
}

#[test]
fn unsupported_combinations_are_refused() {
    let student = LikelihoodOptions { loss: loss_named("student").unwrap(), ..request().likelihood };
    let error = refusal(&[recording("table")], &FitRequest { likelihood: student, ..request() });
    assert!(error.starts_with("loss = \"student\""), "{error}");
    let error = LikelihoodKind::named("guess").unwrap_err().to_string();
    assert_eq!(error, "likelihood = \"guess\": choose one of filter, steps, final, windows, wrench");
}
