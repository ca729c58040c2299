//! Object files: all files in `configs/objects` are valid and state the sources of their values.

#![allow(clippy::unwrap_used)]

use std::path::{Path, PathBuf};

use trundle_model::{Fixture, Kind, Model};
use trundle_sim::{Object, Scenario};

fn configs() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../configs")
}

fn objects() -> Vec<(String, Object)> {
    let entries = std::fs::read_dir(configs().join("objects")).unwrap();
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    paths.iter().map(|path| (path.display().to_string(), Object::read(path).unwrap())).collect()
}

/// Whether a wheel constrains the motion: its friction is anisotropic, or it is off the origin.
fn constrained(model: &Model) -> bool {
    model.effects.iter().any(|effect| {
        let [x, y, _, mu_x, mu_y] =
            [0, 1, 2, 3, 4].map(|k| effect.values.get(k).copied().flatten().unwrap_or(0.0));
        effect.kind == Kind::ViscousWheel && (mu_x != mu_y || [x, y] != [0.0; 2])
    })
}

#[test]
fn five_of_ten_objects_have_a_constraining_wheel() {
    let objects = objects();
    assert_eq!(objects.len(), 10);
    let constrained_objects = objects.iter().filter(|(_, object)| {
        object.configurations.iter().any(|name| constrained(&object.model(Some(name)).unwrap()))
    });
    assert_eq!(constrained_objects.count(), 5);
}

#[test]
fn every_value_has_a_source() {
    for (path, object) in objects() {
        let values = object.value_names();
        assert!(values.len() >= 4 && object.radius.is_some(), "{path}: {values:?}");
        for value in values {
            assert!(object.source(&value).is_some_and(|text| text.len() > 20), "{path}: {value}");
        }
    }
}

#[test]
fn configurations_are_complete_and_unconstrained_objects_have_their_mass_centre_at_the_origin() {
    for (path, object) in objects() {
        for name in &object.configurations {
            let model = object.model(Some(name)).unwrap();
            assert!(model.resolved().is_ok(), "{path}: {name}");
            if !constrained(&model) {
                assert!(model.body.com.iter().all(|c| c.abs() < 1e-6), "{path}: {:?}", model.body.com);
            }
        }
    }
}

/// Corners of the outline (the first fixture), m.
fn corners(model: &Model) -> Vec<[f64; 2]> {
    match &model.body.fixtures[0] {
        Fixture::Polygon { vertices, .. } => vertices.clone(),
        Fixture::Disc { .. } => vec![],
    }
}

#[test]
fn the_radius_is_that_of_a_circle_in_the_footprint() {
    for (path, object) in objects() {
        let model = object.model(None).unwrap();
        let [cx, cy] = model.body.com;
        let (mut width, mut depth) = (f64::INFINITY, f64::INFINITY);
        let [low, high] = model.body.bounds();
        width = width.min(cx - low[0]).min(high[0] - cx);
        depth = depth.min(cy - low[1]).min(high[1] - cy);
        let (radius, box_radius) = (object.radius.unwrap(), width.min(depth));
        assert!(radius <= box_radius && radius > 0.85 * box_radius, "{path}: {radius} in {box_radius}");
        assert!(corners(&model).iter().all(|[x, y]| (x - cx).hypot(y - cy) > radius), "{path}");
    }
}

fn with(change: impl Fn(&str) -> String) -> Result<Object, String> {
    let text = std::fs::read_to_string(configs().join("objects/bed.toml")).unwrap();
    let changed = change(&text);
    assert_ne!(text, changed);
    let folder = scratch();
    let path = folder.join("bed.toml");
    std::fs::write(&path, changed).unwrap();
    let read = Object::read(&path).map_err(|error| error.to_string());
    std::fs::remove_dir_all(folder).unwrap();
    read
}

fn scratch() -> PathBuf {
    use std::sync::atomic::{AtomicUsize, Ordering};
    static COUNT: AtomicUsize = AtomicUsize::new(0);
    let number = COUNT.fetch_add(1, Ordering::Relaxed);
    let folder = std::env::temp_dir().join(format!("trundle-object-{}-{number}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

#[test]
fn errors_of_object_files_name_the_cause() {
    for (from, to, words) in [
        ("radius = 0.48", "radios = 0.48", "radios"),
        ("radius = 0.48", "radius = -0.48", "radius = -0.48"),
        ("mass = 136.0", "mess = 136.0", "mess"),
        ("\"body.mass\" =", "\"body.mess\" =", "body.mess"),
        ("all castors free", "steering castor", "must differ"),
        ("mu_x = 170.8", "mu_z = 170.8", "mu_z"),
        ("trundle-object/1", "trundle-object/9", "trundle-object/9"),
    ] {
        let message = with(|text| text.replace(from, to)).unwrap_err();
        assert!(message.contains("bed.toml") && message.contains(words), "{message} should say {words}");
    }
    let object = with(|text| text.replace("\"body.mass\" =", "# \"body.mass\" =")).unwrap();
    assert_eq!(object.source("body.mass"), None);
    let message = object.model(Some("on skates")).unwrap_err().to_string();
    assert!(message.contains("on skates") && message.contains("[[configuration]]"), "{message}");
}

#[test]
fn a_scenario_combines_the_effects_of_a_configuration_with_its_own() {
    let demo = std::fs::read_to_string(configs().join("experiments/demo.toml")).unwrap();
    let folder = scratch();
    let path = folder.join("scenario.toml");
    let table = configs().join("objects/office_table.toml");
    let read = |configuration: &str| {
        let text = demo.replace("../objects/office_table.toml", &table.display().to_string());
        std::fs::write(&path, text.replace("held_out = 2", &format!("held_out = 2\n{configuration}")))
            .unwrap();
        Scenario::read(&path).map(|(_, model)| model.effects.len()).map_err(|error| error.to_string())
    };
    assert_eq!(read(""), Ok(2));
    assert_eq!(read("configuration = \"locked\""), Ok(3));
    assert!(read("configuration = \"open\"").unwrap_err().contains("configuration = \"open\""));
    std::fs::remove_dir_all(folder).unwrap();
}
