//! Whatever stands in the files, it is read or refused.

#![allow(clippy::unwrap_used, reason = "a test ends there")]

mod sample;

use proptest::prelude::*;
use trundle_record::Recording;

/// Cuts `cut` characters out of `text` at `at` and puts `patch` there, counted round the end.
fn patched(text: &str, at: usize, cut: usize, patch: &str) -> String {
    let mut letters: Vec<char> = text.chars().collect();
    let at = at % letters.len();
    let end = (at + cut).min(letters.len());
    letters.splice(at..end, patch.chars());
    letters.into_iter().collect()
}

/// What a slip of the keyboard may leave, and what it may break.
fn patch() -> impl Strategy<Value = (usize, usize, String)> {
    let text =
        prop_oneof!["[-+0-9.e,\\n\" ]{0,6}", "\\PC{0,3}", Just("nan".to_owned()), Just("1e308".to_owned())];
    (0..2000_usize, 0..8_usize, text)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn read_or_refused(toml in patch(), csv in patch(), more in patch(), tilting: bool) {
        let home = tempfile::tempdir().unwrap();
        let table = if tilting { sample::TILTING } else { sample::CSV };
        let table = patched(&patched(table, csv.0, csv.1, &csv.2), more.0, more.1, &more.2);
        let metadata = if tilting { sample::TOML.to_owned() } else { patched(sample::TOML, toml.0, toml.1, &toml.2) };
        sample::folder(home.path(), &metadata, &table);
        if let Ok(recording) = Recording::read(home.path()) {
            prop_assert!(recording.validate().is_ok());
        }
    }
}
