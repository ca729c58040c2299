//! Checks of the units: SI units and radians.

use crate::episode::Gripper;
use crate::metadata::{Contact, Reference};
use crate::prepare::outlier::MIN_TRACKER_SD;
use crate::prepare::{latest, mean_pose_noise, median, quantile, relative_pose};

use super::data::EpisodeData;
use super::finding::{Finding, Severity};
use super::gains::{self, METRES_PER_INCH};
use super::input::CheckInput;

/// Maximum plausible rotation, rad. A larger one is probably in degrees.
const MAX_ROTATION_RAD: f64 = 13.0;
/// Minimum ratio of the motion of the grasp with angles read as radians to that with angles read as degrees.
const MIN_GRASP_MOTION_RATIO: f64 = 3.0;
/// Maximum plausible lever arm in sizes of the object. With a larger one, torques are probably in N mm.
const MAX_ARM_SIZES: f64 = 20.0;
/// Maximum ratio of estimated to stated noise.
const MAX_ESTIMATED_NOISE_RATIO: f64 = 20.0;
/// Maximum ratio of stated to estimated noise. Millimetres stated as metres are a factor of 1000.
const MAX_STATED_NOISE_RATIO: f64 = 300.0;
/// Minimum number of poses for an estimate of their noise.
const MIN_POSES: usize = 50;
/// Apparent noise of a jerky motion at a low sampling rate, m or rad.
const MAX_APPARENT_NOISE: f64 = 5e-4;

/// Checks the unit of length, then the gains of torque and force, which a wrong unit of length also changes.
pub(crate) fn lengths_and_gains(input: &CheckInput) -> Vec<Finding> {
    let lengths = lengths(input);
    if lengths.is_empty() { gains::gains(input) } else { lengths }
}

/// Checks for a unit of length in which size, speed, mass per area and reach are more plausible than in metres.
fn lengths(input: &CheckInput) -> Vec<Finding> {
    let evidence = LengthEvidence::new(input);
    let stated = evidence.score(1.0, 1.0);
    // The unit of all lengths, of the positions only, or of the footprint only.
    let units = LENGTH_UNITS.iter().flat_map(|unit| {
        let metres = unit.0;
        [
            (unit, [metres, metres], "lengths and positions"),
            (unit, [metres, 1.0], "positions"),
            (unit, [1.0, metres], "lengths of the object"),
        ]
    });
    let scored = units
        .map(|(unit, [positions, outline], what)| (evidence.score(positions, outline) + unit.4, unit, what));
    let Some((score, unit, what)) = scored.max_by(|a, b| a.0.total_cmp(&b.0)) else { return vec![] };
    if score < stated + MIN_LOG_ODDS {
        return vec![];
    }
    let sentence = format!("{what} appear to be in {}: {}", unit.1, evidence.text());
    let remedy = format!("{} all {what} by {}: the format uses metres", unit.2, unit.3);
    vec![Finding::new("units", Severity::Error, sentence, &remedy)]
}

/// Units of length: metres per unit, name, operation and factor of the conversion, and log-odds before the data. Trackers
/// and drawings in inches are assumed ten times as rare as metric ones.
const LENGTH_UNITS: [(f64, &str, &str, &str, f64); 3] = [
    (0.001, "millimetres", "divide", "1000", 0.0),
    (0.01, "centimetres", "divide", "100", 0.0),
    (METRES_PER_INCH, "inches", "multiply", "0.0254", -2.3),
];
/// Minimum log-odds of another unit relative to metres.
const MIN_LOG_ODDS: f64 = 8.0;
/// Prior of the size of a pushed object, m: median, standard deviation of the logarithm.
const SIZE_PRIOR: (f64, f64) = (0.6, 0.9);
/// Prior of its speed, m/s.
const SPEED_PRIOR: (f64, f64) = (0.3, 1.2);
/// Prior of its mass per area, kg/m².
const AREAL_MASS_PRIOR: (f64, f64) = (25.0, 1.3);
/// Prior of the distance of the gripper, in halves of the object's size.
const REACH_PRIOR: (f64, f64) = (0.8, 0.8);
/// Standard deviation of the logarithm of an estimated gain.
const GAIN_LOG_SD: f64 = 0.2;
/// Maximum penalty of one quantity.
const MAX_PENALTY: f64 = 50.0;

/// Quantities of a recording that depend on its unit of length.
struct LengthEvidence {
    size: f64,
    speed: f64,
    reach: f64,
    /// Mass estimated from the motion, kg.
    mass: Option<f64>,
    /// Stated mass, kg.
    stated_mass: Option<f64>,
    area: f64,
    /// Gain by which torques must be multiplied.
    gain: Option<f64>,
}

impl LengthEvidence {
    fn new(input: &CheckInput) -> Self {
        let moving = input.data.episodes.iter().flat_map(|episode| &episode.motion);
        let speed = quantile(moving.map(|m| m.twist[0].hypot(m.twist[1])), 0.95).unwrap_or(0.0);
        let distance = |episode: &EpisodeData| {
            let in_contact = episode.prepared.wrench.iter().filter(|w| w.t >= episode.prepared.contact);
            median(in_contact.map(|w| w.frame[0].hypot(w.frame[1])))
        };
        let sensor = input.data.reference() == Reference::Sensor && !input.data.meta.on_rail();
        let distance =
            median(input.data.episodes.iter().filter_map(distance)).filter(|_| sensor).unwrap_or(0.0);
        let [low, high] = input.data.dataset.body.bounds();
        let fits = input.wrench_fits.as_ref();
        Self {
            size: input.data.size,
            speed,
            reach: if input.data.size > 0.0 { distance / (input.data.size / 2.0) } else { 0.0 },
            mass: fits.and_then(gains::mass).map(|(mass, _)| mass),
            stated_mass: input.data.meta.object.mass,
            area: (high[0] - low[0]) * (high[1] - low[1]),
            gain: fits.and_then(gains::torque_gain),
        }
    }

    /// Log-plausibility if positions are in units of `unit` metres, and the outline in units of `outline` metres.
    fn score(&self, unit: f64, outline: f64) -> f64 {
        let log_density = |value: f64, (median, spread): (f64, f64)| {
            let deviation = (value / median).ln() / spread;
            if value > 0.0 && value.is_finite() {
                -(0.5 * deviation * deviation).min(MAX_PENALTY)
            } else {
                0.0
            }
        };
        // The mass estimated from accelerations scales inversely with the unit of position.
        let mass = self.mass.map_or(0.0, |mass| mass / unit);
        let area = self.area * outline * outline;
        let mass_ratio = self.stated_mass.map_or(0.0, |stated| {
            let at = |force: f64| log_density(mass / stated * force, (1.0, GAIN_LOG_SD));
            // Another unit of force is as likely as another unit of length.
            if unit == 1.0 {
                gains::FORCE_UNITS_N.map(at).into_iter().fold(at(1.0), f64::max)
            } else {
                at(1.0)
            }
        });
        let gain = self.gain.map_or(0.0, |gain| gain * unit);
        log_density(self.size * outline, SIZE_PRIOR)
            + log_density(self.speed * unit, SPEED_PRIOR)
            + log_density(if area > 0.0 { mass / area } else { 0.0 }, AREAL_MASS_PRIOR)
            + log_density(self.reach * unit / outline, REACH_PRIOR)
            + mass_ratio
            + log_density(gain, (1.0, GAIN_LOG_SD))
    }

    fn text(&self) -> String {
        let mass =
            self.mass.map_or(String::new(), |mass| format!(" and behaves like a mass of {mass:.3} kg"));
        format!(
            "read as metres, the object measures {:.1} m, moves at {:.2} m/s{mass}",
            self.size, self.speed
        )
    }
}

/// Checks for object angles in degrees: by the position of the gripper on the object if it is known, otherwise by the range
/// of the angles.
pub(crate) fn object_angles(input: &CheckInput) -> Vec<Finding> {
    let is_grasp = input.data.meta.wrench.contact == Contact::Grasp;
    let reason = |episode: &EpisodeData| match grasp_motion_ratio(episode).filter(|_| is_grasp) {
        Some(ratio) if ratio > MIN_GRASP_MOTION_RATIO => {
            Some("only then does the gripper keep its position on the object")
        }
        None if rotation(episode) > MAX_ROTATION_RAD => {
            Some("read as radians, the object would rotate several times")
        }
        _ => None,
    };
    let finding = |episode: &EpisodeData| {
        let sentence = format!("object_theta appears to be in degrees: {}", reason(episode)?);
        let remedy = "multiply angles by π/180: the format uses radians";
        Some(Finding::new("units", Severity::Error, sentence, remedy).in_episode(episode.name()))
    };
    input.data.episodes.iter().filter_map(finding).take(1).collect()
}

/// Range of the heading, or its median absolute value if that is larger, rad.
fn rotation(episode: &EpisodeData) -> f64 {
    let theta = || episode.prepared.pose.iter().map(|p| p.pose[2]);
    range(theta).max(median(theta()).unwrap_or(0.0).abs())
}

/// Motion of the gripper on the object with headings read as radians, relative to that with headings read as degrees. `None`
/// without a gripper, or if the object rotates too little.
fn grasp_motion_ratio(episode: &EpisodeData) -> Option<f64> {
    let (Some(object), Some(Gripper::Level(gripper))) = (episode.raw.object(), episode.raw.gripper()) else {
        return None;
    };
    let motion = |scale: f64| {
        let in_contact =
            gripper.t.iter().zip(&gripper.value).filter(|(t, _)| **t >= episode.prepared.contact);
        let positions: Vec<[f64; 3]> = in_contact
            .filter_map(|(t, pose)| {
                let [x, y, theta] = object.value[latest(&object.t, *t)?];
                Some(relative_pose(&[x, y, scale * theta], pose))
            })
            .collect();
        range(|| positions.iter().map(|p| p[0])).hypot(range(|| positions.iter().map(|p| p[1])))
    };
    let (radians, degrees) = (motion(1.0), motion(1f64.to_radians()));
    let rotation = range(|| object.value.iter().map(|p| p[2]));
    (rotation > 1.0 && degrees > 0.0).then(|| radians / degrees)
}

/// Range of `values` between the 2 % and 98 % quantiles.
fn range<I: Iterator<Item = f64>>(values: impl Fn() -> I) -> f64 {
    quantile(values(), 0.98).unwrap_or(0.0) - quantile(values(), 0.02).unwrap_or(0.0)
}

/// Checks for torques in N mm by the lever arm, if there is too little motion for `gains`.
pub(crate) fn torques(input: &CheckInput) -> Vec<Finding> {
    if input.wrench_fits.is_some() {
        return vec![]; // `gains` is more sensitive
    }
    let loads = input.data.episodes.iter().flat_map(|episode| {
        episode.prepared.wrench.iter().filter(|w| w.t >= episode.prepared.contact).map(|w| w.reading)
    });
    let loads: Vec<[f64; 3]> = loads.collect();
    let force = median(loads.iter().map(|r| r[0].hypot(r[1]))).unwrap_or(0.0);
    let torque = median(loads.iter().map(|r| r[2].abs())).unwrap_or(0.0);
    if input.data.size <= 0.0
        || force <= 3.0 * input.data.dataset.noise.force
        || torque <= MAX_ARM_SIZES * force * input.data.size
    {
        return vec![];
    }
    let sentence = format!(
        "torques appear to be in N mm: torques of {torque:.2} with forces of {force:.2} N imply a lever arm of {:.1} m",
        torque / force
    );
    vec![Finding::new("units", Severity::Error, sentence, "divide torques by 1000: the format uses N m")]
}

/// Checks for stated noise in another unit than the data.
pub(crate) fn noise(input: &CheckInput) -> Vec<Finding> {
    let (Some(stated), estimated) = (&input.data.meta.noise, input.data.estimated_noise.pose) else {
        return vec![];
    };
    let poses = input.data.episodes.iter().map(|episode| episode.prepared.pose.len().saturating_sub(4));
    if poses.sum::<usize>() < MIN_POSES {
        return vec![]; // too few for an estimate
    }
    let names = ["x", "y", "theta"];
    // Errors of the time stamps are part of the estimate.
    let expected = mean_pose_noise(
        input.data.episodes.iter().map(|episode| episode.prepared),
        &input.data.dataset.noise,
    );
    let axes = (0..3).filter(|&k| input.data.dataset.dof[k]);
    let inconsistent = axes.filter(|&k| {
        estimated[k] > MAX_APPARENT_NOISE.max(MAX_ESTIMATED_NOISE_RATIO * expected[k])
            || (estimated[k] > MIN_TRACKER_SD && stated.pose[k] > MAX_STATED_NOISE_RATIO * estimated[k])
    });
    let finding = |k: usize| {
        let sentence = format!(
            "noise.pose states {:.2e} for {}, but the noise estimated from the poses is {:.2e}",
            stated.pose[k], names[k], estimated[k]
        );
        Finding::new(
            "noise",
            Severity::Warning,
            sentence,
            "state one standard deviation in metres and radians, or remove [noise]",
        )
    };
    inconsistent.take(1).map(finding).collect()
}
