//! Whether the force acts where the object goes. On a floor a push does work on the object: over an episode that
//! starts at rest the work is positive, whatever wheels and friction there are.

use crate::metadata::Sign;

use super::subject::{Moment, Subject};
use super::{Finding, Severity};

/// A way in which the force's axes may have been mistaken: what undoes it, and the words for it.
struct Mistake {
    undo: [[f64; 2]; 2],
    words: &'static str,
}

const MISTAKES: [Mistake; 7] = [
    Mistake { undo: [[-1.0, 0.0], [0.0, -1.0]], words: "turned by 180°" },
    Mistake { undo: [[0.0, -1.0], [1.0, 0.0]], words: "turned by -90°" },
    Mistake { undo: [[0.0, 1.0], [-1.0, 0.0]], words: "turned by 90°" },
    Mistake { undo: [[0.0, 1.0], [1.0, 0.0]], words: "exchanged" },
    Mistake { undo: [[0.0, -1.0], [-1.0, 0.0]], words: "exchanged and both reversed" },
    Mistake { undo: [[1.0, 0.0], [0.0, -1.0]], words: "reversed in y" },
    Mistake { undo: [[-1.0, 0.0], [0.0, 1.0]], words: "reversed in x" },
];

const AS_IS: [[f64; 2]; 2] = [[1.0, 0.0], [0.0, 1.0]];
/// Fewer moving samples than this show no direction.
const FEWEST: usize = 30;
/// Share of positive work that a right recording may fall to: turns about a stuck wheel are far from it.
const RIGHT: f64 = 0.3;
/// A negative share below this is not held back by noise or slope.
const WRONG: f64 = -0.3;
/// Share that a mistake must bring about when it is undone, and by how much it must gain.
const CONVINCING: [f64; 2] = [0.6, 0.5];
/// Mistakes whose shares differ by less than this cannot be told apart.
const ALIKE: f64 = 0.1;

/// Sign of the wrench and orientation of its axes.
pub(crate) fn sign_and_axes(subject: &Subject) -> Vec<Finding> {
    let moments: Vec<Moment> = subject.episodes.iter().flat_map(|look| look.moments()).collect();
    let share = work_share(&moments, &AS_IS);
    if moments.len() < FEWEST || share > RIGHT {
        return vec![];
    }
    if share < WRONG {
        return vec![wrong_sign(share, subject.meta.wrench.sign)];
    }
    if subject.meta.on_rail() {
        return vec![];
    }
    wrong_axes(&moments, share).into_iter().collect()
}

/// Work done on the object as a share of the most that these forces and motions could do.
fn work_share(moments: &[Moment], undo: &[[f64; 2]; 2]) -> f64 {
    let (mut work, mut most) = (0.0, 0.0);
    for m in moments {
        let [fx, fy, torque] = m.reading;
        let force = [0, 1].map(|k| undo[k][0] * fx + undo[k][1] * fy);
        let (sin, cos) = m.angle.sin_cos();
        let world = [cos * force[0] - sin * force[1], sin * force[0] + cos * force[1]];
        work += world[0] * m.velocity[0] + world[1] * m.velocity[1] + torque * m.rate;
        most += fx.hypot(fy) * m.velocity[0].hypot(m.velocity[1]) + (torque * m.rate).abs();
    }
    if most > 0.0 { work / most } else { 1.0 }
}

fn wrong_sign(share: f64, sign: Sign) -> Finding {
    let (given, other) = match sign {
        Sign::OnObject => ("on_object", "on_sensor"),
        Sign::OnSensor => ("on_sensor", "on_object"),
    };
    let sentence = format!(
        "the force seems to act in the wrong direction: it takes {:.0} % of the work it could do out of the moving object",
        -100.0 * share
    );
    let remedy = format!(
        "set wrench.sign = \"{other}\" instead of \"{given}\", or turn the sensor frame by 180° if it hangs the other way"
    );
    Finding::new("sign", Severity::Error, sentence, &remedy)
}

fn wrong_axes(moments: &[Moment], share: f64) -> Option<Finding> {
    let undone: Vec<(f64, &str)> = MISTAKES.iter().map(|m| (work_share(moments, &m.undo), m.words)).collect();
    let best = undone.iter().map(|(share, _)| *share).fold(f64::NEG_INFINITY, f64::max);
    if best < CONVINCING[0] || best < share + CONVINCING[1] {
        return None;
    }
    let likely: Vec<&str> =
        undone.iter().filter(|(s, _)| *s > best - ALIKE).map(|(_, words)| *words).collect();
    let sentence = format!(
        "the force's axes seem {}: it does {:.0} % of the work it could do on the moving object, and {:.0} % once this is undone",
        likely.join(" or "),
        100.0 * share,
        100.0 * best
    );
    let remedy = "check the sensor frame against the gripper's pose: gripper_theta, or the quaternion, must be \
                  that of the axes that the reading is given in";
    Some(Finding::new("axes", Severity::Error, sentence, remedy))
}
