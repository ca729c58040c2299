//! From a scenario to a recording.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use trundle_model::{Body, Clock, Fixture, MAX_INNER_STATES, Model};
use trundle_record::{
    Contact, Dof, FORMAT, FixtureMeta, Frame, Metadata, NoiseMeta, ObjectMeta, Obstacle, Precontact,
    Recording, Sign, Source, Split, WrenchMeta,
};

use crate::instruments::episode;
use crate::push::Setting;
use crate::{Drive, Push, Scenario, Sensor, SimError, Tracker};

/// The recording of a scenario. The same seed gives the same recording.
///
/// # Errors
/// When the model is not complete or a shape is no polygon.
pub fn simulate(scenario: &Scenario, model: &Model, seed: u64) -> Result<Recording, SimError> {
    let obstacles: Vec<_> = scenario.obstacles.iter().map(|o| o.polygon.clone()).collect();
    let setting = Setting {
        model,
        obstacles: &obstacles,
        step: scenario.step,
        coupling: scenario.gripper,
        sensor: scenario.sensor,
        tracker: scenario.tracker,
    };
    let pushes = pushes(scenario, model, seed);
    let contact = contact(&pushes)?;
    let mut episodes = vec![];
    for (index, push) in pushes.iter().enumerate() {
        let inner = beginning(model, &mut stream(seed, Purpose::Inner, index));
        let rows = setting.run_from(index, push, inner, stream(seed, Purpose::Noise, index))?;
        episodes.push(episode(format!("episode_{index:02}"), &rows));
    }
    let names = episodes.iter().map(|e| e.name.clone());
    let held_out = names.skip(episodes.len() - scenario.held_out).collect();
    let sensor = quiet(&scenario.sensor, model)?;
    let mut metadata = metadata(&scenario.name, &model.body, scenario.weighed, &sensor, &scenario.tracker);
    metadata.wrench.contact = contact;
    metadata.scene.obstacles = obstacles.into_iter().map(|polygon| Obstacle { polygon }).collect();
    metadata.split = Split { held_out };
    Ok(Recording::new(metadata, episodes)?)
}

/// The sensor, unloaded for as long as its own clock says.
fn quiet(sensor: &Sensor, model: &Model) -> Result<Sensor, SimError> {
    let ahead = model.resolved()?.delay(Clock::since_contact(0.0)).map_or(0.0, |delay| (-delay).max(0.0));
    let precontact = sensor.precontact - ahead;
    if ahead > 0.0 && precontact < SHORTEST_TARE {
        let remedy = "the reading runs ahead of the contact's beginning: lengthen `sensor.precontact`";
        return Err(SimError::value("latency.delay", -ahead, remedy));
    }
    Ok(Sensor { precontact, ..*sensor })
}

/// A recording says once how the object is touched.
fn contact(pushes: &[Push]) -> Result<Contact, SimError> {
    let tips = pushes.iter().filter(|push| push.drive == Drive::Tip).count();
    match tips {
        0 => Ok(Contact::Grasp),
        _ if tips == pushes.len() => Ok(Contact::Point),
        _ => {
            Err(SimError::value("push.drive", "tip", "must be that of all pushes of a recording or of none"))
        }
    }
}

/// Time that a tare needs, s.
const SHORTEST_TARE: f64 = 0.1;

fn pushes(scenario: &Scenario, model: &Model, seed: u64) -> Vec<Push> {
    let mut pushes = scenario.pushes.clone();
    if let Some(random) = &scenario.random {
        let draw = |k| random.draw(&model.body, &mut stream(seed, Purpose::Push, k));
        pushes.extend((0..random.count).map(draw));
    }
    pushes
}

/// Where the laws' own states begin: nobody knows how a caster stands, so that is drawn; a load hangs still.
pub(crate) fn beginning(model: &Model, random: &mut ChaCha8Rng) -> [f64; MAX_INNER_STATES] {
    let mut start = [0.0; MAX_INNER_STATES];
    for (value, inner) in start.iter_mut().zip(model.inner()) {
        let any = random.random_range(0..inner.starts.len().max(1));
        let around: f64 = random.sample(StandardNormal);
        let known = inner.starts.len() < 2;
        *value = inner.starts.get(any).map_or(0.0, |s| if known { *s } else { s + inner.sd * around });
    }
    start
}

/// What a stream of random numbers is for; each episode has its own of each.
#[derive(Clone, Copy)]
enum Purpose {
    Push,
    Noise,
    Inner,
}

/// Streams of the first two purposes take turns; the third's lie beyond any number of episodes.
const BEYOND: u64 = 1 << 40;

fn stream(seed: u64, purpose: Purpose, episode: usize) -> ChaCha8Rng {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    random.set_stream(match purpose {
        Purpose::Push | Purpose::Noise => 2 * episode as u64 + purpose as u64,
        Purpose::Inner => BEYOND + episode as u64,
    });
    random
}

/// What a recording says of the object and the instruments; nothing of what is hidden.
pub fn metadata(name: &str, body: &Body, weighed: bool, sensor: &Sensor, tracker: &Tracker) -> Metadata {
    Metadata {
        format: FORMAT.to_owned(),
        name: name.to_owned(),
        at_rest: true,
        object: object(body, weighed),
        wrench: WrenchMeta {
            frame: Frame::Sensor,
            reference: None,
            sign: Sign::OnObject,
            raw: true,
            precontact: Some(Precontact::Everywhere([0.0, sensor.precontact])),
            contact: Contact::Grasp,
            source: Source::Measured,
            gripper_mass: sensor.gripper.map(|gripper| gripper.mass),
            gripper_com: sensor.gripper.map(|gripper| gripper.com),
        },
        noise: noise(sensor, tracker),
        scene: Default::default(),
        split: Default::default(),
        notes: toml::Table::new(),
    }
}

/// Stated only where every instrument is noisy: a recording has no word for none.
fn noise(sensor: &Sensor, tracker: &Tracker) -> Option<NoiseMeta> {
    let all = sensor.noise().into_iter().chain(tracker.noise);
    let noise = NoiseMeta {
        pose: tracker.noise,
        force: sensor.force_noise,
        torque: Some(sensor.torque_noise),
        time: 0.0,
    };
    (all.fold(f64::INFINITY, f64::min) > 0.0).then_some(noise)
}

fn object(body: &Body, weighed: bool) -> ObjectMeta {
    let mut object = ObjectMeta {
        footprint: vec![],
        mass: weighed.then_some(body.mass),
        support: body.feet.clone().unwrap_or_default(),
        dof: Dof::all(),
        fixtures: vec![],
    };
    match body.fixtures.as_slice() {
        [Fixture::Polygon { vertices, .. }] => object.footprint = vertices.clone(),
        fixtures => object.fixtures = fixtures.iter().map(fixture).collect(),
    }
    object
}

fn fixture(fixture: &Fixture) -> FixtureMeta {
    match fixture {
        Fixture::Polygon { vertices, density } => {
            FixtureMeta { polygon: Some(vertices.clone()), disc: None, density: *density }
        }
        Fixture::Disc { center: [x, y], radius, density } => {
            FixtureMeta { polygon: None, disc: Some([*x, *y, *radius]), density: *density }
        }
    }
}
