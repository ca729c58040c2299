//! One finding for all episodes that show the same.

use super::Finding;

/// Episodes named before the rest is counted.
const NAMED: usize = 4;

/// The gravest of `found` (a size and a finding for each episode that shows it), with the names of the others.
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

/// "in 3 episodes: a, b, c", the first of which shows it most.
fn listed(names: &[String]) -> String {
    let (named, rest) = names.split_at(names.len().min(NAMED));
    let more = if rest.is_empty() { String::new() } else { format!(" and {} more", rest.len()) };
    format!("in {} episodes, most in {}{more}", names.len(), named.join(", "))
}
