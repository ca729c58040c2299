//! From sensor readings to planar wrenches with the pose of their frame in the object frame.
//!
//! Where the gripper's pose is recorded, every reading is brought into the sensor's own axes about the sensor's origin,
//! whichever axes it is published in: what an instrument does to a reading, it does there.

use nalgebra::Vector3;

use crate::episode::{Episode, WrenchStream};
use crate::error::{Error, Place};
use crate::fault::Fault;
use crate::metadata::{Frame, Metadata, Reference, Sign};

use super::tare::{FreeReading, Tare, TareMethod, Weight, sd_of_mean, weigh};
use super::track::{self, PoseNoise, Track};
use super::trajectory::{PoseAt, Trajectory, continuous, share};
use super::transform::{GripperPose, Wrench6, planar_transform, relative_pose};
use super::{Noise, Options, PoseSample, ReadingAxes, WrenchPose, WrenchSample};

/// The streams of one episode, masked.
pub(crate) struct View<'a> {
    pub name: &'a str,
    pub object: Track<PoseSample>,
    pub gripper: Track<GripperPose>,
    pub wrench: WrenchStream,
    object_path: Trajectory,
    gripper_path: Trajectory,
    gripper_times: Vec<f64>,
}

/// Planar wrenches of one episode.
pub(crate) struct Readings {
    pub wrench: Vec<WrenchSample>,
    pub tare_sd: [f64; 3],
}

impl<'a> View<'a> {
    pub fn new(
        episode: &'a Episode,
        pose_noise: &PoseNoise,
        noise: &Noise,
        rule: WrenchPose,
    ) -> Result<Self, Error> {
        let name = episode.name.as_str();
        let object = track::object(episode, pose_noise);
        let gripper = track::gripper(episode, pose_noise);
        if object.samples.is_empty() {
            return Err(no_stream(name, "object pose", "record the object's pose at least once"));
        }
        let Some(wrench) = episode.wrench() else {
            return Err(no_stream(name, "wrench", "record the force, or leave the episode out"));
        };
        let own_time = rule == WrenchPose::OwnTime;
        let planar = gripper.samples.iter().map(|p| PoseSample { t: p.t, pose: p.planar() });
        let object_path = Trajectory::new(&object.samples, noise, own_time);
        let gripper_path = Trajectory::new(&continuous(planar), noise, own_time);
        let gripper_times = gripper.samples.iter().map(|p| p.t).collect();
        Ok(Self { name, object, gripper, wrench, object_path, gripper_path, gripper_times })
    }

    fn object_at(&self, t: f64) -> PoseAt {
        let nowhere = PoseAt { pose: [0.0; 3], variance: [0.0; 3], correlation: 0.0 };
        self.object_path.at(t).unwrap_or(nowhere)
    }

    /// The gripper's attitude and position at `t`; `None` without a gripper stream.
    fn gripper_at(&self, t: f64) -> Option<GripperPose> {
        let (k, share) = share(&self.gripper_times, t)?;
        let samples = &self.gripper.samples;
        match (&self.gripper_path, samples.get(k + 1)) {
            (Trajectory::Smoothed(_), Some(next)) => Some(samples[k].towards(next, share)),
            _ => samples.get(k).cloned(),
        }
    }
}

fn no_stream(episode: &str, what: &str, remedy: &str) -> Error {
    let reason = format!("there is no usable {what} sample");
    Fault::Unusable { reason, remedy: remedy.into() }.at(Place::episode(episode))
}

/// What turns readings into wrenches on the object, the same for all episodes.
pub(crate) struct Reader<'a> {
    meta: &'a Metadata,
    method: TareMethod,
    axes: ReadingAxes,
    weight: Option<Weight>,
}

/// The pose of a reading's frame in the object frame, and how well it is known.
struct FrameAt {
    pose: [f64; 3],
    /// Variance of the position along either axis, m², and of the angle, rad².
    spread: [f64; 2],
    correlation: f64,
}

/// Tilt against the attitude before contact up to which a gripper counts as level, rad: two degrees.
const LEVEL: f64 = 0.035;

impl<'a> Reader<'a> {
    pub fn new(meta: &'a Metadata, options: Options, views: &[View]) -> Result<Self, Error> {
        let method = options.tare;
        let mut reader = Self { meta, method, axes: options.axes, weight: None };
        if !meta.wrench.raw || method == TareMethod::Equation12 {
            return Ok(reader);
        }
        let free: Vec<Vec<FreeReading>> =
            views.iter().map(|view| reader.free(view)).collect::<Result<_, _>>()?;
        reader.weight = match (meta.wrench.gripper_mass, meta.wrench.gripper_com) {
            (Some(mass), com) => {
                let force = mass * options.gravity;
                Some(Weight { force, moment: Vector3::from(com.unwrap_or_default()) * force })
            }
            (None, _) => weigh(&free),
        };
        match views.iter().zip(&free).find(|(view, free)| tilts(view, free)) {
            Some((view, _)) if reader.weight.is_none() => Err(unweighed(view.name)),
            Some((view, _)) => complete(view).map(|()| reader),
            None => Ok(Self { weight: None, ..reader }),
        }
    }

    /// The planar wrenches of `view`.
    pub fn read(&self, view: &View, noise: &Noise) -> Result<Readings, Error> {
        let (tare, tare_sd) = if self.meta.wrench.raw {
            let (tare, sd) = self.tare(view, noise)?;
            (Some(tare), sd)
        } else {
            (None, [0.0; 3])
        };
        let sample = |(&t, value): (&f64, &Wrench6)| {
            self.sample(view, t, self.planar(view, t, &self.signed(value), tare.as_ref()))
        };
        Ok(Readings { wrench: view.wrench.t.iter().zip(&view.wrench.value).map(sample).collect(), tare_sd })
    }

    fn tare(&self, view: &View, noise: &Noise) -> Result<(Tare, [f64; 3]), Error> {
        let free = self.free(view)?;
        let Some(tare) = Tare::new(self.method, &free, self.weight.as_ref()) else {
            return Err(untared(view.name, self.meta.wrench.precontact(view.name)));
        };
        let planar: Vec<[f64; 3]> =
            free.iter().map(|r| self.planar(view, r.pose.t, &r.wrench, Some(&tare))).collect();
        let usual = [noise.force, noise.force, noise.torque].map(|sd| sd / (free.len() as f64).sqrt());
        let sd = [0, 1, 2].map(|k| {
            let axis: Vec<f64> = planar.iter().map(|p| p[k]).collect();
            sd_of_mean(&axis).unwrap_or(usual[k])
        });
        Ok((tare, sd))
    }

    /// The readings in the interval without contact.
    fn free(&self, view: &View) -> Result<Vec<FreeReading>, Error> {
        let interval = self.meta.wrench.precontact(view.name);
        let inside = |t: f64| interval.is_some_and(|[start, end]| start <= t && t <= end);
        let rows = (0..view.wrench.t.len()).filter(|&i| inside(view.wrench.t[i]));
        let free: Vec<FreeReading> = rows
            .map(|i| FreeReading {
                wrench: self.signed(&view.wrench.value[i]),
                pose: self.pose(view, view.wrench.t[i]),
            })
            .collect();
        if free.is_empty() { Err(untared(view.name, interval)) } else { Ok(free) }
    }

    fn signed(&self, value: &Wrench6) -> Wrench6 {
        match self.meta.wrench.sign {
            Sign::OnObject => *value,
            Sign::OnSensor => value.map(|v| -v),
        }
    }

    /// Where the gripper is at `t`; level at the world's origin without a gripper stream.
    fn pose(&self, view: &View, t: f64) -> GripperPose {
        let known = view.gripper_at(t);
        known.map_or_else(|| GripperPose::level(t, [0.0; 3]), |pose| GripperPose { t, ..pose })
    }

    fn planar(&self, view: &View, t: f64, reading: &Wrench6, tare: Option<&Tare>) -> [f64; 3] {
        let pose = self.pose(view, t);
        let mut wrench = tare.map_or(*reading, |tare| tare.apply(reading, &pose));
        for (value, present) in wrench.iter_mut().zip(view.wrench.present) {
            *value *= f64::from(u8::from(present)); // the weight's share in an axis that was not measured
        }
        if self.meta.wrench.frame == Frame::Sensor && !pose.is_level() {
            return pose.seen_from_above(&wrench);
        }
        [wrench[0], wrench[1], wrench[5]]
    }

    /// The sample of a planar reading in published axes: brought to the sensor's frame where that is known.
    fn sample(&self, view: &View, t: f64, published: [f64; 3]) -> WrenchSample {
        let (object, gripper) = (view.object_at(t), view.gripper_path.at(t));
        let own = gripper.map(|gripper| relative(&object, &gripper));
        let from = self.frame(&object, own.as_ref(), view.wrench.present);
        let in_sensor = own.as_ref().filter(|_| self.axes == ReadingAxes::Sensor);
        let frame = in_sensor.map_or(from.pose, |own| own.pose);
        let reading = if frame == from.pose { published } else { moved(&published, &from.pose, &frame) };
        let force = published[0].hypot(published[1]);
        let [place, angle] = from.spread;
        // An angle's error turns the force, a position's changes its moment (equation 13).
        let turned = force * force * angle;
        let blur = [turned, turned, force * force * place].map(|variance| variance * from.correlation);
        WrenchSample { t, reading, frame, blur }
    }

    /// Pose in the object frame of the frame that the reading is published in.
    fn frame(&self, object: &PoseAt, gripper: Option<&FrameAt>, present: [bool; 6]) -> FrameAt {
        let [x, y, turned] = gripper.map_or([0.0; 3], |at| at.pose);
        let [place, mutual] = gripper.map_or([0.0; 2], |at| at.spread);
        let (angle, of_angle) = match self.meta.wrench.frame {
            Frame::Sensor => (turned, mutual),
            Frame::Object => (0.0, 0.0),
            Frame::World => (-object.pose[2], object.variance[2]),
        };
        let correlation = gripper.map_or(object.correlation, |at| at.correlation.max(object.correlation));
        match self.meta.wrench.reference_for(present) {
            Reference::Sensor => FrameAt { pose: [x, y, angle], spread: [place, of_angle], correlation },
            Reference::Object => FrameAt { pose: [0.0, 0.0, angle], spread: [0.0, of_angle], correlation },
        }
    }
}

/// The gripper's frame in the object frame.
fn relative(object: &PoseAt, gripper: &PoseAt) -> FrameAt {
    let pose = relative_pose(&object.pose, &gripper.pose);
    let [a, b] = [&object.variance, &gripper.variance];
    let lever = pose[0] * pose[0] + pose[1] * pose[1];
    let place = 0.5 * (a[0] + a[1] + b[0] + b[1] + lever * a[2]);
    FrameAt { pose, spread: [place, a[2] + b[2]], correlation: object.correlation.max(gripper.correlation) }
}

/// The wrench that reads `reading` in the frame at `from`, as it reads in the frame at `to`.
fn moved(reading: &[f64; 3], from: &[f64; 3], to: &[f64; 3]) -> [f64; 3] {
    planar_transform(&relative_pose(to, from), reading)
}

/// Whether the gripper leaves the attitude in which it was tared.
fn tilts(view: &View, free: &[FreeReading]) -> bool {
    let Some(tared) = free.first().map(|reading| reading.pose.down()) else { return false };
    view.gripper.samples.iter().any(|pose| pose.down().angle(&tared) > LEVEL)
}

/// A tilted reading needs all of its axes to be seen from above.
fn complete(view: &View) -> Result<(), Error> {
    let [_, _, force_z, torque_x, torque_y, torque_z] = view.wrench.present;
    let torques = [torque_x, torque_y, torque_z];
    // No torque at all: a point contact, which bears none in any attitude.
    if force_z && (torques == [true; 3] || torques == [false; 3]) {
        return Ok(());
    }
    let fault = Fault::Unusable {
        reason: "the gripper tilts, but not all axes of the sensor are recorded".into(),
        remedy: "record force_z, torque_x and torque_y too, or keep the gripper level".into(),
    };
    Err(fault.at(Place::episode(view.name)))
}

fn unweighed(episode: &str) -> Error {
    let fault = Fault::Unusable {
        reason: "the gripper tilts after its tare, and its weight is not known".into(),
        remedy: "give wrench.gripper_mass and wrench.gripper_com, or intervals without contact at several \
                 attitudes (0.05 rad apart or more) in wrench.precontact"
            .into(),
    };
    fault.at(Place::episode(episode))
}

fn untared(episode: &str, interval: Option<[f64; 2]>) -> Error {
    let reason = match interval {
        Some([start, end]) => {
            format!("no wrench sample lies in the interval without contact, {start} to {end} s")
        }
        None => "a raw reading has no interval without contact".into(),
    };
    let remedy = "give wrench.precontact an interval of this episode in which nothing is touched".into();
    Fault::Unusable { reason, remedy }.at(Place::episode(episode))
}
