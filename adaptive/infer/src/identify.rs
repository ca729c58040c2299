//! Joint identifiability of a fit's parameters: the spectrum of the Fisher information, and identified
//! combinations of unidentified parameters.
//!
//! All quantities are relative to the prior, in coordinates `z` in which it is standard normal. A direction
//! with `λ` times the curvature of the prior has the posterior standard deviation `1/√(1 + λ)`.

use crate::{Estimate, Fit};
use nalgebra::{DMatrix, DVector, SymmetricEigen};
use std::collections::BTreeMap;
use trundle_model::{Prior, Slot};

/// Ratio of posterior to prior standard deviation below which a direction is identified, as for single
/// parameters.
const MAX_IDENTIFIED_SD: f64 = 0.3;

/// Maximum standard deviation of the logarithm of an identified ratio or product: a factor of e^½.
const MAX_LOG_SD: f64 = 0.5;

/// Minimum size of a named component of a direction, as a share of the largest.
const MIN_DOMINANT_SHARE: f64 = 0.3;

/// Identified and unidentified directions and parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Identifiability {
    /// Principal directions of the information, the best determined first.
    pub directions: Vec<Direction>,
    /// Number of identified directions.
    pub identified: usize,
    /// Identified combinations of unidentified parameters.
    pub combinations: Vec<Combination>,
    /// Parameters that are neither identified nor part of an identified combination.
    pub unknown: Vec<String>,
}

/// A principal direction of the information in `z`.
#[derive(Clone, Debug, PartialEq)]
pub struct Direction {
    /// Information of the data relative to that of the prior; for an angle in 1/rad².
    pub information: f64,
    /// Posterior standard deviation along the direction, in prior standard deviations.
    pub sd: f64,
    /// Whether the direction is identified.
    pub identified: bool,
    /// Dominant components: parameters and their weights in a unit vector.
    pub parts: Vec<(String, f64)>,
}

/// A combination of parameters.
#[derive(Clone, Debug, PartialEq)]
pub enum Combination {
    /// Quotient of two positive parameters.
    Ratio(Pair),
    /// Product of two positive parameters.
    Product(Pair),
    /// Weighted sum of parameters in prior standard deviations, with its posterior standard deviation in the
    /// same unit.
    Sum {
        /// Parameters and their weights.
        parts: Vec<(String, f64)>,
        /// Ratio of posterior to prior standard deviation.
        sd: f64,
    },
}

/// Two parameters with an identified quotient or product.
#[derive(Clone, Debug, PartialEq)]
pub struct Pair {
    /// Names of the first and the second factor, or of the dividend and the divisor.
    pub names: [String; 2],
    /// Their units.
    pub units: [&'static str; 2],
    /// Value in SI units.
    pub value: f64,
    /// Relative standard deviation.
    pub relative_sd: f64,
}

impl std::fmt::Display for Combination {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Ratio(p) => write!(f, "{} / {} = {}", p.names[0], p.names[1], p.number("/")),
            Self::Product(p) => write!(f, "{} · {} = {}", p.names[0], p.names[1], p.number("·")),
            Self::Sum { parts, sd } => {
                let terms: Vec<String> = parts.iter().map(|(name, w)| format!("{w:+.2} {name}")).collect();
                write!(f, "{} (each in prior standard deviations) within {sd:.2}", terms.join(" "))
            }
        }
    }
}

impl Pair {
    fn number(&self, sign: &str) -> String {
        let [a, b] = self.units;
        format!("{:.4} ± {:.1} % [{a} {sign} {b}]", self.value, 100.0 * self.relative_sd)
    }
}

impl Fit {
    /// Joint identifiability of the parameters.
    pub fn identifiability(&self) -> Identifiability {
        let directions = directions(&self.information, &self.slots);
        let combinations = combinations(self);
        let named = |name: &String| combinations.iter().any(|c| c.names().any(|n| n == name));
        let unknown = self.estimates.iter().filter(|e| !e.identified && !named(&e.name));
        Identifiability {
            identified: directions.iter().filter(|d| d.identified).count(),
            directions,
            unknown: unknown.map(|e| e.name.clone()).collect(),
            combinations,
        }
    }
}

impl Combination {
    /// Parameters of the combination.
    pub fn names(&self) -> impl Iterator<Item = &String> {
        let (pair, parts): (&[String], &[(String, f64)]) = match self {
            Self::Ratio(p) | Self::Product(p) => (&p.names, &[]),
            Self::Sum { parts, .. } => (&[], parts),
        };
        pair.iter().chain(parts.iter().map(|(name, _)| name))
    }
}

fn directions(information: &DMatrix<f64>, slots: &[Slot]) -> Vec<Direction> {
    if slots.is_empty() {
        return vec![];
    }
    let spectrum = SymmetricEigen::new(information.clone());
    let mut directions: Vec<Direction> = (0..slots.len())
        .map(|k| {
            let lambda = spectrum.eigenvalues[k].max(0.0);
            let vector = spectrum.eigenvectors.column(k).into_owned();
            // An angle has no prior; its period is about one radian.
            let sd = (1.0 + lambda).sqrt().recip();
            Direction {
                information: lambda,
                sd,
                identified: sd < MAX_IDENTIFIED_SD,
                parts: dominant(&vector, slots),
            }
        })
        .collect();
    directions.sort_by(|a, b| b.information.total_cmp(&a.information));
    directions
}

/// Dominant components of a direction, the largest first and positive.
fn dominant(vector: &DVector<f64>, slots: &[Slot]) -> Vec<(String, f64)> {
    let largest = vector[vector.icamax()];
    let sign = if largest < 0.0 { -1.0 } else { 1.0 };
    let mut parts: Vec<(String, f64)> = vector
        .iter()
        .zip(slots)
        .filter(|(w, _)| w.abs() >= MIN_DOMINANT_SHARE * largest.abs())
        .map(|(w, slot)| (slot.name.clone(), sign * w))
        .collect();
    parts.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
    parts
}

/// Identified combinations of unidentified parameters: ratios and products first, since they are easier to
/// interpret, then the remaining directions of the covariance.
fn combinations(fit: &Fit) -> Vec<Combination> {
    let unidentified: Vec<usize> =
        (0..fit.estimates.len()).filter(|&k| !fit.estimates[k].identified).collect();
    let pairs = pairs(fit, &unidentified);
    let named: Vec<&String> = pairs.iter().flat_map(Combination::names).collect();
    let rest: Vec<usize> =
        unidentified.into_iter().filter(|&k| !named.contains(&&fit.estimates[k].name)).collect();
    let sums = sums(fit, &rest);
    pairs.into_iter().chain(sums).collect()
}

/// Independent ratios and products, the best determined first.
fn pairs(fit: &Fit, unidentified: &[usize]) -> Vec<Combination> {
    let positive: Vec<(usize, f64)> =
        unidentified.iter().filter_map(|&k| Some((k, spread(&fit.slots[k])?))).collect();
    let mut known: Vec<(f64, [usize; 2], f64)> = vec![];
    for (n, &(i, a)) in positive.iter().enumerate() {
        for &(j, b) in &positive[n + 1..] {
            for sign in [-1.0, 1.0] {
                let sd = log_sd(fit, i, j, sign);
                if sd < MAX_LOG_SD && sd < MAX_IDENTIFIED_SD * a.hypot(b) {
                    known.push((sd, [i, j], sign));
                }
            }
        }
    }
    known.sort_by(|x, y| x.0.total_cmp(&y.0));
    let mut groups: BTreeMap<usize, usize> = positive.iter().map(|&(k, _)| (k, k)).collect();
    let independent = |&(_, [i, j], _): &(f64, [usize; 2], f64)| {
        let (a, b) = (groups[&i], groups[&j]);
        groups.values_mut().filter(|g| **g == b).for_each(|g| *g = a);
        a != b
    };
    known.into_iter().filter(independent).map(|(sd, ij, sign)| pair(fit, ij, sign, sd)).collect()
}

/// Prior standard deviation of the logarithm of a positive parameter.
fn spread(slot: &Slot) -> Option<f64> {
    match slot.prior {
        Prior::LogNormal { sd, .. } => Some(sd),
        _ => None,
    }
}

/// Posterior standard deviation of ln aᵢ + sign·ln aⱼ.
fn log_sd(fit: &Fit, i: usize, j: usize, sign: f64) -> f64 {
    let relative =
        |a: usize, b: usize| fit.covariance[(a, b)] / (fit.estimates[a].mean * fit.estimates[b].mean);
    let variance = relative(i, i) + relative(j, j) + 2.0 * sign * relative(i, j);
    if variance.is_finite() { variance.max(0.0).sqrt() } else { f64::INFINITY }
}

fn pair(fit: &Fit, [i, j]: [usize; 2], sign: f64, relative_sd: f64) -> Combination {
    let [a, b]: [&Estimate; 2] = [i, j].map(|k| &fit.estimates[k]);
    let value = if sign < 0.0 { a.mean / b.mean } else { a.mean * b.mean };
    let pair = Pair { names: [a.name.clone(), b.name.clone()], units: [a.unit, b.unit], value, relative_sd };
    if sign < 0.0 { Combination::Ratio(pair) } else { Combination::Product(pair) }
}

/// Identified directions of the marginal posterior covariance of some parameters.
fn sums(fit: &Fit, unidentified: &[usize]) -> Vec<Combination> {
    if unidentified.len() < 2 {
        return vec![];
    }
    let own = DMatrix::from_fn(unidentified.len(), unidentified.len(), |a, b| {
        fit.spread[(unidentified[a], unidentified[b])]
    });
    let slots: Vec<Slot> = unidentified.iter().map(|&k| fit.slots[k].clone()).collect();
    let spectrum = SymmetricEigen::new(own.clone());
    let sum = |k: usize| {
        let vector = spectrum.eigenvectors.column(k).into_owned();
        let parts = dominant(&vector, &slots);
        // The criterion applies to the named components, not to the whole direction.
        let named = DVector::from_fn(unidentified.len(), |a, _| {
            if parts.iter().any(|(name, _)| *name == slots[a].name) { vector[a] } else { 0.0 }
        })
        .normalize();
        let sd = named.dot(&(&own * &named)).max(0.0).sqrt();
        (parts.len() > 1 && sd < MAX_IDENTIFIED_SD).then_some(Combination::Sum { parts, sd })
    };
    (0..unidentified.len()).filter_map(sum).collect()
}
