use super::*;
use crate::{Body, Effect, Kind, Model};

fn model() -> Model {
    let body = Body::from_footprint(&[[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]], 22.0).unwrap();
    Model::nominal(body, None, [true; 3]).with(Effect::free(Kind::CoulombFriction))
}

fn applied(text: &str) -> Result<Model, crate::ModelError> {
    PriorFile::from_toml(text, "my.toml")?.apply(&model())
}

fn slot(model: &Model, name: &str) -> crate::Slot {
    model.slots().into_iter().find(|s| s.name == name).unwrap()
}

#[test]
fn every_distribution_sets_the_prior_of_its_slot() {
    let text = r#"
format = "trundle-prior/1"
[body]
mass = { distribution = "log_normal", median = 20, sd = 0.5 }
[viscous_wheel]
x = { distribution = "uniform", low = -0.6, high = 0.0 }
y = { distribution = "on_body" }
angle = { distribution = "angle" }
mu_x = { distribution = "normal", mean = 15, sd = 10, high = 40, scope = "episode" }
mu_y = { distribution = "fixed", value = 180 }
[coulomb_friction]
force = { scope = "episode" }
"#;
    let model = applied(text).unwrap();
    let mass = slot(&model, "body.mass");
    assert_eq!((mass.prior, mass.upper), (Prior::LogNormal { median: 20.0, sd: 0.5 }, 1e5));
    let x = slot(&model, "viscous_wheel.x");
    assert_eq!((x.prior, x.lower, x.upper), (Prior::Uniform, -0.6, 0.0));
    assert_eq!(slot(&model, "viscous_wheel.y").prior, Prior::OnBody(1));
    let mu = slot(&model, "viscous_wheel.mu_x");
    assert_eq!((mu.prior, mu.lower, mu.upper), (Prior::Normal { mean: 15.0, sd: 10.0 }, 0.0, 40.0));
    assert_eq!(slot(&model, "viscous_wheel.mu_y").value, Some(180.0));
    let per_episode = PriorFile::from_toml(text, "my.toml").unwrap().per_episode();
    assert_eq!(per_episode.into_iter().collect::<Vec<_>>(), ["coulomb_friction.force", "viscous_wheel.mu_x"]);
}

#[test]
fn a_fixed_mass_sets_the_mass_of_the_body() {
    let model = applied("[body]\nmass = { distribution = \"fixed\", value = 30 }").unwrap();
    assert_eq!((model.mass, model.body.mass), (Some(30.0), 30.0));
}

#[test]
fn a_prior_frees_a_refinement() {
    let name = "coulomb_friction.static_force";
    assert!(slot(&model(), name).value.is_some());
    let text = "[coulomb_friction]\nstatic_force = { distribution = \"log_normal\", median = 2, sd = 1 }";
    assert_eq!(slot(&applied(text).unwrap(), name).value, None);
}

#[test]
fn errors_name_value_and_remedy() {
    for (text, words) in [
        ("[body]\nmas = { distribution = \"angle\" }", vec!["body.mas", "did you mean `body.mass`"]),
        ("[wheel]\nx = { distribution = \"on_body\" }", vec!["wheel.x", "no such", "coulomb_friction.force"]),
        (
            "[body]\nmass = { distribution = \"lognormal\" }",
            vec!["body.mass", "lognormal", "did you mean `log_normal`"],
        ),
        ("[body]\nmass = { distribution = \"normal\", mean = 3 }", vec!["body.mass", "sd", "needs"]),
        (
            "[body]\nmass = { distribution = \"normal\", mean = 3, sd = 0 }",
            vec!["sd = 0", "positive", "fixed"],
        ),
        ("[body]\nmass = { distribution = \"normal\", mean = 3, sd = nan }", vec!["sd = nan", "finite"]),
        ("[body]\nmass = { distribution = \"normal\", mean = 3, sd = \"x\" }", vec!["sd = \"x\"", "number"]),
        (
            "[body]\nmass = { distribution = \"normal\", mean = 3, sd = 1, hig = 2 }",
            vec!["`hig`", "did you mean `high`"],
        ),
        (
            "[body]\nmass = { distribution = \"normal\", mean = -3, sd = 1 }",
            vec!["mean = -3", "[0.001, 100000] kg"],
        ),
        (
            "[body]\nmass = { distribution = \"uniform\", low = -1, high = 2 }",
            vec!["low = -1", "[0.001, 100000] kg"],
        ),
        (
            "[body]\nmass = { distribution = \"uniform\", low = 2, high = 2 }",
            vec!["low = 2", "less than high"],
        ),
        (
            "[body]\nmass = { distribution = \"log_normal\", median = 0, sd = 1 }",
            vec!["median = 0", "positive"],
        ),
        (
            "[body]\nmass = { distribution = \"log_normal\", median = 1, sd = 0.1, low = 50 }",
            vec!["median = 1", "standard dev"],
        ),
        ("[body]\nmass = { distribution = \"fixed\", value = 0 }", vec!["value = 0", "kg"]),
        (
            "[body]\nmass = { distribution = \"fixed\", value = 3, scope = \"episode\" }",
            vec!["scope", "fixed"],
        ),
        ("[body]\nmass = { distribution = \"on_body\" }", vec!["not a position", "kg"]),
        ("[body]\nmass = { distribution = \"angle\" }", vec!["not an angle", "kg"]),
        ("[body]\nmass = { scope = \"push\" }", vec!["scope = \"push\"", "episode"]),
        ("[body]\nmass = {}", vec!["distribution", "log_normal"]),
        ("[body]\nmass = 20", vec!["body.mass", "is 20", "fixed"]),
        ("body = 20", vec!["body", "not a table"]),
        ("format = \"trundle-prior/2\"", vec!["trundle-prior/2", "trundle-prior/1"]),
        ("[body", vec!["TOML", "line 1"]),
        (
            "[viscous_wheel]\nx = { distribution = \"uniform\", low = -0.7, high = 0 }",
            vec!["low = -0.7", "[-0.6, 0.6] m"],
        ),
        (
            "[viscous_wheel]\nangle = { distribution = \"uniform\", low = 0, high = 4 }",
            vec!["3.14159 rad", "angle"],
        ),
    ] {
        let message = applied(text).unwrap_err().to_string();
        assert!(message.starts_with("my.toml: "), "{message}");
        for word in words {
            assert!(message.contains(word), "{message} should contain {word}");
        }
    }
}

#[test]
fn a_given_value_rejects_a_prior() {
    let given = Model { mass: Some(22.0), ..model() };
    let file = PriorFile::from_toml("[body]\nmass = { distribution = \"uniform\", low = 1, high = 2 }", "p");
    let message = file.unwrap().apply(&given).unwrap_err().to_string();
    assert!(message.contains("p: body.mass: is given as 22 kg: remove the prior"), "{message}");
}
