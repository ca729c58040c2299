//! The sentence of a named effect.

use crate::model::Kind;
use crate::problem::Problem;
use std::collections::BTreeMap;
use trundle_diagnose::Quantity;

/// The sentence of an effect with its values.
pub(crate) fn statement(problem: &Problem, kind: Kind, parameters: &BTreeMap<String, Quantity>) -> String {
    let sentence = kind.spec().sentence;
    let (positive, negative) = sentence.split_once('|').unwrap_or((sentence, sentence));
    let is_negated = positive != negative && parameters.values().all(|one| one.mean < 0.0);
    let mut text = if is_negated { negative } else { positive }.to_owned();
    if let Some(joint) = kind.joint() {
        text = text.replace("{joint}", &problem.joints[joint].name);
    }
    if let Kind::Payload(body) = kind {
        text = text.replace("{body}", &problem.bodies[body].0);
    }
    for (name, quantity) in parameters {
        let mean = if is_negated { -quantity.mean } else { quantity.mean };
        text = text.replace(&format!("{{{name}}}"), &shown(&Quantity { mean, ..*quantity }));
    }
    with_known_parts(&text) + "."
}

/// A sentence without the parts in brackets whose parameters have no value.
fn with_known_parts(text: &str) -> String {
    let mut found = String::new();
    for (k, part) in text.split(['[', ']']).enumerate() {
        // Every second part is in brackets.
        if k % 2 == 0 || !part.contains('{') {
            found.push_str(part);
        }
    }
    found
}

/// `1.23 ± 0.05 N`: digits down to the second of the standard deviation.
pub(crate) fn shown(quantity: &Quantity) -> String {
    let digits = if quantity.sd > 0.0 && quantity.sd.is_finite() {
        (1.0 - quantity.sd.log10().floor()).clamp(0.0, 9.0)
    } else {
        3.0
    };
    let (mean, sd, digits) = (quantity.mean, quantity.sd, digits as usize);
    let unit = if quantity.unit == "1" { String::new() } else { format!(" {}", quantity.unit) };
    format!("{mean:.digits$} ± {sd:.digits$}{unit}")
}

#[cfg(test)]
mod tests {
    use super::with_known_parts;

    #[test]
    fn parts_without_values_are_left_out() {
        assert_eq!(
            with_known_parts("Friction of 1 N[, and {rest} at rest] acts[ here]"),
            "Friction of 1 N acts here"
        );
    }
}
