//! One step of a simulation under a wrench reading.

use crate::curve::Curve;
use crate::timing::Timing;
use crate::track::Step;
use trundle_model::{Clock, Plant, Precision, Real, State, transport};

/// Advances a state by one step under a reading with an error.
#[inline]
pub(crate) fn advance<T: Real>(
    plant: &Plant<T>,
    state: &mut State<T>,
    error: &[T; 3],
    step: &Step,
    curve: &Curve,
) {
    let (applied, clock) = applied_wrench(plant, error, step, curve);
    plant.step_with_precision(Precision::Fit, state, &applied, clock, step.dt);
}

/// Mean wrench on the object over a step, object axes about its origin, for readings with the additional
/// error `error`; and the clock of the reading, since a late reading also shows contact late.
pub(crate) fn applied_wrench<T: Real>(
    plant: &Plant<T>,
    error: &[T; 3],
    step: &Step,
    curve: &Curve,
) -> ([T; 3], Clock) {
    let timing = Timing::of(plant, step.clock);
    let [x, y, torque] = match &timing {
        None => step.reading.map(T::lift),
        timing => step.reading(curve, timing.as_ref()),
    };
    let less = |read: T, error: T| T::chained(read.re() - error.re(), [(read, 1.0), (error, -1.0)]);
    let reading = [less(x, error[0]), less(y, error[1]), less(torque, error[2])];
    let since_contact = step.clock.since_contact + timing.map_or(0.0, |timing| timing.delay());
    let clock = Clock { since_contact, ..step.clock };
    (transport(plant.correct(reading, clock), step.frame), clock)
}
