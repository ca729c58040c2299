//! Preparation of a recording for estimation: planar tared wrenches, masked poses, start of contact.

mod assemble;
mod contact;
mod dataset;
mod mass;
mod noise;
mod options;
pub(crate) mod outlier;
mod reading;
mod samples;
mod sampling;
mod tare;
mod track;
mod trajectory;
mod transform;

use crate::error::Error;
use crate::recording::Recording;

pub use dataset::{Counts, Dataset, Prepared, mean_pose_noise};
pub use noise::Noise;
pub(crate) use noise::estimated as estimated_noise;
pub use options::{Options, ReadingAxes, WrenchPose};
pub use samples::{PoseSample, WrenchSample};
pub(crate) use sampling::{latest, median, median_step, quantile};
pub use tare::TareMethod;
pub(crate) use track::gaps;
pub use transform::{Wrench6, force_moment_transform, planar_transform, relative_pose, wrapped};

/// Prepares all episodes of `recording` with the default options.
///
/// # Errors
/// If a raw reading has no sample before contact for the tare, the weight of a tilting gripper is unknown and cannot be
/// estimated, required poses are missing, or the shape has no area.
pub fn prepare(recording: &Recording) -> Result<Dataset, Error> {
    prepare_with(recording, Options::default())
}

/// Like [`prepare`], with the given options.
///
/// # Errors
/// See [`prepare`].
pub fn prepare_with(recording: &Recording, options: Options) -> Result<Dataset, Error> {
    assemble::dataset(recording, options)
}

#[cfg(test)]
mod tests;
