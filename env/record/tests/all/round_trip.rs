//! Writing and reading recordings: round trips, and atomic replacement of the folder.

#![allow(clippy::unwrap_used, reason = "a test ends there")]

use std::fs;

use crate::sample::{episode, metadata, recording};
use proptest::prelude::*;
use trundle_record::{Episode, Metadata, Recording, Table};

/// Any finite number, or an empty cell.
fn cell() -> impl Strategy<Value = f64> {
    prop_oneof![
        8 => prop::num::f64::NORMAL | prop::num::f64::SUBNORMAL | prop::num::f64::ZERO,
        1 => -10.0..10.0_f64,
        3 => Just(f64::NAN),
    ]
}

/// An episode with increasing times, complete object and wrench streams, a gripper stream with missing samples, and notes.
fn any_episode() -> impl Strategy<Value = Episode> {
    let row = (1e-6..1.0_f64, cell(), any::<bool>(), "[^\\x00]{0,12}");
    prop::collection::vec(row, 2..40).prop_map(|rows| {
        let mut t = 0.0;
        let mut episode = Episode { name: "episode_00".to_owned(), ..Episode::default() };
        for (step, value, gripped, note) in rows {
            t += step;
            let value = if value.is_nan() { 0.5 } else { value };
            episode.t.push(t);
            let mut push =
                |name: &str, cell: f64| episode.columns.entry(name.to_owned()).or_default().push(cell);
            for name in ["object_x", "object_y", "object_theta", "force_x", "force_y", "torque_z"] {
                push(name, value);
            }
            for name in ["gripper_x", "gripper_y", "gripper_theta"] {
                push(name, if gripped || episode.t.len() == 1 { -value } else { f64::NAN });
            }
            episode.notes.entry("note_remark".to_owned()).or_default().push(note);
        }
        episode
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn recordings_survive_a_round_trip(first in any_episode(), mut second in any_episode()) {
        second.name = "episode_01".to_owned();
        let recording = Recording::new(metadata(""), vec![second, first]).unwrap();
        let home = tempfile::tempdir().unwrap();
        for table in Table::ALL {
            let path = home.path().join(table.extension());
            recording.write(&path, table).unwrap();
            prop_assert_eq!(&Recording::read(&path).unwrap(), &recording);
        }
    }

    #[test]
    fn metadata_survive_a_round_trip(values in prop::collection::vec(1e-9..1e9_f64, 8), at_rest: bool) {
        let mut before = metadata("[notes]\nwhen = 2026-11-21T05:00:00Z\nwho = \"a\"\n");
        prop_assert!(before.notes["when"].is_datetime());
        before.object.mass = Some(values[0]);
        before.object.support = vec![[values[1], -values[2]]];
        before.at_rest = at_rest;
        before.wrench.gripper_mass = Some(values[3]);
        before.wrench.gripper_com = Some([values[4], values[5], -values[6]]);
        prop_assert_eq!(&Metadata::from_toml(&before.to_toml().unwrap()).unwrap(), &before);
        prop_assert_eq!(&Metadata::from_table(before.to_table().unwrap()).unwrap(), &before);
    }
}

#[test]
fn the_same_recording_gives_the_same_bytes() {
    let home = tempfile::tempdir().unwrap();
    for table in Table::ALL {
        let bytes = ["a", "b"].map(|name| {
            let path = home.path().join(name);
            recording().write(&path, table).unwrap();
            let file = path.join(format!("episode_00.{}", table.extension()));
            (fs::read(path.join("recording.toml")).unwrap(), fs::read(file).unwrap())
        });
        assert_eq!(bytes[0], bytes[1]);
    }
}

#[test]
fn an_earlier_recording_is_replaced_completely() {
    let home = tempfile::tempdir().unwrap();
    let path = home.path().join("run");
    let two = Recording::new(metadata(""), vec![episode("a"), episode("b")]).unwrap();
    two.write(&path, Table::Csv).unwrap();
    recording().write(&path, Table::Parquet).unwrap();
    assert_eq!(Recording::read(&path).unwrap(), recording());
    let left: Vec<_> = fs::read_dir(home.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert_eq!(left, ["run"], "no temporary files are left");
}

#[test]
fn other_folders_and_files_are_not_replaced() {
    let home = tempfile::tempdir().unwrap();
    let cases = [("thesis.tex", "is not a recording"), ("recording.toml", "contains \"thesis.tex\"")];
    let path = home.path().join("work");
    fs::create_dir(&path).unwrap();
    for (file, expected) in cases {
        fs::write(path.join(file), "precious").unwrap();
        let error = recording().write(&path, Table::Csv).unwrap_err().to_string();
        assert!(error.contains(expected) && error.contains("choose another path"), "{error}");
        assert_eq!(fs::read_to_string(path.join(file)).unwrap(), "precious");
    }
    let file = path.join("thesis.tex");
    let error = recording().write(&file, Table::Csv).unwrap_err().to_string();
    assert!(error.contains("is not a folder"), "{error}");
}

#[test]
fn an_invalid_recording_is_not_written() {
    let home = tempfile::tempdir().unwrap();
    let mut wrong = recording();
    wrong.episodes[0].t[1] = wrong.episodes[0].t[0];
    let path = home.path().join("run");
    let error = wrong.write(&path, Table::Csv).unwrap_err().to_string();
    assert!(error.starts_with("episode episode_00, row 2, column t: "), "{error}");
    assert!(!path.exists());
}
