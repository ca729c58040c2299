//! Several recordings of one object.

use trundle_record::Dataset;

use crate::EstimateError;

/// Prepares recordings of one object for a joint fit. A stated mass applies to all of them, and the names of
/// episodes get the number of the recording as a prefix.
///
/// # Errors
/// If there is no recording, or two of them differ in shape, feet, degrees of freedom or stated mass.
pub fn combined(mut recordings: Vec<Dataset>) -> Result<Vec<Dataset>, EstimateError> {
    let Some((first, others)) = recordings.split_first() else { return Err(EstimateError::NoRecording) };
    others.iter().try_for_each(|other| check_same_object(first, other))?;
    if recordings.len() == 1 {
        return Ok(recordings);
    }
    let weighed = recordings.iter().find_map(|data| Some((data.mass_given?, data.body.mass)));
    for (index, data) in recordings.iter_mut().enumerate() {
        if let Some((given, mass)) = weighed {
            (data.mass_given, data.body.mass) = (Some(given), mass);
        }
        let prefix = format!("{}#{}", data.name, index + 1);
        for episode in data.training.iter_mut().chain(&mut data.held_out) {
            episode.name = format!("{prefix}/{}", episode.name);
        }
    }
    Ok(recordings)
}

/// All episodes as one recording, with the noise of the first.
pub(crate) fn merged(recordings: &[Dataset]) -> Result<Dataset, EstimateError> {
    let Some((first, others)) = recordings.split_first() else { return Err(EstimateError::NoRecording) };
    let mut all = first.clone();
    for other in others {
        all.name = format!("{} + {}", all.name, other.name);
        all.training.extend_from_slice(&other.training);
        all.held_out.extend_from_slice(&other.held_out);
    }
    Ok(all)
}

fn check_same_object(a: &Dataset, b: &Dataset) -> Result<(), EstimateError> {
    let differ = |property: &'static str, of_first: String, of_second: String| {
        let (first, second) = (a.name.clone(), b.name.clone());
        Err(EstimateError::DifferentObjects { first, second, property, of_first, of_second })
    };
    if a.body.fixtures != b.body.fixtures {
        return differ("the footprint", format!("{:?}", a.body.fixtures), format!("{:?}", b.body.fixtures));
    }
    if a.dof != b.dof {
        return differ("dof", format!("{:?}", a.dof), format!("{:?}", b.dof));
    }
    if a.body.feet != b.body.feet {
        return differ("the support", format!("{:?}", a.body.feet), format!("{:?}", b.body.feet));
    }
    match (a.mass_given, b.mass_given) {
        (Some(x), Some(y)) if x != y => differ("the mass", format!("{x} kg"), format!("{y} kg")),
        _ => Ok(()),
    }
}
