//! Identifiability of the parameters in the summary of a fit.

use serde::Serialize;
use trundle_infer::{Combination, Fit, Identifiability};

/// Identified directions and combinations of a fit.
#[derive(Clone, Debug, Serialize)]
pub struct IdentifiabilitySummary {
    /// Number of identified directions.
    held: usize,
    /// Number of directions.
    of: usize,
    directions: Vec<DirectionSummary>,
    combinations: Vec<CombinationSummary>,
    /// Parameters that are not identified, alone or in a combination.
    unknown: Vec<String>,
    agreement: Agreement,
}

#[derive(Clone, Debug, Serialize)]
struct DirectionSummary {
    information: f64,
    sd: f64,
    held: bool,
    parts: Vec<Part>,
}

/// A parameter with its weight in a direction or a sum.
#[derive(Clone, Debug, Serialize)]
struct Part {
    name: String,
    weight: f64,
}

#[derive(Clone, Debug, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
enum CombinationSummary {
    Ratio { names: [String; 2], value: f64, relative_sd: f64, text: String },
    Product { names: [String; 2], value: f64, relative_sd: f64, text: String },
    Sum { names: Vec<String>, parts: Vec<Part>, sd: f64, text: String },
}

/// Number of starts, and of those that ended at the optimum.
#[derive(Clone, Debug, Serialize)]
struct Agreement {
    starts: usize,
    at_the_optimum: usize,
}

fn parts(parts: Vec<(String, f64)>) -> Vec<Part> {
    parts.into_iter().map(|(name, weight)| Part { name, weight }).collect()
}

impl From<&Fit> for IdentifiabilitySummary {
    fn from(fit: &Fit) -> Self {
        let Identifiability { directions, identified, combinations, unknown } = fit.identifiability();
        let (at_the_optimum, starts) = fit.agreement;
        let of = directions.len();
        let directions = directions.into_iter().map(|d| DirectionSummary {
            information: d.information,
            sd: d.sd,
            held: d.identified,
            parts: parts(d.parts),
        });
        Self {
            held: identified,
            of,
            directions: directions.collect(),
            combinations: combinations.into_iter().map(CombinationSummary::from).collect(),
            unknown,
            agreement: Agreement { starts, at_the_optimum },
        }
    }
}

impl From<Combination> for CombinationSummary {
    fn from(combination: Combination) -> Self {
        let text = combination.to_string();
        match combination {
            Combination::Ratio(p) => {
                Self::Ratio { names: p.names, value: p.value, relative_sd: p.relative_sd, text }
            }
            Combination::Product(p) => {
                Self::Product { names: p.names, value: p.value, relative_sd: p.relative_sd, text }
            }
            Combination::Sum { parts: terms, sd } => {
                let names = terms.iter().map(|(name, _)| name.clone()).collect();
                Self::Sum { names, parts: parts(terms), sd, text }
            }
        }
    }
}
