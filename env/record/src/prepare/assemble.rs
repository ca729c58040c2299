//! Assembly of a dataset from a recording.

use trundle_model::Body;

use crate::error::{Error, Place};
use crate::fault::Fault;
use crate::metadata::{Contact, Dof, Metadata, Source};
use crate::motion::MotionCache;
use crate::recording::Recording;

use super::dataset::{Counts, Dataset, Prepared, REST_MARGIN_S};
use super::noise::Noise;
use super::options::Options;
use super::reading::{MaskedStreams, Reader, Readings};
use super::samples::{PoseSample, WrenchSample};
use super::track::{PoseNoise, gaps};
use super::{contact, mass, noise};

pub(crate) fn dataset(recording: &Recording, options: Options) -> Result<Dataset, Error> {
    let meta = &recording.metadata;
    let noise = noise::stated_or_estimated(recording);
    let pose_noise = PoseNoise { sd: noise.pose, estimated: noise::estimated_pose(recording) };
    let masked = |e| MaskedStreams::new(e, &pose_noise, &noise, options.wrench_pose);
    let streams: Vec<MaskedStreams> = recording.episodes.iter().map(masked).collect::<Result<_, _>>()?;
    let reader = Reader::new(meta, options, &streams)?;
    let prepared: Vec<Prepared> = streams
        .into_iter()
        .enumerate()
        .map(|(k, streams)| episode(&reader, streams, k, meta, &noise))
        .collect::<Result<_, _>>()?;
    let (held_out, training): (Vec<_>, Vec<_>) =
        prepared.into_iter().partition(|episode| meta.is_held_out(&episode.name));
    let guess = meta.object.mass.unwrap_or_else(|| mass::guess(&training, &noise));
    Ok(Dataset {
        name: meta.name.clone(),
        body: body(meta, guess)?,
        dof: [Dof::X, Dof::Y, Dof::Theta].map(|dof| meta.object.dof.contains(&dof)),
        noise,
        point_contact: meta.wrench.contact == Contact::Point,
        commanded: meta.wrench.source == Source::Commanded,
        wrench_pose: options.wrench_pose,
        mass_given: meta.object.mass,
        training,
        held_out,
        obstacles: meta.scene.obstacles.iter().map(|o| o.polygon.clone()).collect(),
    })
}

fn episode(
    reader: &Reader,
    streams: MaskedStreams,
    ordinal: usize,
    meta: &Metadata,
    noise: &Noise,
) -> Result<Prepared, Error> {
    let Readings { wrench, tare_sd } = reader.read(&streams, noise)?;
    let counts = counts(&streams, &wrench);
    let contact = contact_begins(&wrench, noise, &tare_sd, meta.at_rest);
    let mut prepared = Prepared {
        name: streams.name.to_owned(),
        ordinal,
        contact,
        wrench,
        zero_order_hold: meta.wrench.source == Source::Commanded,
        at_rest: meta.at_rest && rests_at_first(&streams.object.samples, noise, contact),
        pose: streams.object.samples,
        tare_sd,
        counts,
        first_twist: [0.0; 3],
        motion_cache: MotionCache::default(),
    };
    if let (false, Some(first)) = (prepared.at_rest, prepared.motion(noise).first()) {
        prepared.first_twist = first.twist;
    }
    Ok(prepared)
}

/// Whether the object is at rest at its first pose: the pose precedes contact, and the object does not move until contact.
fn rests_at_first(poses: &[PoseSample], noise: &Noise, contact: f64) -> bool {
    poses.first().is_some_and(|first| first.t <= contact)
        && contact::rests(poses, noise.pose, contact - REST_MARGIN_S)
}

fn contact_begins(wrench: &[WrenchSample], noise: &Noise, tare_sd: &[f64; 3], at_rest: bool) -> f64 {
    let t: Vec<f64> = wrench.iter().map(|w| w.t).collect();
    let readings: Vec<[f64; 3]> = wrench.iter().map(|w| w.reading).collect();
    let otherwise = if at_rest { t.last() } else { t.first() };
    contact::begins(&t, &readings, [noise.force, noise.torque], tare_sd).or(otherwise.copied()).unwrap_or(0.0)
}

fn counts(streams: &MaskedStreams, wrench: &[WrenchSample]) -> Counts {
    let poses: Vec<f64> = streams.object.samples.iter().map(|p| p.t).collect();
    let (pose_gaps, longest) = gaps(&poses);
    let age = |w: &WrenchSample| super::sampling::latest(&poses, w.t).map(|at| w.t - poses[at]);
    Counts {
        pose_outliers: streams.object.outliers,
        pose_held: streams.object.held,
        pose_gaps,
        gripper_outliers: streams.gripper.outliers,
        gripper_held: streams.gripper.held,
        wrench_gaps: gaps(&streams.wrench.t).0,
        before_first_pose: wrench.iter().filter(|w| age(w).is_none()).count(),
        stale_pose: wrench.iter().filter(|w| age(w).is_some_and(|age| age > longest)).count(),
    }
}

fn body(meta: &Metadata, mass: f64) -> Result<Body, Error> {
    let shape = meta.object.shape();
    let body = if shape.is_empty() { Body::point(mass) } else { Body::from_fixtures(shape, mass) };
    let unusable = |reason: String| Fault::Unusable {
        reason,
        remedy: "give a footprint with a positive area, and a positive mass".into(),
    };
    body.map(|body| body.with_feet(&meta.object.support))
        .map_err(|error| unusable(error.to_string()).at(Place::field("object")))
}
