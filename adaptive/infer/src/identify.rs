//! What the data hold of a fit's parameters together: the spectrum of the Fisher information, and the
//! combinations that are known where the parameters are not.
//!
//! All is measured against the prior, in coordinates `z` in which it is standard normal: a direction along which
//! the likelihood curves `λ` times as much as the prior has the posterior standard deviation `1/√(1 + λ)`.

use crate::{Estimate, Fit};
use nalgebra::{DMatrix, DVector, SymmetricEigen};
use std::collections::BTreeMap;
use trundle_model::{Prior, Slot};

/// Posterior over prior standard deviation below which a direction is held, as for single parameters.
const HELD: f64 = 0.3;

/// A ratio of positive quantities must also be known within a factor of e^½.
const FACTOR: f64 = 0.5;

/// Parts of a direction smaller than this share of its largest are not named.
const DOMINANT: f64 = 0.3;

/// What the data hold, and what they do not.
#[derive(Clone, Debug, PartialEq)]
pub struct Identifiability {
    /// Principal directions of the information, the best known first.
    pub directions: Vec<Direction>,
    /// How many of them the data hold.
    pub held: usize,
    /// Known combinations of parameters that are themselves not identified.
    pub combinations: Vec<Combination>,
    /// Parameters neither identified nor part of a known combination.
    pub unknown: Vec<String>,
}

/// A principal direction of the information in `z`.
#[derive(Clone, Debug, PartialEq)]
pub struct Direction {
    /// How often more than the prior the data know it; an angle has no prior and is taken in rad.
    pub information: f64,
    /// Posterior standard deviation along it, in prior ones.
    pub sd: f64,
    /// Whether the data hold it.
    pub held: bool,
    /// Its dominant parts: parameters and their weights, of a vector of unit length.
    pub parts: Vec<(String, f64)>,
}

/// A combination of parameters.
#[derive(Clone, Debug, PartialEq)]
pub enum Combination {
    /// The quotient of two positive parameters.
    Ratio(Pair),
    /// The product of two positive parameters.
    Product(Pair),
    /// A sum of parameters in prior units, with weights and its posterior standard deviation in prior ones.
    Sum {
        /// Parameters and their weights.
        parts: Vec<(String, f64)>,
        /// Posterior over prior standard deviation.
        sd: f64,
    },
}

/// Two parameters of which a quotient or a product is known.
#[derive(Clone, Debug, PartialEq)]
pub struct Pair {
    /// Names; the first divided by, or times, the second.
    pub names: [String; 2],
    /// Their units.
    pub units: [&'static str; 2],
    /// The value in their SI units.
    pub value: f64,
    /// Its relative standard deviation.
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
    /// What the data hold, and what they do not.
    pub fn identifiability(&self) -> Identifiability {
        let directions = directions(&self.information, &self.slots);
        let combinations = combinations(self);
        let named = |name: &String| combinations.iter().any(|c| c.names().any(|n| n == name));
        let unknown = self.estimates.iter().filter(|e| !e.identified && !named(&e.name));
        Identifiability {
            held: directions.iter().filter(|d| d.held).count(),
            directions,
            unknown: unknown.map(|e| e.name.clone()).collect(),
            combinations,
        }
    }
}

impl Combination {
    /// The parameters in it.
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
            // Of an angle there is no prior: what is not known of it is its circle, about one radian.
            let sd = (1.0 + lambda).sqrt().recip();
            Direction { information: lambda, sd, held: sd < HELD, parts: dominant(&vector, slots) }
        })
        .collect();
    directions.sort_by(|a, b| b.information.total_cmp(&a.information));
    directions
}

/// The parts of a direction that make it up, largest first and that one positive.
fn dominant(vector: &DVector<f64>, slots: &[Slot]) -> Vec<(String, f64)> {
    let largest = vector[vector.icamax()];
    let sign = if largest < 0.0 { -1.0 } else { 1.0 };
    let mut parts: Vec<(String, f64)> = vector
        .iter()
        .zip(slots)
        .filter(|(w, _)| w.abs() >= DOMINANT * largest.abs())
        .map(|(w, slot)| (slot.name.clone(), sign * w))
        .collect();
    parts.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
    parts
}

/// Known combinations among the parameters that are not identified: quotients and products first, since they mean
/// something to a person, then whatever else the covariance holds.
fn combinations(fit: &Fit) -> Vec<Combination> {
    let open: Vec<usize> = (0..fit.estimates.len()).filter(|&k| !fit.estimates[k].identified).collect();
    let pairs = pairs(fit, &open);
    let named: Vec<&String> = pairs.iter().flat_map(Combination::names).collect();
    let rest: Vec<usize> = open.into_iter().filter(|&k| !named.contains(&&fit.estimates[k].name)).collect();
    let sums = sums(fit, &rest);
    pairs.into_iter().chain(sums).collect()
}

/// Quotients and products of two, best known first, as many as are independent.
fn pairs(fit: &Fit, open: &[usize]) -> Vec<Combination> {
    let positive: Vec<(usize, f64)> =
        open.iter().filter_map(|&k| Some((k, spread(&fit.slots[k])?))).collect();
    let mut known: Vec<(f64, [usize; 2], f64)> = vec![];
    for (n, &(i, a)) in positive.iter().enumerate() {
        for &(j, b) in &positive[n + 1..] {
            for sign in [-1.0, 1.0] {
                let sd = log_sd(fit, i, j, sign);
                if sd < FACTOR && sd < HELD * a.hypot(b) {
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

/// Spread of the logarithm of a positive parameter under its prior.
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

/// Held directions of the posterior covariance of some parameters, whatever the others are.
fn sums(fit: &Fit, open: &[usize]) -> Vec<Combination> {
    if open.len() < 2 {
        return vec![];
    }
    let own = DMatrix::from_fn(open.len(), open.len(), |a, b| fit.spread[(open[a], open[b])]);
    let slots: Vec<Slot> = open.iter().map(|&k| fit.slots[k].clone()).collect();
    let spectrum = SymmetricEigen::new(own.clone());
    let sum = |k: usize| {
        let vector = spectrum.eigenvectors.column(k).into_owned();
        let parts = dominant(&vector, &slots);
        // What is named must be known, not what it is part of.
        let named = DVector::from_fn(open.len(), |a, _| {
            if parts.iter().any(|(name, _)| *name == slots[a].name) { vector[a] } else { 0.0 }
        })
        .normalize();
        let sd = named.dot(&(&own * &named)).max(0.0).sqrt();
        (parts.len() > 1 && sd < HELD).then_some(Combination::Sum { parts, sd })
    };
    (0..open.len()).filter_map(sum).collect()
}
