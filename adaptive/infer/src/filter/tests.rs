//! A filter with no more states and derivatives than a model needs finds what the fullest one finds.

use super::*;
use trundle_model::{Body, Effect, Kind};
use trundle_record::{Counts, Noise, PoseSample, Prepared, WrenchSample};

const NOISE: Noise = Noise { pose: [1e-3; 3], force: 0.4, torque: 0.05, time: 0.0, stated: true };

/// A push to and fro of a table that turns.
fn track() -> Track {
    let wrench = |k: usize| {
        let t = k as f64 * 0.01;
        let reading = [20.0 * (3.0 * t).sin(), 9.0 * (5.0 * t).cos(), (4.0 * t).sin()];
        WrenchSample { t, reading, frame: [-0.6, 0.1, 0.2], ..Default::default() }
    };
    let pose = |k: usize| {
        let t = k as f64 * 0.02;
        PoseSample { t, pose: [0.2 * t * t, 0.1 * t, 0.5 * t] }
    };
    let episode = Prepared {
        name: "push".to_owned(),
        wrench: (0..200).map(wrench).collect(),
        pose: (0..100).map(pose).collect(),
        tare_sd: [0.04; 3],
        at_rest: true,
        counts: Counts::default(),
        ..Default::default()
    };
    Track::new(&episode, &NOISE).unwrap()
}

#[test]
fn fewer_states_and_derivatives_find_the_same() {
    let caster = (Kind::CasterSwivel, &[0.4, 0.3, 0.05, 60.0][..]);
    for effects in [
        vec![(Kind::ComOffset, &[0.13, -0.07][..]), (Kind::Latency, &[0.02])],
        vec![(Kind::FloorSlope, &[0.05, -0.02])],
        vec![caster, (Kind::TrackerOffset, &[0.05, -0.03, 0.2]), (Kind::GripperInertia, &[1.7])],
        vec![caster, (Kind::FloorSlope, &[0.05, -0.02])],
    ] {
        let body = Body::from_footprint(&[[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]], 22.0);
        let nominal = Model::nominal(body.unwrap(), None, [true; 3]);
        let model = effects.iter().fold(nominal, |model, (kind, _)| model.with(Effect::free(*kind)));
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
