//! Damaged and oversized Parquet files.

#![allow(clippy::unwrap_used, reason = "a test ends there")]

use std::fs;

use trundle_record::{Column, Recording, Table, write_parquet};

#[test]
fn truncated_files_are_refused() {
    let home = tempfile::tempdir().unwrap();
    let run = home.path().join("run");
    crate::sample::recording().write(&run, Table::Parquet).unwrap();
    let file = run.join("episode_00.parquet");
    let whole = fs::read(&file).unwrap();
    for length in (0..whole.len()).step_by(7) {
        fs::write(&file, &whole[..length]).unwrap();
        let error = Recording::read(&run).unwrap_err().to_string();
        assert!(error.contains("episode_00.parquet: not a readable Parquet file: "), "{length}: {error}");
    }
}

#[test]
fn files_with_a_changed_byte_do_not_panic() {
    let home = tempfile::tempdir().unwrap();
    let run = home.path().join("run");
    crate::sample::recording().write(&run, Table::Parquet).unwrap();
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

/// A million rows of one value take a few kilobytes on disk and 80 MB in memory.
#[test]
fn small_files_that_unpack_to_much_memory_are_refused() {
    let home = tempfile::tempdir().unwrap();
    let run = home.path().join("run");
    crate::sample::recording().write(&run, Table::Parquet).unwrap();
    let file = run.join("episode_00.parquet");
    let cells = vec![0.0; 1_000_000];
    let names = ["t", "object_x", "object_y", "object_theta", "gripper_x", "gripper_y", "gripper_theta"];
    let names = names.into_iter().chain(["force_x", "force_y", "torque_z"]);
    let columns: Vec<_> = names.map(|name| (name, Column::Numbers(&cells))).collect();
    write_parquet(&file, &columns).unwrap();
    let size = fs::metadata(&file).unwrap().len();
    assert!(size < 100_000, "{size}");
    let error = Recording::read(&run).unwrap_err().to_string();
    assert!(error.contains("episode_00.parquet, column ") && error.contains("MiB"), "{error}");
    // Half as many rows are within the limit; the error is then about their times.
    let columns: Vec<_> =
        columns.iter().map(|(name, _)| (*name, Column::Numbers(&cells[..500_000]))).collect();
    write_parquet(&file, &columns).unwrap();
    let error = Recording::read(&run).unwrap_err().to_string();
    assert!(error.contains("time 0 s does not follow 0 s"), "{error}");
}
