//! Findings of the checks.

use serde::Serialize;

/// Severity of a finding.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// Results from this recording would be wrong.
    Error,
    /// Results from this recording may be wrong.
    Warning,
    /// For information.
    Note,
}

/// A finding of a check.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Finding {
    /// Category, for example "units".
    pub kind: &'static str,
    /// Severity.
    pub severity: Severity,
    /// What is wrong, with numbers.
    pub sentence: String,
    /// How to correct it.
    pub remedy: String,
    /// Name of the episode; `None` if the finding concerns the whole recording.
    pub episode: Option<String>,
}

impl Finding {
    pub(crate) fn new(kind: &'static str, severity: Severity, sentence: String, remedy: &str) -> Self {
        Self { kind, severity, sentence, remedy: remedy.to_owned(), episode: None }
    }

    pub(crate) fn in_episode(self, episode: &str) -> Self {
        Self { episode: Some(episode.to_owned()), ..self }
    }
}
