//! Fuzz test: reading a recording never panics.

#![allow(clippy::unwrap_used, reason = "a test ends there")]

use proptest::prelude::*;
use trundle_record::Recording;

/// Replaces `cut` characters of `text` at `at` (modulo its length) by `patch`.
fn patched(text: &str, at: usize, cut: usize, patch: &str) -> String {
    let mut characters: Vec<char> = text.chars().collect();
    let at = at % characters.len();
    let end = (at + cut).min(characters.len());
    characters.splice(at..end, patch.chars());
    characters.into_iter().collect()
}

/// Position, length and replacement of a random edit.
fn patch() -> impl Strategy<Value = (usize, usize, String)> {
    let text =
        prop_oneof!["[-+0-9.e,\\n\" ]{0,6}", "\\PC{0,3}", Just("nan".to_owned()), Just("1e308".to_owned())];
    (0..2000_usize, 0..8_usize, text)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn reading_never_panics(toml in patch(), csv in patch(), more in patch(), tilting: bool) {
        let home = tempfile::tempdir().unwrap();
        let table = if tilting { crate::sample::TILTING } else { crate::sample::CSV };
        let table = patched(&patched(table, csv.0, csv.1, &csv.2), more.0, more.1, &more.2);
        let metadata = if tilting { crate::sample::TOML.to_owned() } else { patched(crate::sample::TOML, toml.0, toml.1, &toml.2) };
        crate::sample::folder(home.path(), &metadata, &table);
        if let Ok(recording) = Recording::read(home.path()) {
            prop_assert!(recording.validate().is_ok());
        }
    }
}
