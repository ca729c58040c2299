//! Check of the direction of the force by its work. In an episode that starts at rest, a push does positive work on an
//! object on a floor, whatever its wheels and friction.

use crate::metadata::Sign;

use super::data::LoadSample;
use super::finding::{Finding, Severity};
use super::input::CheckInput;

/// A mistake in the force axes: the matrix that corrects it, and its description.
struct AxesMistake {
    correction: [[f64; 2]; 2],
    words: &'static str,
}

const MISTAKES: [AxesMistake; 7] = [
    AxesMistake { correction: [[-1.0, 0.0], [0.0, -1.0]], words: "rotated by 180°" },
    AxesMistake { correction: [[0.0, -1.0], [1.0, 0.0]], words: "rotated by -90°" },
    AxesMistake { correction: [[0.0, 1.0], [-1.0, 0.0]], words: "rotated by 90°" },
    AxesMistake { correction: [[0.0, 1.0], [1.0, 0.0]], words: "swapped" },
    AxesMistake { correction: [[0.0, -1.0], [-1.0, 0.0]], words: "swapped and both reversed" },
    AxesMistake { correction: [[1.0, 0.0], [0.0, -1.0]], words: "reversed in y" },
    AxesMistake { correction: [[-1.0, 0.0], [0.0, 1.0]], words: "reversed in x" },
];

const IDENTITY: [[f64; 2]; 2] = [[1.0, 0.0], [0.0, 1.0]];
/// Minimum number of moving samples.
const MIN_MOVING_SAMPLES: usize = 30;
/// Work share up to which the direction is suspicious. Correct recordings, even of rotations about a stuck wheel, have more.
const MAX_SUSPICIOUS_WORK_SHARE: f64 = 0.3;
/// Work share below which the sign is wrong. Noise or a slope do not cause such negative work.
const MAX_REVERSED_WORK_SHARE: f64 = -0.3;
/// Minimum work share after the correction of a mistake.
const MIN_CORRECTED_WORK_SHARE: f64 = 0.6;
/// Minimum increase of the work share by the correction.
const MIN_WORK_SHARE_GAIN: f64 = 0.5;
/// Difference of the work shares below which mistakes are not distinguishable.
const TIE_MARGIN: f64 = 0.1;

/// Checks the sign of the wrench and the orientation of its axes.
pub(crate) fn sign_and_axes(input: &CheckInput) -> Vec<Finding> {
    let samples: Vec<LoadSample> =
        input.data.episodes.iter().flat_map(|episode| episode.load_samples()).collect();
    let share = work_share(&samples, &IDENTITY);
    if samples.len() < MIN_MOVING_SAMPLES || share > MAX_SUSPICIOUS_WORK_SHARE {
        return vec![];
    }
    if share < MAX_REVERSED_WORK_SHARE {
        return vec![wrong_sign(share, input.data.meta.wrench.sign)];
    }
    if input.data.meta.on_rail() {
        return vec![];
    }
    wrong_axes(&samples, share).into_iter().collect()
}

/// Work on the object relative to the largest possible work of these forces and motions.
fn work_share(samples: &[LoadSample], correction: &[[f64; 2]; 2]) -> f64 {
    let (mut work, mut most) = (0.0, 0.0);
    for m in samples {
        let [fx, fy, torque] = m.reading;
        let force = [0, 1].map(|k| correction[k][0] * fx + correction[k][1] * fy);
        let (sin, cos) = m.angle.sin_cos();
        let world = [cos * force[0] - sin * force[1], sin * force[0] + cos * force[1]];
        work += world[0] * m.velocity[0] + world[1] * m.velocity[1] + torque * m.rate;
        most += fx.hypot(fy) * m.velocity[0].hypot(m.velocity[1]) + (torque * m.rate).abs();
    }
    if most > 0.0 { work / most } else { 1.0 }
}

fn wrong_sign(share: f64, sign: Sign) -> Finding {
    let (stated, other) = match sign {
        Sign::OnObject => ("on_object", "on_sensor"),
        Sign::OnSensor => ("on_sensor", "on_object"),
    };
    let sentence = format!(
        "the force appears to act in the wrong direction: it does {:.0} % of the largest possible work on the moving object",
        100.0 * share
    );
    let remedy = format!(
        "set wrench.sign = \"{other}\" instead of \"{stated}\", or rotate the sensor frame by 180° if it is mounted that way"
    );
    Finding::new("sign", Severity::Error, sentence, &remedy)
}

fn wrong_axes(samples: &[LoadSample], share: f64) -> Option<Finding> {
    let corrected: Vec<(f64, &str)> =
        MISTAKES.iter().map(|m| (work_share(samples, &m.correction), m.words)).collect();
    let best = corrected.iter().map(|(share, _)| *share).fold(f64::NEG_INFINITY, f64::max);
    if best < MIN_CORRECTED_WORK_SHARE || best < share + MIN_WORK_SHARE_GAIN {
        return None;
    }
    let likely: Vec<&str> =
        corrected.iter().filter(|(s, _)| *s > best - TIE_MARGIN).map(|(_, words)| *words).collect();
    let sentence = format!(
        "the force axes appear {}: the force does {:.0} % of the largest possible work on the moving object, and {:.0} % after \
         correction",
        likely.join(" or "),
        100.0 * share,
        100.0 * best
    );
    let remedy = "check the orientation of the sensor frame: gripper_theta, or the quaternion, must be that of the axes \
                  in which the wrench is given";
    Some(Finding::new("axes", Severity::Error, sentence, remedy))
}
