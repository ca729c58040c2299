//! How late the readings are, over the whole recording and over each episode.
//!
//! For lags the law is linear without bounds: any body, damping and friction, so that what a bound would exclude is
//! not taken for a delay.

use nalgebra::{Cholesky, DVector, Dyn};

use super::dynamics::{Blocks, Linear, Moments, Readings, WINDOWS};

/// Lags tried on either side.
const STEPS: usize = 50;
/// Relative ridge, for motion that lacks some axis.
const RIDGE: f64 = 1e-9;
/// Rounds of lags by window and law in turn.
const ROUNDS: usize = 6;
/// Drifts tried on either side.
const DRIFTS: usize = 25;

/// Lags of a recording, s; positive where the reading runs late.
#[derive(Debug, Clone)]
pub(crate) struct Lag {
    /// One for all, and its standard deviation.
    pub constant: (f64, f64),
    /// Unexplained share without any lag, with the constant one, with a drift, with a jump in each episode.
    pub share: [f64; 4],
    /// Drift, s/s.
    pub drift: f64,
    /// Of each episode: lag before and after the jump, and the first window after it (0 if there is no jump).
    pub jumps: Vec<Jump>,
    /// What the other checks use: the constant lag, or that of the drift or jumps, where these explain much more.
    pub by_window: Vec<f64>,
    /// Distance of the lags tried, s.
    pub step: f64,
}

/// An episode's own lags.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Jump {
    pub before: f64,
    pub after: f64,
    pub window: usize,
    /// Square of what stays unexplained with the common lag over that with the own ones.
    pub gain: f64,
}

/// Drift or jumps must leave less than this share of what a constant lag leaves to be used.
const VARIES: f64 = 0.6;
/// A constant lag must leave less than this share of what is unexplained without it.
pub(crate) const HELPS: f64 = 0.85;

/// Right sides and squares of each window at each lag, over one factorised law.
struct Grid {
    lags: Vec<f64>,
    /// `[lag][window]`
    right: Vec<Vec<DVector<f64>>>,
    total: Vec<Vec<f64>>,
    windows: Vec<Moments>,
}

impl Grid {
    fn new(blocks: &Blocks, readings: &Readings, change: &Linear) -> Self {
        let step = blocks.range / STEPS as f64;
        let lags: Vec<f64> = (0..=2 * STEPS).map(|k| (k as f64 - STEPS as f64) * step).collect();
        let (mut right, mut total) = (vec![], vec![]);
        for lag in &lags {
            let (r, t) = blocks.loads(readings, *lag).iter().map(|m| m.changed(change)).unzip();
            right.push(r);
            total.push(t);
        }
        Self { lags, right, total, windows: blocks.moments(readings, 0.0) }
    }

    fn solver(&self, without: Option<usize>) -> Option<Solver> {
        let kept = self.windows.iter().enumerate().filter(|(w, _)| Some(w / WINDOWS) != without);
        Solver::new(&Moments::sum(kept.map(|(_, m)| m)))
    }

    /// Right side and square over all windows, the lag of each by its index; without those of one episode.
    fn sides(&self, lag: impl Fn(usize) -> usize, without: Option<usize>) -> (DVector<f64>, f64) {
        let mut right = DVector::zeros(self.right[0][0].len());
        let mut total = 0.0;
        for w in (0..self.windows.len()).filter(|w| Some(w / WINDOWS) != without) {
            right += &self.right[lag(w)][w];
            total += self.total[lag(w)][w];
        }
        (right, total)
    }

    /// Unexplained share at each common lag.
    fn shares(&self, without: Option<usize>) -> Option<Vec<f64>> {
        let solver = self.solver(without)?;
        Some((0..self.lags.len()).map(|k| solver.share(&self.sides(|_| k, without))).collect())
    }

    /// Unexplained square of window `w` at lag `k` under a law.
    fn square(&self, law: &DVector<f64>, own: f64, k: usize, w: usize) -> f64 {
        self.total[k][w] - 2.0 * self.right[k][w].dot(law) + own
    }

    fn step(&self) -> f64 {
        self.lags[1] - self.lags[0]
    }
}

/// A factorised law.
struct Solver {
    cholesky: Cholesky<f64, Dyn>,
    scale: DVector<f64>,
}

impl Solver {
    fn new(moments: &Moments) -> Option<Self> {
        let mut normal = moments.normal.clone();
        let least = 1e-12 * normal.diagonal().amax();
        let scale = normal.diagonal().map(|d| d.max(least).max(f64::MIN_POSITIVE).sqrt());
        for i in 0..scale.len() {
            (0..scale.len()).for_each(|j| normal[(i, j)] /= scale[i] * scale[j]);
            normal[(i, i)] += RIDGE;
        }
        Some(Self { cholesky: normal.cholesky()?, scale })
    }

    fn law(&self, right: &DVector<f64>) -> DVector<f64> {
        self.cholesky.solve(&right.component_div(&self.scale)).component_div(&self.scale)
    }

    fn share(&self, (right, total): &(DVector<f64>, f64)) -> f64 {
        if *total > 0.0 { (1.0 - self.law(right).dot(right) / total).max(0.0) } else { 1.0 }
    }
}

/// Index of the least value.
fn least(values: &[f64]) -> usize {
    (0..values.len()).min_by(|&a, &b| values[a].total_cmp(&values[b])).unwrap_or(0)
}

/// The least point of the parabola through the least value and its neighbours: its place in steps, and its value.
fn vertex(values: &[f64]) -> (f64, f64) {
    let k = least(values);
    if k == 0 || k + 1 == values.len() {
        return (k as f64, values[k]);
    }
    let (a, b, c) = (values[k - 1], values[k], values[k + 1]);
    let bend = a - 2.0 * b + c;
    if bend <= 0.0 {
        return (k as f64, b);
    }
    let shift = 0.5 * (a - c) / bend;
    (k as f64 + shift, b - 0.5 * bend * shift * shift)
}

/// The common lag that suits best, s.
pub(crate) fn constant(blocks: &Blocks, readings: &Readings, change: &Linear) -> f64 {
    let grid = Grid::new(blocks, readings, change);
    let Some(shares) = grid.shares(None) else { return 0.0 };
    (vertex(&shares).0 - STEPS as f64) * grid.step()
}

/// Constant lag, drift and jumps.
pub(crate) fn lag(blocks: &Blocks, readings: &Readings, change: &Linear) -> Lag {
    let grid = Grid::new(blocks, readings, change);
    let windows = grid.windows.len();
    let none = Lag {
        constant: (0.0, f64::INFINITY),
        share: [1.0; 4],
        drift: 0.0,
        jumps: vec![],
        by_window: vec![0.0; windows],
        step: grid.step(),
    };
    let (Some(shares), Some(solver)) = (grid.shares(None), grid.solver(None)) else { return none };
    let at = least(&shares);
    let to_time = |k: f64| (k - STEPS as f64) * grid.step();
    let (drift, drifting) = drift(&grid, &solver, at);
    let (jumps, jumping) = jumps(&grid, &solver, at);
    let share = |lag: &[usize]| solver.share(&grid.sides(|w| lag[w], None));
    let (lag, lagging) = vertex(&shares);
    let share = [shares[STEPS], lagging, share(&drifting), share(&jumping)];
    let constant = (to_time(lag), sd(&grid));
    let by_window = if share[2].min(share[3]) > VARIES * shares[at] {
        vec![if lagging < HELPS * shares[STEPS] { lag } else { 0.0 }; windows]
    } else {
        let used = if share[2] < share[3] { drifting } else { jumping };
        used.iter().map(|&k| grid.lags[k]).collect()
    };
    Lag { constant, share, drift, jumps, by_window, step: grid.step() }
}

/// Standard deviation of the common lag, by leaving out each episode in turn.
fn sd(grid: &Grid) -> f64 {
    let episodes = grid.windows.len() / WINDOWS;
    if episodes < 2 {
        return grid.step();
    }
    let lags: Vec<f64> =
        (0..episodes).filter_map(|e| Some(vertex(&grid.shares(Some(e))?).0 * grid.step())).collect();
    let n = lags.len() as f64;
    let mean = lags.iter().sum::<f64>() / n;
    ((n - 1.0) / n * lags.iter().map(|l| (l - mean) * (l - mean)).sum::<f64>()).sqrt()
}

/// The law, and the own square of each window under it.
fn law_of(grid: &Grid, solver: &Solver, lag: &[usize]) -> (DVector<f64>, Vec<f64>) {
    let law = solver.law(&grid.sides(|w| lag[w], None).0);
    let own = grid.windows.iter().map(|m| law.dot(&(&m.normal * &law))).collect();
    (law, own)
}

/// The drift that suits best, s/s of an episode in steps of the grid by window, and the lag of each window.
fn drift(grid: &Grid, solver: &Solver, at: usize) -> (f64, Vec<usize>) {
    let n = grid.windows.len();
    let top = grid.lags.len() - 1;
    let index = |start: usize, slope: f64, w: usize| {
        let k = start as f64 + slope * ((w % WINDOWS) as f64 - (WINDOWS as f64 - 1.0) / 2.0);
        (k.round().max(0.0) as usize).min(top)
    };
    let slopes: Vec<f64> = (0..=2 * DRIFTS).map(|k| (k as f64 - DRIFTS as f64) / 2.0).collect();
    let mut found = (0.0, vec![at; n]);
    for _ in 0..ROUNDS {
        let (law, own) = law_of(grid, solver, &found.1);
        let square = |start: usize, slope: f64| {
            (0..n).map(|w| grid.square(&law, own[w], index(start, slope, w), w)).sum::<f64>()
        };
        let all = slopes.iter().flat_map(|&slope| (0..=top).map(move |start| (start, slope)));
        let best = all.min_by(|a, b| square(a.0, a.1).total_cmp(&square(b.0, b.1)));
        let Some((start, slope)) = best else { break };
        found = (slope * grid.step(), (0..n).map(|w| index(start, slope, w)).collect());
    }
    found
}

/// The jump in each episode that suits best, and the lag of each window.
fn jumps(grid: &Grid, solver: &Solver, at: usize) -> (Vec<Jump>, Vec<usize>) {
    let n = grid.windows.len();
    let mut lag = vec![at; n];
    let mut jumps = vec![];
    for _ in 0..ROUNDS {
        let (law, own) = law_of(grid, solver, &lag);
        jumps.clear();
        for first in (0..n).step_by(WINDOWS) {
            let over = |from: usize, to: usize| {
                let square = |k: usize| {
                    (first + from..first + to).map(|w| grid.square(&law, own[w], k, w)).sum::<f64>()
                };
                let squares: Vec<f64> = (0..grid.lags.len()).map(square).collect();
                let k = least(&squares);
                (k, squares[k], squares[at])
            };
            let whole = over(0, WINDOWS);
            let splits = (1..WINDOWS).map(|k| (k, over(0, k), over(k, WINDOWS)));
            let best = splits.min_by(|a, b| (a.1.1 + a.2.1).total_cmp(&(b.1.1 + b.2.1)));
            let Some((window, before, after)) = best else { continue };
            let (window, before, after, square) = if before.1 + after.1 < VARIES * whole.1 {
                (window, before.0, after.0, before.1 + after.1)
            } else {
                (0, whole.0, whole.0, whole.1)
            };
            for w in 0..WINDOWS {
                lag[first + w] = if w < window { before } else { after };
            }
            let gain = whole.2.max(0.0) / square.max(f64::MIN_POSITIVE);
            jumps.push(Jump { before: grid.lags[before], after: grid.lags[after], window, gain });
        }
    }
    (jumps, lag)
}
