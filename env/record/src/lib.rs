//! Recordings of pushes: read, written, checked, and prepared for estimation.

mod episode;
mod error;
mod metadata;
mod placement;
mod recording;

pub use episode::{Episode, Gripper, Stream, WrenchStream};
pub use error::{Error, Fault, File, Place};
pub use metadata::{
    Contact, Dof, FORMAT, FixtureMeta, Frame, Metadata, NoiseMeta, ObjectMeta, Obstacle,
    Precontact, Reference, Scene, Sign, Source, Split, WrenchMeta,
};
pub use recording::Recording;
