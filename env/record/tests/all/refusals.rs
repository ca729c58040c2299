//! Messages of all faults. `tests/cases/*.txt` has one case per paragraph:
//!
//! - `case: NAME`.
//! - `table: tilting` starts from the sample with a tilting gripper, `table: joints` from that of joints.
//! - `toml: OLD -> NEW` and `csv: OLD -> NEW` edit the minimal recording. An empty OLD appends NEW.
//! - `message: TEXT` is the expected message, with `RUN` for the folder, or `accepted`.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "an invalid case fails its test")]

use std::fs;

use trundle_record::{JointRecording, Recording};

struct Case<'a> {
    name: &'a str,
    toml: String,
    csv: String,
    joints: bool,
    message: &'a str,
}

fn parse(paragraph: &str) -> Case<'_> {
    let (toml, csv) = (crate::sample::TOML.to_owned(), crate::sample::CSV.to_owned());
    let mut case = Case { name: "", toml, csv, joints: false, message: "" };
    for line in paragraph.lines() {
        let (key, value) = line.split_once(':').unwrap_or_else(|| panic!("{line:?}"));
        match (key, value.trim()) {
            ("case", name) => case.name = name,
            ("table", "tilting") => case.csv = crate::sample::TILTING.to_owned(),
            ("table", "joints") => {
                (case.toml, case.csv) =
                    (crate::sample::JOINTS_TOML.to_owned(), crate::sample::JOINTS_CSV.to_owned());
                case.joints = true;
            }
            ("toml", edit) => case.toml = edited(&case.toml, edit),
            ("csv", edit) => case.csv = edited(&case.csv, edit),
            ("message", message) => case.message = message,
            _ => panic!("unknown key: {line}"),
        }
    }
    case
}

fn edited(text: &str, edit: &str) -> String {
    let (old, new) = edit.split_once("->").expect(edit);
    let [old, new] = [old, new].map(|part| part.trim_matches(' ').replace("\\n", "\n"));
    if old.is_empty() {
        return format!("{text}{new}");
    }
    assert!(text.contains(&old), "{old:?} is not in the sample");
    text.replacen(&old, &new, 1)
}

fn check_cases(cases: &str) {
    let mut wrong = Vec::new();
    for case in cases.trim_end().split("\n\n").map(parse) {
        let home = tempfile::tempdir().unwrap();
        let read = if case.joints {
            crate::sample::joint_folder(home.path(), &case.toml, &case.csv);
            JointRecording::read(home.path()).map(drop)
        } else {
            crate::sample::folder(home.path(), &case.toml, &case.csv);
            Recording::read(home.path()).map(drop)
        };
        let found = match read {
            Ok(()) => "accepted".to_owned(),
            Err(error) => error.to_string().replace(&home.path().display().to_string(), "RUN"),
        };
        if found != case.message {
            wrong.push(format!("case: {}\nmessage: {found}", case.name));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n\n"));
}

#[test]
fn faults_of_metadata() {
    check_cases(include_str!("cases/metadata.txt"));
}

#[test]
fn faults_of_tables() {
    check_cases(include_str!("cases/tables.txt"));
}

#[test]
fn faults_of_tables_and_metadata_together() {
    check_cases(include_str!("cases/together.txt"));
}

#[test]
fn faults_of_joints() {
    check_cases(include_str!("cases/joints.txt"));
}

#[test]
fn accepted_recordings() {
    check_cases(include_str!("cases/accepted.txt"));
}

#[test]
fn text_that_is_not_utf8() {
    let home = tempfile::tempdir().unwrap();
    crate::sample::folder(home.path(), crate::sample::TOML, crate::sample::CSV);
    let table = home.path().join("episode_00.csv");
    let mut bytes = fs::read(&table).unwrap();
    let at = bytes.windows(3).position(|window| window == b"ann").unwrap();
    bytes[at] = 0xe4;
    fs::write(&table, bytes).unwrap();
    let error = Recording::read(home.path()).unwrap_err().to_string();
    assert!(error.ends_with("row 1, column note_who: the text is not UTF-8; save it as UTF-8"), "{error}");
    fs::write(home.path().join("recording.toml"), b"name = \"\xe4\"").unwrap();
    let error = Recording::read(home.path()).unwrap_err().to_string();
    assert!(error.ends_with("recording.toml: the text is not UTF-8; save it as UTF-8"), "{error}");
}

#[test]
fn faults_of_folders() {
    let home = tempfile::tempdir().unwrap();
    let run = home.path().join("run");
    let assert_message = |expected: &str| {
        let error = Recording::read(&run).unwrap_err().to_string();
        assert_eq!(error.replace(&run.display().to_string(), "RUN"), expected);
    };
    let remedy =
        "a recording is a folder with recording.toml and one table per episode (NAME.csv or NAME.parquet)";
    assert_message(&format!("RUN: there is no such folder; {remedy}"));
    fs::write(&run, "").unwrap();
    assert_message(&format!("RUN: this is not a folder; {remedy}"));
    fs::remove_file(&run).unwrap();
    fs::create_dir(&run).unwrap();
    assert_message(&format!("RUN: the folder has no recording.toml; {remedy}"));
    fs::write(run.join("recording.toml"), crate::sample::TOML).unwrap();
    assert_message(
        "RUN/recording.toml: the recording has no episodes, so there is no episode to fit; add a table NAME.csv or NAME.parquet",
    );
    crate::sample::folder(&run, crate::sample::TOML, crate::sample::CSV);
    fs::write(run.join("episode_00.parquet"), "").unwrap();
    assert_message(
        "RUN/episode_00.csv: the folder also contains episode_00.parquet; keep one table per episode",
    );
    fs::remove_file(run.join("episode_00.csv")).unwrap();
    let error = Recording::read(&run).unwrap_err().to_string();
    assert!(error.contains("episode_00.parquet: not a readable Parquet file: "), "{error}");
}
