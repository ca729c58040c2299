//! The arm between commands and the wrench on the object: delay, lag and compliance, and their estimate.
//!
//! The wrench at the grasp is measured and the command is known, so that the arm is identified without a model of the
//! object. A delay of the arm and one of all sensors are indistinguishable. Both have the same effect on a controller,
//! so that only their sum is estimated.

mod axis;
mod commanded;
mod estimate;
mod response;

pub use axis::AxisResponse;
pub use commanded::CommandedArm;
pub use estimate::ArmEstimate;
pub use response::ArmResponse;

pub(crate) use response::{ArmStep, AxisStates};
