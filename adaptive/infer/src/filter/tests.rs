//! Filters with fewer states and derivatives agree with the full filter.

use super::*;
use crate::sensitivity::tests::{NOISE, nominal, track};
use trundle_model::{Effect, Kind};

#[test]
fn fewer_states_and_derivatives_give_the_same_result() {
    let caster = (Kind::CasterSwivel, &[0.4, 0.3, 0.05, 60.0][..]);
    for effects in [
        vec![(Kind::ComOffset, &[0.13, -0.07][..]), (Kind::Latency, &[0.02])],
        vec![(Kind::FloorSlope, &[0.05, -0.02])],
        vec![caster, (Kind::TrackerOffset, &[0.05, -0.03, 0.2]), (Kind::GripperInertia, &[1.7])],
        vec![caster, (Kind::FloorSlope, &[0.05, -0.02])],
    ] {
        let model = effects.iter().fold(nominal(), |model, (kind, _)| model.with(Effect::free(*kind)));
        let wheel = [22.0, -0.3, 0.1, 0.3, 18.0, 90.0].into_iter();
        let values: Vec<f64> = wheel.chain(effects.iter().flat_map(|(_, own)| own.to_vec())).collect();
        let channels = Channels::of(&NOISE);
        let fullest =
            Filter::<STATES, STATES>::new(&model, &values, &channels, model.plant(&values).unwrap());
        let [fewest, fullest] = [filter(&model, &values, &channels).unwrap(), Box::new(fullest.unwrap())]
            .map(|f| f.run(&track()));
        let [fewest, fullest] = [fewest.unwrap(), fullest.unwrap()];
        assert!((fewest.cost() - fullest.cost()).abs() < 1e-8 * fullest.cost().abs(), "{effects:?}");
        for (few, full) in fewest.innovations.iter().zip(&fullest.innovations) {
            assert!((few.gain - full.gain).norm() < 1e-8 * full.gain.norm(), "{effects:?}");
        }
    }
}
