//! Streams and metadata of recordings after reading.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test ends there")]

use crate::sample::{CSV, TILTING, TOML};
use trundle_model::Fixture;
use trundle_record::{Contact, Dof, Episode, Gripper, Metadata, Recording, Reference, Source};

fn first(toml: &str, csv: &str) -> Episode {
    let home = tempfile::tempdir().unwrap();
    crate::sample::folder(home.path(), toml, csv);
    Recording::read(home.path()).unwrap().episodes.remove(0)
}

/// The sample's metadata with `line` appended to `[object]`.
fn with_object(line: &str) -> Metadata {
    Metadata::from_toml(&TOML.replace("[wrench]", &format!("{line}\n[wrench]"))).unwrap()
}

#[test]
fn rows_without_a_sample_are_left_out() {
    let object = first(TOML, CSV).object().unwrap();
    assert_eq!(object.t, [0.0, 0.2, 0.3]);
    assert_eq!(object.row, [0, 2, 3]);
    assert_eq!(object.value[2], [1e-3, 0.0, 0.0]);
    assert_eq!(first(TOML, CSV).wrench().unwrap().row, [0, 1, 2, 3]);
}

#[test]
fn axes_that_are_not_measured_are_zero_and_not_present() {
    let wrench = first(TOML, CSV).wrench().unwrap();
    assert_eq!(wrench.present, [true, true, false, false, false, true]);
    assert_eq!(wrench.value[3], [5.1, 0.2, 0.0, 0.0, 0.0, 0.3]);
}

#[test]
fn grippers_are_level_or_tilting() {
    let Some(Gripper::Level(level)) = first(TOML, CSV).gripper() else { panic!("not level") };
    assert_eq!(level.value[2], [-0.599, 0.0, 0.0]);
    let Some(Gripper::Tilting(tilting)) = first(TOML, TILTING).gripper() else { panic!("not tilting") };
    assert_eq!(tilting.value[1], [-0.6, 0.0, 0.8, 0.6, 0.0, 0.8, 0.0]);
}

#[test]
fn missing_columns_are_zero_on_a_rail() {
    let rail = TOML.replace("[wrench]", "dof = [\"x\"]\n[wrench]").replace("raw = true", "raw = false");
    let episode = first(&rail, "t,object_x,force_x\n0,1,2\n1,,3\n2,3,4\n");
    assert_eq!(episode.object().unwrap().value, [[1.0, 0.0, 0.0], [3.0, 0.0, 0.0]]);
    assert_eq!(episode.wrench().unwrap().value[1], [3.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    assert_eq!(episode.gripper(), None);
}

#[test]
fn at_rest_is_accepted_at_all_positions() {
    assert!(with_object("").at_rest, "left out");
    let fixture = "[[object.fixture]]\ndisc = [0, 0, 1]\ndensity = 1.0\n";
    for line in
        ["at_rest = false", &format!("{fixture}\nat_rest = false"), &format!("at_rest = false\n{fixture}")]
    {
        assert!(!with_object(line).at_rest, "{line}");
    }
    assert!(!Metadata::from_toml(&format!("at_rest = false\n{TOML}")).unwrap().at_rest);
}

#[test]
fn the_shape_is_the_footprint_or_the_fixtures() {
    let polygon = vec![[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]];
    let footprint = vec![Fixture::Polygon { vertices: polygon, density: 1.0 }];
    assert_eq!(with_object("").object.shape(), footprint);
    let disc = vec![Fixture::Disc { center: [1.0, 2.0], radius: 0.5, density: 3.0 }];
    let both = with_object("[[object.fixture]]\ndisc = [1, 2, 0.5]\ndensity = 3");
    assert_eq!(both.object.shape(), disc);
}

#[test]
fn optional_keys_have_defaults() {
    let minimal = "format = \"trundle-recording/1\"\nname = \"a\"\n[object]\n[wrench]\nframe = \"world\"\nsign = \"on_object\"\n";
    let metadata = Metadata::from_toml(minimal).unwrap();
    assert_eq!(metadata.object.dof, [Dof::X, Dof::Y, Dof::Theta]);
    assert!(!metadata.wrench.raw && metadata.noise.is_none() && !metadata.is_held_out("a"));
    assert_eq!((metadata.wrench.contact, metadata.wrench.source), (Contact::Grasp, Source::Measured));
    assert_eq!(metadata.wrench.reference(), Reference::Object);
}

#[test]
fn a_point_contact_without_torque_refers_to_the_sensor() {
    let mut wrench = with_object("").wrench;
    wrench.reference = Some(Reference::Object);
    wrench.contact = Contact::Point;
    assert_eq!(wrench.reference_for([true, true, false, false, false, false]), Reference::Sensor);
    assert_eq!(wrench.reference_for([true; 6]), Reference::Object);
}

#[test]
fn intervals_are_common_or_by_episode() {
    let everywhere = with_object("");
    assert_eq!(everywhere.wrench.precontact("any"), Some([0.0, 0.2]));
    let table = TOML.replace("[0.0, 0.2]", "{a = [1, 2]}");
    let by_name = Metadata::from_toml(&table).unwrap().wrench;
    assert_eq!((by_name.precontact("a"), by_name.precontact("b")), (Some([1.0, 2.0]), None));
}

#[test]
fn other_and_hidden_files_are_ignored() {
    let home = tempfile::tempdir().unwrap();
    crate::sample::folder(home.path(), TOML, CSV);
    for name in ["README.md", ".hidden.csv", "._episode_00.csv", "plot.png"] {
        std::fs::write(home.path().join(name), "anything").unwrap();
    }
    std::fs::write(home.path().join("B.CSV"), format!("\u{feff}{}", CSV.replace('\n', "\r\n"))).unwrap();
    let names: Vec<String> =
        Recording::read(home.path()).unwrap().episodes.into_iter().map(|e| e.name).collect();
    assert_eq!(names, ["B", "episode_00"]);
}

#[test]
fn byte_order_marks_and_carriage_returns_are_accepted() {
    let text = format!("\u{feff}{}", TOML.replace('\n', "\r\n"));
    assert_eq!(Metadata::from_toml(&text).unwrap(), Metadata::from_toml(TOML).unwrap());
}
