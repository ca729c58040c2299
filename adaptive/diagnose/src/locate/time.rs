//! When a simulation goes wrong: a scan over windows of every length.
//!
//! Each window asks whether one constant missing wrench over it would help (χ², as many degrees of freedom as
//! directions that move). Neighbouring windows say nearly the same, so the number of independent ones is measured
//! on innovations drawn from the null (a parametric bootstrap): a strength is −log10 of the chance that any window
//! of a clean recording of this design reaches it. Windows are found one after the other, each with those before
//! projected out, so that a neighbour's echo is not told.

use super::knots::{Knots, WIDE};
use super::screen::{Screen, surprise};
use crate::answer::Window;
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use rayon::prelude::*;

/// A recording in which nothing is missing shows any window with this probability.
pub(crate) const FALSE_ALARM: f64 = 0.01;
/// Windows closer than this are one, s.
const BRIDGE: f64 = 0.15;
/// At most this many constant pieces are looked for.
const PIECES: usize = 24;
/// Draws of the bootstrap.
const DRAWS: u64 = 100;

/// A piece of an episode with one constant missing wrench.
#[derive(Clone, Debug)]
pub(crate) struct Piece {
    pub episode: usize,
    /// First knot, and the one after the last.
    pub knots: (usize, usize),
    /// s.
    pub span: (f64, f64),
    pub chi_square: f64,
    pub strength: f64,
}

/// What is known of each window: sums over its knots are differences of these.
struct Sums {
    /// Of the Gram matrix, by first and last knot.
    gram: Vec<Matrix3<f64>>,
    /// Of the part that others explain, by knot.
    others: Vec<DMatrix<f64>>,
    score: Vec<Vector3<f64>>,
    n: usize,
}

/// The state of the search in one episode.
struct Left {
    score: DVector<f64>,
    /// Products with an orthonormal basis of all that was found or is nominal.
    others: DMatrix<f64>,
}

/// The pieces of all episodes, strongest first, how many independent windows there are, and the strongest one's
/// strength, told or not.
pub(crate) fn scan(screen: &Screen, knots: &[Knots], seed: u64) -> (Vec<Piece>, f64, f64) {
    let windows = independent(screen, knots, seed);
    let mut left: Vec<Left> =
        knots.iter().map(|k| Left { score: k.score.clone(), others: k.nominal.clone() }).collect();
    let (mut pieces, mut loudest): (Vec<Piece>, f64) = (Vec::new(), 0.0);
    while pieces.len() < PIECES {
        let Some(mut best) = strongest(screen, knots, &left) else { break };
        best.strength = surprise(best.chi_square, screen.directions()) - windows.log10();
        loudest = loudest.max(best.strength);
        if best.strength < -FALSE_ALARM.log10() || !project(knots, &mut left, &best) {
            break;
        }
        pieces.push(best);
    }
    (pieces, windows, loudest)
}

fn sums(knots: &Knots, left: &Left) -> Sums {
    let n = knots.len() + 1;
    let mut gram = vec![Matrix3::zeros(); n * n];
    for i in 1..n {
        for j in 1..n {
            let block: Matrix3<f64> =
                knots.gram.fixed_view::<WIDE, WIDE>(WIDE * (i - 1), WIDE * (j - 1)).into_owned();
            gram[n * i + j] = block + gram[n * (i - 1) + j] + gram[n * i + j - 1] - gram[n * (i - 1) + j - 1];
        }
    }
    let (score, others) = running(left, n);
    Sums { gram, others, score, n }
}

fn running(left: &Left, n: usize) -> (Vec<Vector3<f64>>, Vec<DMatrix<f64>>) {
    let mut score = vec![Vector3::zeros(); n];
    let mut others = vec![DMatrix::zeros(WIDE, left.others.ncols()); n];
    for k in 1..n {
        score[k] = score[k - 1] + left.score.fixed_rows::<WIDE>(WIDE * (k - 1));
        others[k] = &others[k - 1] + left.others.rows(WIDE * (k - 1), WIDE);
    }
    (score, others)
}

impl Sums {
    /// Gram matrix of a window, others projected out, and the same before.
    fn gram(&self, from: usize, to: usize) -> (Matrix3<f64>, Matrix3<f64>) {
        let at = |i: usize, j: usize| &self.gram[self.n * i + j];
        let whole = at(to, to) - at(from, to) - at(to, from) + at(from, from);
        let along = &self.others[to] - &self.others[from];
        let taken = &along * along.transpose();
        (whole - Matrix3::from_fn(|i, j| taken[(i, j)]), whole)
    }
}

/// Share of a window's square below which it is not independent of what was found.
const INDEPENDENT: f64 = 1e-4;

/// Inverse of the factor of a window's Gram matrix, `L⁻¹`, rows of directions that are not held zero.
fn whitener((gram, whole): (Matrix3<f64>, Matrix3<f64>)) -> Matrix3<f64> {
    let mut factor = Matrix3::zeros();
    let mut inverse = Matrix3::zeros();
    for i in 0..WIDE {
        let mut row = gram.row(i).into_owned();
        for j in 0..i {
            let sum: f64 = (0..j).map(|k| factor[(i, k)] * factor[(j, k)]).sum();
            let pivot: f64 = factor[(j, j)];
            factor[(i, j)] = if pivot > 0.0 { (row[j] - sum) / pivot } else { 0.0 };
        }
        row[i] -= (0..i).map(|k| factor[(i, k)] * factor[(i, k)]).sum::<f64>();
        if row[i] <= INDEPENDENT * whole[(i, i)] || row[i] <= 0.0 {
            factor.row_mut(i).fill(0.0);
            continue;
        }
        factor[(i, i)] = row[i].sqrt();
        for j in 0..=i {
            let unit = if i == j { 1.0 } else { 0.0 };
            let sum: f64 = (0..i).map(|k| factor[(i, k)] * inverse[(k, j)]).sum();
            inverse[(i, j)] = (unit - sum) / factor[(i, i)];
        }
    }
    inverse
}

/// The window of any episode that explains most.
fn strongest(screen: &Screen, knots: &[Knots], left: &[Left]) -> Option<Piece> {
    let of = |(e, (own, left)): (usize, (&Knots, &Left))| {
        let sums = sums(own, left);
        let (mut best, mut span) = (0.0, (0, 0));
        for from in 0..own.len() {
            for to in from + 1..=own.len() {
                let score = sums.score[to] - sums.score[from];
                let chi_square = (whitener(sums.gram(from, to)) * score).norm_squared();
                if chi_square > best {
                    (best, span) = (chi_square, (from, to));
                }
            }
        }
        let times = (own.edges[span.0], own.edges[span.1]);
        Piece { episode: e, knots: span, span: times, chi_square: best, strength: 0.0 }
    };
    let indexed: Vec<_> = knots.iter().zip(left).enumerate().collect();
    let all: Vec<Piece> = indexed.into_par_iter().map(of).collect();
    let valid = all.into_iter().filter(|p| p.chi_square > 0.0 && screen.directions() > 0);
    valid.max_by(|a, b| a.chi_square.total_cmp(&b.chi_square))
}

/// Take a piece out of what is left in every episode; false where there is nothing to take.
fn project(knots: &[Knots], left: &mut [Left], piece: &Piece) -> bool {
    let (from, to) = piece.knots;
    let own = &knots[piece.episode];
    let sums = sums(own, &left[piece.episode]);
    let whitener = whitener(sums.gram(from, to));
    let unit = whitener * (sums.score[to] - sums.score[from]);
    let along = &sums.others[to] - &sums.others[from];
    if unit.norm_squared() <= 0.0 {
        return false;
    }
    for (e, (episode, left)) in knots.iter().zip(left).enumerate() {
        let mut products = -(&left.others * along.transpose());
        if e == piece.episode {
            for k in from..to {
                products += episode.gram.columns(WIDE * k, WIDE);
            }
        }
        let products = products * whitener.transpose();
        left.score -= &products * unit;
        let n = left.others.ncols();
        let mut wider = left.others.clone().resize_horizontally(n + WIDE, 0.0);
        wider.columns_mut(n, WIDE).copy_from(&products);
        left.others = wider;
    }
    true
}

/// How many independent windows the scan amounts to: the number for which the smallest p of draws from the null is
/// distributed as that of so many.
fn independent(screen: &Screen, knots: &[Knots], seed: u64) -> f64 {
    let prepared: Vec<Vec<Matrix3<f64>>> = knots.par_iter().map(whiteners).collect();
    let tails: Vec<f64> = (0..DRAWS)
        .into_par_iter()
        .map(|draw| {
            let largest = null_maximum(screen, knots, &prepared, seed, draw);
            10f64.powf(-surprise(largest, screen.directions()))
        })
        .collect();
    let mean = tails.iter().sum::<f64>() / tails.len() as f64;
    mean.recip().max(1.0)
}

/// Whiteners of all windows, in the order in which they are scanned.
fn whiteners(knots: &Knots) -> Vec<Matrix3<f64>> {
    let left = Left { score: knots.score.clone(), others: knots.nominal.clone() };
    let sums = sums(knots, &left);
    let windows = (0..knots.len()).flat_map(|from| (from + 1..=knots.len()).map(move |to| (from, to)));
    windows.map(|(from, to)| whitener(sums.gram(from, to))).collect()
}

fn null_maximum(
    screen: &Screen,
    knots: &[Knots],
    prepared: &[Vec<Matrix3<f64>>],
    seed: u64,
    draw: u64,
) -> f64 {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(draw + 1);
    let noise: Vec<DVector<f64>> = screen
        .runs
        .iter()
        .map(|run| {
            let silent = |k: usize| run.response.innovations[k] == 0.0;
            DVector::from_fn(run.innovations.len(), |k, _| {
                let value: f64 = rng.sample(StandardNormal);
                if silent(k) { 0.0 } else { value }
            })
        })
        .collect();
    let mut along = DVector::zeros(screen.nominal());
    for (run, noise) in screen.runs.iter().zip(&noise) {
        along += run.nominal.tr_mul(noise);
    }
    let mut largest = 0.0f64;
    for ((knots, noise), whiteners) in knots.iter().zip(&noise).zip(prepared) {
        let score = knots.answers.tr_mul(noise) - &knots.nominal * &along;
        let left = Left { score, others: DMatrix::zeros(WIDE * knots.len(), 0) };
        let (running, _) = running(&left, knots.len() + 1);
        let mut whitener = whiteners.iter();
        for from in 0..knots.len() {
            for to in from + 1..=knots.len() {
                let Some(whitener) = whitener.next() else { break };
                largest = largest.max((whitener * (running[to] - running[from])).norm_squared());
            }
        }
    }
    largest
}

/// Pieces that touch, or nearly, as one window each, in order of time.
pub(crate) fn windows(pieces: &[Piece], names: &[String], windows: f64, directions: usize) -> Vec<Window> {
    let mut sorted: Vec<&Piece> = pieces.iter().collect();
    sorted.sort_by(|a, b| {
        (a.episode, a.span.0).partial_cmp(&(b.episode, b.span.0)).unwrap_or(std::cmp::Ordering::Equal)
    });
    let mut groups: Vec<(usize, (f64, f64), Vec<&Piece>)> = Vec::new();
    for piece in sorted {
        match groups.last_mut() {
            Some((episode, span, group)) if *episode == piece.episode && piece.span.0 - span.1 <= BRIDGE => {
                span.1 = span.1.max(piece.span.1);
                group.push(piece);
            }
            _ => groups.push((piece.episode, piece.span, vec![piece])),
        }
    }
    let told = |(episode, (start, end), group): (usize, (f64, f64), Vec<&Piece>)| Window {
        episode: names.get(episode).cloned().unwrap_or_default(),
        start,
        end,
        strength: together(&group, windows, directions),
    };
    groups.into_iter().map(told).collect()
}

/// Strength of several pieces: what each explained beyond those before adds up.
fn together(group: &[&Piece], windows: f64, directions: usize) -> f64 {
    let chi_square = group.iter().map(|p| p.chi_square).sum();
    let count = group.len();
    let all = surprise(chi_square, directions * count) - count as f64 * windows.log10();
    group.iter().map(|p| p.strength).fold(all, f64::max)
}
