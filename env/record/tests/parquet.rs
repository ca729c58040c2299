//! A damaged Parquet file is refused or read, but nothing breaks.

#![allow(clippy::unwrap_used, reason = "a test ends there")]

mod sample;

use std::fs;

use trundle_record::{Recording, Table};

#[test]
fn cut_off_anywhere() {
    let home = tempfile::tempdir().unwrap();
    let run = home.path().join("run");
    sample::recording().write(&run, Table::Parquet).unwrap();
    let file = run.join("episode_00.parquet");
    let whole = fs::read(&file).unwrap();
    for length in (0..whole.len()).step_by(7) {
        fs::write(&file, &whole[..length]).unwrap();
        let error = Recording::read(&run).unwrap_err().to_string();
        assert!(error.contains("episode_00.parquet: not a readable Parquet file: "), "{length}: {error}");
    }
}

#[test]
fn one_byte_changed_anywhere() {
    let home = tempfile::tempdir().unwrap();
    let run = home.path().join("run");
    sample::recording().write(&run, Table::Parquet).unwrap();
    let file = run.join("episode_00.parquet");
    let whole = fs::read(&file).unwrap();
    let mut refused = 0;
    for position in (0..whole.len()).step_by(2) {
        for change in [0x01, 0x80] {
            let mut bytes = whole.clone();
            bytes[position] ^= change;
            fs::write(&file, &bytes).unwrap();
            refused += usize::from(Recording::read(&run).is_err());
        }
    }
    assert!(refused > whole.len() / 4, "{refused} of {} changes were refused", whole.len());
}
