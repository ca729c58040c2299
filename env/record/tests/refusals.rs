//! Everything that a reader refuses, with its message: `tests/cases/*.txt` holds one case a paragraph.
//!
//! A case is a name, edits of the smallest recording (`toml: OLD -> NEW`, `csv: OLD -> NEW`; an empty OLD
//! appends; `table: tilting` takes the sample whose gripper tilts) and the message, in which `RUN` stands for the folder.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a case that cannot be read fails its test"
)]

mod sample;

use std::fs;

use trundle_record::Recording;

struct Case<'a> {
    name: &'a str,
    toml: String,
    csv: String,
    message: &'a str,
}

fn parse(paragraph: &str) -> Case<'_> {
    let mut case = Case { name: "", toml: sample::TOML.to_owned(), csv: sample::CSV.to_owned(), message: "" };
    for line in paragraph.lines() {
        let (key, value) = line.split_once(':').unwrap_or_else(|| panic!("{line:?}"));
        match (key, value.trim()) {
            ("case", name) => case.name = name,
            ("table", "tilting") => case.csv = sample::TILTING.to_owned(),
            ("toml", edit) => case.toml = edited(&case.toml, edit),
            ("csv", edit) => case.csv = edited(&case.csv, edit),
            ("says", message) => case.message = message,
            _ => panic!("no such line: {line}"),
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

fn walk(cases: &str) {
    let mut wrong = Vec::new();
    for case in cases.trim_end().split("\n\n").map(parse) {
        let home = tempfile::tempdir().unwrap();
        sample::folder(home.path(), &case.toml, &case.csv);
        let found = match Recording::read(home.path()) {
            Ok(_) => "accepted".to_owned(),
            Err(error) => error.to_string().replace(&home.path().display().to_string(), "RUN"),
        };
        if found != case.message {
            wrong.push(format!("case: {}\nsays: {found}", case.name));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n\n"));
}

#[test]
fn of_metadata() {
    walk(include_str!("cases/metadata.txt"));
}

#[test]
fn of_tables() {
    walk(include_str!("cases/tables.txt"));
}

#[test]
fn of_what_tables_and_metadata_say_together() {
    walk(include_str!("cases/together.txt"));
}

#[test]
fn but_not_of_these() {
    walk(include_str!("cases/accepted.txt"));
}

#[test]
fn of_text_that_is_not_utf8() {
    let home = tempfile::tempdir().unwrap();
    sample::folder(home.path(), sample::TOML, sample::CSV);
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
fn of_folders() {
    let home = tempfile::tempdir().unwrap();
    let run = home.path().join("run");
    let says = |expected: &str| {
        let error = Recording::read(&run).unwrap_err().to_string();
        assert_eq!(error.replace(&run.display().to_string(), "RUN"), expected);
    };
    let is = "a recording is a folder that holds recording.toml and one table per episode, NAME.csv or NAME.parquet";
    says(&format!("RUN: there is nothing of this name; {is}"));
    fs::write(&run, "").unwrap();
    says(&format!("RUN: this is a file; {is}"));
    fs::remove_file(&run).unwrap();
    fs::create_dir(&run).unwrap();
    says(&format!("RUN: there is no recording.toml in this folder; {is}"));
    fs::write(run.join("recording.toml"), sample::TOML).unwrap();
    says(
        "RUN/recording.toml: there is no episode table beside it, so nothing is left to fit; add NAME.csv or NAME.parquet",
    );
    sample::folder(&run, sample::TOML, sample::CSV);
    fs::write(run.join("episode_00.parquet"), "").unwrap();
    says("RUN/episode_00.csv: there is episode_00.parquet as well; keep one table per episode");
    fs::remove_file(run.join("episode_00.csv")).unwrap();
    let error = Recording::read(&run).unwrap_err().to_string();
    assert!(error.contains("episode_00.parquet: not a readable Parquet file: "), "{error}");
}
