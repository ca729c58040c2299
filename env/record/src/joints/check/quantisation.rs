//! Check of the step of the encoders.

use super::input::Input;
use super::merge::{Found, merged};
use crate::check::{Finding, Severity};
use crate::joints::tracks::white_noise;

/// Smallest number of differences from which a step is estimated. Five random ones are multiples in 0.03 % of all cases.
const MIN_DIFFERENCES: usize = 5;
/// Smallest step relative to the range; finer steps are those of decimals in a text file.
const MIN_STEP_TO_RANGE: f64 = 1e-5;
/// Smallest share of differences between neighbouring levels that are multiples of the step. Continuous values give 20 %.
const MIN_MULTIPLES: f64 = 0.98;
/// Largest deviation from a multiple, in steps.
const MULTIPLE_TOLERANCE: f64 = 0.1;
/// A step below this number of noise standard deviations is hidden by the noise.
const MIN_STEP_TO_NOISE: f64 = 1.0;
/// Smallest deviation of a stated step that is reported, relative.
const STEP_TOLERANCE: f64 = 0.05;

/// Checks whether positions are quantised, and whether the stated noise allows for it.
pub(super) fn quantisation(input: &Input) -> Vec<Finding> {
    let (mut unstated, mut wrong, mut too_small) = (vec![], vec![], vec![]);
    for joint in input.joints {
        let series: Vec<Vec<f64>> =
            input.raw.iter().filter_map(|episode| Some(episode.joint_stream("q", joint)?.1)).collect();
        let Some(step) = common_step(&series) else { continue };
        let noise = series.iter().map(|q| white_noise(q)).fold(0.0, f64::max);
        let stated = input.metadata.noise.as_ref();
        let stated_step = stated.and_then(|noise| noise.position_step.as_ref()?.of(joint).copied());
        let stated_noise = stated.and_then(|noise| noise.position.as_ref()?.of(joint).copied());
        let push = |list: &mut Vec<Found>, severity, sentence: String, remedy: &str| {
            let finding = Finding::new("noise", severity, sentence, remedy);
            list.push(Found { size: step, joint: joint.clone(), finding });
        };
        match stated_step {
            None if step > MIN_STEP_TO_NOISE * noise => push(
                &mut unstated,
                Severity::Note,
                format!("the positions of {joint} are multiples of {step:.4e}, which is not stated"),
                &format!("set [noise] position_step = {{\"{joint}\" = {step:.4e}}}"),
            ),
            Some(stated) if (stated / step - 1.0).abs() > STEP_TOLERANCE => push(
                &mut wrong,
                Severity::Warning,
                format!(
                    "the positions of {joint} are multiples of {step:.4e}, not of the stated step {stated:.4e}"
                ),
                &format!("set [noise] position_step of {joint} to {step:.4e}"),
            ),
            _ => {}
        }
        let least = step / 12.0_f64.sqrt();
        if let Some(stated) = stated_noise.filter(|stated| *stated < 0.7 * least) {
            push(
                &mut too_small,
                Severity::Warning,
                format!(
                    "the stated noise of {joint}, {stated:.2e}, is below the {least:.2e} of the quantisation alone"
                ),
                "state the standard deviation in all, quantisation included, in [noise] position",
            );
        }
    }
    [merged(unstated), merged(wrong), merged(too_small)].concat()
}

/// The step of which all positions are multiples, up to a common offset; `None` if there is none.
fn common_step(series: &[Vec<f64>]) -> Option<f64> {
    let mut levels: Vec<f64> = series.concat();
    levels.sort_by(f64::total_cmp);
    levels.dedup();
    let range = levels.last()? - levels.first()?;
    // Exact rounding to decimals leaves differences of a rounding error.
    let differences: Vec<f64> =
        levels.windows(2).map(|pair| pair[1] - pair[0]).filter(|d| *d > 1e-9 * range).collect();
    if differences.len() < MIN_DIFFERENCES {
        return None;
    }
    let smallest = differences.iter().copied().fold(f64::INFINITY, f64::min);
    let multiple = |d: &&f64| ((*d / smallest) - (*d / smallest).round()).abs() < MULTIPLE_TOLERANCE;
    let share = differences.iter().filter(multiple).count() as f64 / differences.len() as f64;
    let steps: f64 = differences.iter().map(|d| (d / smallest).round()).sum();
    (share >= MIN_MULTIPLES && smallest > MIN_STEP_TO_RANGE * range)
        .then(|| differences.iter().sum::<f64>() / steps)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn common_step_of_quantised_and_continuous_values() {
        let smooth: Vec<f64> = (0..4000).map(|k| (0.003 * f64::from(k)).sin()).collect();
        assert_eq!(common_step(std::slice::from_ref(&smooth)), None);
        let quantised: Vec<f64> = smooth.iter().map(|q| (q / 0.0123).round() * 0.0123).collect();
        let step = common_step(&[quantised]).unwrap_or(0.0);
        assert!((step / 0.0123 - 1.0).abs() < 1e-6, "{step}");
    }
}
