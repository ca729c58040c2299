//! Merging of equal findings: one for each cause, not for each episode and joint.

use crate::check::Finding;

/// Maximum number of names that a merged finding lists.
const MAX_LISTED: usize = 4;

/// A finding about one joint in one or all episodes, with its size.
pub(super) struct Found {
    pub size: f64,
    pub joint: String,
    pub finding: Finding,
}

/// The most severe and largest of `found`, with the names of the other joints and episodes.
pub(super) fn merged(mut found: Vec<Found>) -> Vec<Finding> {
    found.sort_by(|a, b| a.finding.severity.cmp(&b.finding.severity).then(b.size.total_cmp(&a.size)));
    let distinct = |names: Vec<String>| {
        let mut seen: Vec<String> = Vec::new();
        for name in names {
            if !seen.contains(&name) {
                seen.push(name);
            }
        }
        seen
    };
    let joints = distinct(found.iter().map(|one| one.joint.clone()).collect());
    let episodes = distinct(found.iter().filter_map(|one| one.finding.episode.clone()).collect());
    let Some(mut worst) = found.into_iter().next().map(|one| one.finding) else { return vec![] };
    let mut also = Vec::new();
    if joints.len() > 1 {
        also.push(format!("also joint{} {}", if joints.len() > 2 { "s" } else { "" }, listed(&joints[1..])));
    }
    if episodes.len() > 1 {
        also.push(format!("in {} episodes: {}", episodes.len(), listed(&episodes)));
        worst.episode = None;
    }
    if !also.is_empty() {
        worst.sentence = format!("{} ({})", worst.sentence, also.join("; "));
    }
    vec![worst]
}

fn listed(names: &[String]) -> String {
    let (named, rest) = names.split_at(names.len().min(MAX_LISTED));
    let more = if rest.is_empty() { String::new() } else { format!(" and {} more", rest.len()) };
    format!("{}{more}", named.join(", "))
}
