//! Time windows of the misfit: a scan over windows of every length.
//!
//! The statistic of a window is the χ² of a constant missing wrench over it, with one degree of freedom per free
//! direction. Overlapping windows are correlated, so that the number of independent windows is estimated from
//! innovations drawn under the null hypothesis (parametric bootstrap). The strength of a window is −log10 of the
//! probability that any window of a clean recording with this design reaches its χ². Windows are found one after
//! the other, each with the earlier ones projected out.

use super::knots::{COMPONENTS, Knots};
use super::score_test::{ScoreTest, minus_log10_p};
use crate::answer::Window;
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use rayon::prelude::*;

/// Probability that a clean recording shows any window.
pub(crate) const FALSE_ALARM_PROBABILITY: f64 = 0.01;
/// Maximum gap between windows that are merged, s.
pub(crate) const MAX_WINDOW_GAP_S: f64 = 0.15;
/// Maximum number of pieces.
const MAX_PIECES: usize = 24;
/// Number of draws of the bootstrap.
const BOOTSTRAP_DRAWS: u64 = 100;

/// A part of an episode with a constant missing wrench.
#[derive(Clone, Debug)]
pub(crate) struct Piece {
    pub episode: usize,
    /// First knot, and the one after the last.
    pub knots: (usize, usize),
    /// Beginning and end, s.
    pub span: (f64, f64),
    pub chi_square: f64,
    pub strength: f64,
}

/// Prefix sums, whose differences are the sums over the knots of each window.
struct PrefixSums {
    /// Sums of the Gram matrix, by first and last knot.
    gram: Vec<Matrix3<f64>>,
    /// Sums of the explained part, by knot.
    explained: Vec<DMatrix<f64>>,
    score: Vec<Vector3<f64>>,
    n: usize,
}

/// State of the search in one episode.
struct ScanState {
    score: DVector<f64>,
    /// Products with an orthonormal basis of the nominal parameters and of all pieces found.
    explained: DMatrix<f64>,
}

/// Scans all episodes. Returns the pieces, strongest first, the number of independent windows, and the strength
/// of the strongest window, reported or not.
pub(crate) fn scan(score_test: &ScoreTest, knots: &[Knots], seed: u64) -> (Vec<Piece>, f64, f64) {
    let windows = independent_window_count(score_test, knots, seed);
    let mut states: Vec<ScanState> =
        knots.iter().map(|k| ScanState { score: k.score.clone(), explained: k.nominal.clone() }).collect();
    let (mut pieces, mut max_strength): (Vec<Piece>, f64) = (Vec::new(), 0.0);
    while pieces.len() < MAX_PIECES {
        let Some(mut best) = strongest(score_test, knots, &states) else { break };
        best.strength = minus_log10_p(best.chi_square, score_test.free_directions()) - windows.log10();
        max_strength = max_strength.max(best.strength);
        if best.strength < -FALSE_ALARM_PROBABILITY.log10() || !project_out(knots, &mut states, &best) {
            break;
        }
        pieces.push(best);
    }
    (pieces, windows, max_strength)
}

fn sums(knots: &Knots, state: &ScanState) -> PrefixSums {
    let n = knots.len() + 1;
    let mut gram = vec![Matrix3::zeros(); n * n];
    for i in 1..n {
        for j in 1..n {
            let block: Matrix3<f64> = knots
                .gram
                .fixed_view::<COMPONENTS, COMPONENTS>(COMPONENTS * (i - 1), COMPONENTS * (j - 1))
                .into_owned();
            gram[n * i + j] = block + gram[n * (i - 1) + j] + gram[n * i + j - 1] - gram[n * (i - 1) + j - 1];
        }
    }
    let (score, explained) = prefix_sums(state, n);
    PrefixSums { gram, explained, score, n }
}

fn prefix_sums(state: &ScanState, n: usize) -> (Vec<Vector3<f64>>, Vec<DMatrix<f64>>) {
    let mut score = vec![Vector3::zeros(); n];
    let mut explained = vec![DMatrix::zeros(COMPONENTS, state.explained.ncols()); n];
    for k in 1..n {
        score[k] = score[k - 1] + state.score.fixed_rows::<COMPONENTS>(COMPONENTS * (k - 1));
        explained[k] = &explained[k - 1] + state.explained.rows(COMPONENTS * (k - 1), COMPONENTS);
    }
    (score, explained)
}

impl PrefixSums {
    /// Gram matrix of a window with the explained part projected out, and without that projection.
    fn gram(&self, from: usize, to: usize) -> (Matrix3<f64>, Matrix3<f64>) {
        let at = |i: usize, j: usize| &self.gram[self.n * i + j];
        let total = at(to, to) - at(from, to) - at(to, from) + at(from, from);
        let products = &self.explained[to] - &self.explained[from];
        let absorbed = &products * products.transpose();
        (total - Matrix3::from_fn(|i, j| absorbed[(i, j)]), total)
    }
}

/// Share of a window's square below which it depends on the explained part.
const MIN_INDEPENDENT_SHARE: f64 = 1e-4;

/// Inverse `L⁻¹` of the Cholesky factor of a window's Gram matrix; rows of dependent directions are zero.
fn whitener((gram, total): (Matrix3<f64>, Matrix3<f64>)) -> Matrix3<f64> {
    let mut factor = Matrix3::zeros();
    let mut inverse = Matrix3::zeros();
    for i in 0..COMPONENTS {
        let mut row = gram.row(i).into_owned();
        for j in 0..i {
            let sum: f64 = (0..j).map(|k| factor[(i, k)] * factor[(j, k)]).sum();
            let pivot: f64 = factor[(j, j)];
            factor[(i, j)] = if pivot > 0.0 { (row[j] - sum) / pivot } else { 0.0 };
        }
        row[i] -= (0..i).map(|k| factor[(i, k)] * factor[(i, k)]).sum::<f64>();
        if row[i] <= MIN_INDEPENDENT_SHARE * total[(i, i)] || row[i] <= 0.0 {
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

/// The window with the largest χ² in any episode.
fn strongest(score_test: &ScoreTest, knots: &[Knots], states: &[ScanState]) -> Option<Piece> {
    let of = |(e, (knots, state)): (usize, (&Knots, &ScanState))| {
        let sums = sums(knots, state);
        let (mut best, mut span) = (0.0, (0, 0));
        for from in 0..knots.len() {
            for to in from + 1..=knots.len() {
                let score = sums.score[to] - sums.score[from];
                let chi_square = (whitener(sums.gram(from, to)) * score).norm_squared();
                if chi_square > best {
                    (best, span) = (chi_square, (from, to));
                }
            }
        }
        let times = (knots.edges[span.0], knots.edges[span.1]);
        Piece { episode: e, knots: span, span: times, chi_square: best, strength: 0.0 }
    };
    let indexed: Vec<_> = knots.iter().zip(states).enumerate().collect();
    let all: Vec<Piece> = indexed.into_par_iter().map(of).collect();
    let valid = all.into_iter().filter(|p| p.chi_square > 0.0 && score_test.free_directions() > 0);
    valid.max_by(|a, b| a.chi_square.total_cmp(&b.chi_square))
}

/// Projects a piece out of the state of every episode; `false` if nothing is to be projected out.
fn project_out(knots: &[Knots], states: &mut [ScanState], piece: &Piece) -> bool {
    let (from, to) = piece.knots;
    let own = &knots[piece.episode];
    let sums = sums(own, &states[piece.episode]);
    let whitener = whitener(sums.gram(from, to));
    let unit = whitener * (sums.score[to] - sums.score[from]);
    let products = &sums.explained[to] - &sums.explained[from];
    if unit.norm_squared() <= 0.0 {
        return false;
    }
    for (e, (episode, state)) in knots.iter().zip(states).enumerate() {
        let mut products = -(&state.explained * products.transpose());
        if e == piece.episode {
            for k in from..to {
                products += episode.gram.columns(COMPONENTS * k, COMPONENTS);
            }
        }
        let products = products * whitener.transpose();
        state.score -= &products * unit;
        let n = state.explained.ncols();
        let mut wider = state.explained.clone().resize_horizontally(n + COMPONENTS, 0.0);
        wider.columns_mut(n, COMPONENTS).copy_from(&products);
        state.explained = wider;
    }
    true
}

/// Number of independent windows for which the smallest p-value has the distribution of draws under the null
/// hypothesis.
fn independent_window_count(score_test: &ScoreTest, knots: &[Knots], seed: u64) -> f64 {
    let prepared: Vec<Vec<Matrix3<f64>>> = knots.par_iter().map(whiteners).collect();
    let tails: Vec<f64> = (0..BOOTSTRAP_DRAWS)
        .into_par_iter()
        .map(|draw| {
            let largest = null_maximum(score_test, knots, &prepared, seed, draw);
            10f64.powf(-minus_log10_p(largest, score_test.free_directions()))
        })
        .collect();
    let mean = tails.iter().sum::<f64>() / tails.len() as f64;
    mean.recip().max(1.0)
}

/// Whiteners of all windows in the order of the scan.
fn whiteners(knots: &Knots) -> Vec<Matrix3<f64>> {
    let state = ScanState { score: knots.score.clone(), explained: knots.nominal.clone() };
    let sums = sums(knots, &state);
    let windows = (0..knots.len()).flat_map(|from| (from + 1..=knots.len()).map(move |to| (from, to)));
    windows.map(|(from, to)| whitener(sums.gram(from, to))).collect()
}

fn null_maximum(
    score_test: &ScoreTest,
    knots: &[Knots],
    prepared: &[Vec<Matrix3<f64>>],
    seed: u64,
    draw: u64,
) -> f64 {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(draw + 1);
    let noise: Vec<DVector<f64>> = score_test
        .episodes
        .iter()
        .map(|episode| {
            let silent = |k: usize| episode.response.innovations[k] == 0.0;
            DVector::from_fn(episode.innovations.len(), |k, _| {
                let value: f64 = rng.sample(StandardNormal);
                if silent(k) { 0.0 } else { value }
            })
        })
        .collect();
    let mut products = DVector::zeros(score_test.nominal_dimension());
    for (episode, noise) in score_test.episodes.iter().zip(&noise) {
        products += episode.nominal.tr_mul(noise);
    }
    let mut largest = 0.0f64;
    for ((knots, noise), whiteners) in knots.iter().zip(&noise).zip(prepared) {
        let score = knots.responses.tr_mul(noise) - &knots.nominal * &products;
        let state = ScanState { score, explained: DMatrix::zeros(COMPONENTS * knots.len(), 0) };
        let (sums, _) = prefix_sums(&state, knots.len() + 1);
        let mut whitener = whiteners.iter();
        for from in 0..knots.len() {
            for to in from + 1..=knots.len() {
                let Some(whitener) = whitener.next() else { break };
                largest = largest.max((whitener * (sums[to] - sums[from])).norm_squared());
            }
        }
    }
    largest
}

/// Merges adjacent pieces into windows, in order of time.
pub(crate) fn windows(
    pieces: &[Piece],
    names: &[String],
    windows: f64,
    free_directions: usize,
) -> Vec<Window> {
    let mut sorted: Vec<&Piece> = pieces.iter().collect();
    sorted.sort_by(|a, b| {
        (a.episode, a.span.0).partial_cmp(&(b.episode, b.span.0)).unwrap_or(std::cmp::Ordering::Equal)
    });
    let mut groups: Vec<(usize, (f64, f64), Vec<&Piece>)> = Vec::new();
    for piece in sorted {
        match groups.last_mut() {
            Some((episode, span, group))
                if *episode == piece.episode && piece.span.0 - span.1 <= MAX_WINDOW_GAP_S =>
            {
                span.1 = span.1.max(piece.span.1);
                group.push(piece);
            }
            _ => groups.push((piece.episode, piece.span, vec![piece])),
        }
    }
    let merged = |(episode, (start, end), group): (usize, (f64, f64), Vec<&Piece>)| Window {
        episode: names.get(episode).cloned().unwrap_or_default(),
        start,
        end,
        strength: combined_strength(&group, windows, free_directions),
    };
    groups.into_iter().map(merged).collect()
}

/// Strength of several pieces together: the sum of the χ² that each adds.
fn combined_strength(group: &[&Piece], windows: f64, free_directions: usize) -> f64 {
    let chi_square = group.iter().map(|p| p.chi_square).sum();
    let count = group.len();
    let all = minus_log10_p(chi_square, free_directions * count) - count as f64 * windows.log10();
    group.iter().map(|p| p.strength).fold(all, f64::max)
}
