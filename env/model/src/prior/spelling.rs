//! Suggestions for misspelled names.

/// Known name with the smallest edit distance, if the distance is small relative to the length.
pub(super) fn closest_name<'a>(name: &str, known: &[&'a str]) -> Option<&'a str> {
    let (edits, best) = known.iter().map(|k| (edit_distance(name, k), *k)).min()?;
    (edits <= 1 + name.chars().count() / 4).then_some(best)
}

/// Suggestion of a similar name, followed by the known names.
pub(super) fn hint(name: &str, known: &[&str]) -> String {
    match closest_name(name, known) {
        Some(near) => format!("did you mean `{near}`? Choose from {}", known.join(", ")),
        None => format!("choose from {}", known.join(", ")),
    }
}

/// Levenshtein distance.
fn edit_distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, from) in a.chars().enumerate() {
        let mut next = vec![i + 1];
        for ((above, pair), to) in row.iter().skip(1).zip(row.windows(2)).zip(&b) {
            let left = next.last().copied().unwrap_or(0);
            let swapped = pair[0] + usize::from(from != *to);
            next.push(swapped.min(above + 1).min(left + 1));
        }
        row = next;
    }
    row.last().copied().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edit_distances_match_textbook_examples() {
        assert_eq!(
            (edit_distance("kitten", "sitting"), edit_distance("", "abc"), edit_distance("mu_x", "mu_x")),
            (3, 3, 0)
        );
        assert_eq!(closest_name("mas", &["mass", "angle"]), Some("mass"));
        assert_eq!(closest_name("inertia", &["mass", "angle"]), None);
    }
}
