//! Merging of equal findings in several episodes.

use super::finding::Finding;

/// Maximum number of episodes that a merged finding lists by name.
const MAX_LISTED_EPISODES: usize = 4;

/// Merges `found`, a size and a finding per episode, into the most severe finding. It lists the other episodes.
pub(crate) fn grouped(mut found: Vec<(f64, Finding)>) -> Vec<Finding> {
    found.sort_by(|a, b| a.1.severity.cmp(&b.1.severity).then(b.0.total_cmp(&a.0)));
    let names: Vec<String> = found.iter().filter_map(|(_, finding)| finding.episode.clone()).collect();
    let Some((_, mut worst)) = found.into_iter().next() else { return vec![] };
    if names.len() > 1 {
        worst.sentence = format!("{} ({})", worst.sentence, listed(&names));
        worst.episode = None;
    }
    vec![worst]
}

/// Text such as "in 3 episodes, most in a, b, c".
fn listed(names: &[String]) -> String {
    let (named, rest) = names.split_at(names.len().min(MAX_LISTED_EPISODES));
    let more = if rest.is_empty() { String::new() } else { format!(" and {} more", rest.len()) };
    format!("in {} episodes, most in {}{more}", names.len(), named.join(", "))
}
