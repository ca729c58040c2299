//! Point masses on a body with which a residual is smallest: starting points for a payload.
//!
//! At a given place, the equations of all joints are linear in the mass, and nearly linear in the parameters of the mechanism.
//! The latter matter: without the payload, the refitted masses of the links take up much of it, and a fit that starts from
//! there may end far from the optimum.

use crate::fit::{Fit, moved};
use crate::model::{Effect, Kind};
use crate::prior::Prior;
use crate::problem::Problem;
use crate::rows::{Scope, evaluate, normal_equations};
use crate::slots::slots;
use nalgebra::{DMatrix, DVector};

/// Places from which fits start.
const MAX_PLACES: usize = 3;
/// Steps of the grid of places from the origin of the body to the farthest one.
const GRID_STEPS: i32 = 10;

/// Values of the best payloads, each with the values of the model's other parameters.
pub(crate) fn best_point_masses(problem: &Problem, parent: &Fit, body: usize) -> Vec<(Vec<f64>, Fit)> {
    let farthest = problem.farthest_payload[body];
    let Some(system) = System::new(problem, parent, body, farthest) else { return vec![] };
    let range = || -GRID_STEPS..=GRID_STEPS;
    let grid = range().flat_map(|x| range().flat_map(move |y| range().map(move |z| [x, y, z])));
    let gain = |place: [i32; 3]| (system.gain(place.map(|k| f64::from(k) / f64::from(GRID_STEPS))), place);
    let mut all: Vec<(f64, [i32; 3])> = grid.map(gain).filter(|(gain, _)| *gain > 0.0).collect();
    all.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut best: Vec<[i32; 3]> = vec![];
    for (_, place) in all {
        let is_near = |other: &[i32; 3]| (0..3).all(|k| (place[k] - other[k]).abs() <= GRID_STEPS / 3);
        if !best.iter().any(is_near) {
            best.push(place);
        }
        if best.len() == MAX_PLACES {
            break;
        }
    }
    let start = |place: [i32; 3]| {
        let place = place.map(|k| f64::from(k) / f64::from(GRID_STEPS));
        let (mass, step) = system.solution(place);
        let values = moved(&parent.slots, &parent.values, &step);
        ([&[mass][..], &place.map(|x| farthest * x)].concat(), Fit { values, ..parent.clone() })
    };
    best.into_iter().map(start).collect()
}

/// The normal equations of a model with point masses at ten places of a body, which determine those of every place: the
/// effort of a unit mass is a polynomial of second degree in its place.
struct System {
    /// Inverse of the matrix of the model's own parameters.
    inverse: DMatrix<f64>,
    /// Right-hand side of the same.
    right: DVector<f64>,
    /// Products of the model's own parameters and the masses.
    mixed: DMatrix<f64>,
    /// Matrix and right-hand side of the masses after the best change of the model's own parameters.
    reduced: (DMatrix<f64>, DVector<f64>),
    /// Precision of the prior of the mass.
    precision: f64,
}

impl System {
    fn new(problem: &Problem, parent: &Fit, body: usize, farthest: f64) -> Option<Self> {
        let mut effects = parent.fitted_effects();
        let nodes = nodes().map(|place| Effect {
            kind: Kind::Payload(body),
            values: [&[0.0][..], &place.map(|x| farthest * x)].concat(),
        });
        effects.extend(nodes);
        let own = parent.slots.len();
        let all = slots(problem, &effects);
        let masses = all[own..].iter().filter(|slot| slot.name.ends_with(".mass"));
        let precision = masses.clone().next()?.prior.sd().powi(-2);
        let flat = masses.map(|slot| crate::model::Slot { prior: Prior::Flat, ..slot.clone() });
        let kept: Vec<_> = parent.slots.iter().cloned().chain(flat).collect();
        let values: Vec<f64> = [&parent.values[..], &vec![0.0; kept.len() - own]].concat();
        let rows = evaluate(problem, &effects, &kept, &values, Scope::Training, true);
        let (matrix, right) = normal_equations(&rows, &parent.sd, &kept, &values, &|_| true);
        let count = kept.len() - own;
        let block = matrix.view((0, 0), (own, own));
        let scale = DVector::from_fn(own, |k, _| block[(k, k)].max(f64::MIN_POSITIVE).sqrt().recip());
        let scaled = DMatrix::from_fn(own, own, |i, k| block[(i, k)] * scale[i] * scale[k]);
        let inverse = scaled.cholesky()?.inverse();
        let inverse = DMatrix::from_fn(own, own, |i, k| inverse[(i, k)] * scale[i] * scale[k]);
        let mixed = matrix.view((0, own), (own, count)).into_owned();
        let (own_right, mass_right) = (right.rows(0, own).into_owned(), right.rows(own, count).into_owned());
        let square = matrix.view((own, own), (count, count)) - mixed.tr_mul(&(&inverse * &mixed));
        let slope = mass_right - mixed.tr_mul(&(&inverse * &own_right));
        Some(Self { inverse, right: own_right, mixed, reduced: (square, slope), precision })
    }

    /// Sizes of the equation of a mass at a place: its coefficient, and the right-hand side.
    fn equation(&self, place: [f64; 3]) -> [f64; 2] {
        let (weights, (square, slope)) = (shares(place), &self.reduced);
        [weights.dot(&(square * &weights)).max(0.0) + self.precision, weights.dot(slope)]
    }

    /// Decrease of the cost by the best mass at a place, nats; negative if it were negative.
    fn gain(&self, place: [f64; 3]) -> f64 {
        let [square, slope] = self.equation(place);
        0.5 * slope * slope.abs() / square - 0.5 * place.iter().map(|x| x * x).sum::<f64>()
    }

    /// The best mass at a place, and the change of the model's own parameters.
    fn solution(&self, place: [f64; 3]) -> (f64, DVector<f64>) {
        let [square, slope] = self.equation(place);
        let mass = slope / square;
        (mass, &self.inverse * (&self.right - &self.mixed * shares(place) * mass))
    }
}

/// Places that determine a polynomial of second degree.
fn nodes() -> impl Iterator<Item = [f64; 3]> {
    let along = |k: usize, x: f64| [0, 1, 2].map(|axis| if axis == k { x } else { 0.0 });
    let single = (0..3).flat_map(move |k| [along(k, 1.0), along(k, -1.0)]);
    std::iter::once([0.0; 3]).chain(single).chain([[1.0, 1.0, 0.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]])
}

/// Shares of the nodes in a polynomial's value at a place.
fn shares([x, y, z]: [f64; 3]) -> DVector<f64> {
    let plus = |a: f64, b: f64, c: f64| 0.5 * a * (a + 1.0) - a * (b + c);
    let minus = |a: f64| 0.5 * a * (a - 1.0);
    let centre = 1.0 - (x * x + y * y + z * z) + x * y + x * z + y * z;
    let single = [plus(x, y, z), minus(x), plus(y, x, z), minus(y), plus(z, x, y), minus(z)];
    DVector::from_iterator(10, std::iter::once(centre).chain(single).chain([x * y, x * z, y * z]))
}

#[cfg(test)]
mod tests {
    use super::{nodes, shares};

    #[test]
    fn nodes_determine_a_polynomial_of_second_degree() {
        let of = |[x, y, z]: [f64; 3]| {
            0.7 - 0.2 * x + 1.1 * y + 0.4 * z + 2.0 * x * x - y * y + 0.3 * z * z - 0.6 * x * y
                + 0.9 * x * z
                + y * z
        };
        let known: Vec<f64> = nodes().map(of).collect();
        for place in [[0.3, -0.8, 0.5], [-1.2, 0.1, 0.9], [0.0, 1.0, 1.0]] {
            let value: f64 = shares(place).iter().zip(&known).map(|(share, value)| share * value).sum();
            assert!((value - of(place)).abs() < 1e-12, "{place:?}: {value} {}", of(place));
        }
    }
}
