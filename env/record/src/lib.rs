//! Recordings of pushes: read, written, checked, and prepared for estimation.

mod document;
mod episode;
mod error;
mod fault;
mod metadata;
mod recording;
mod table;
mod validate;
mod write;

pub use episode::{Episode, Gripper, Stream, WrenchStream};
pub use error::{Error, File, Place};
pub use fault::Fault;
pub use metadata::{
    Contact, Dof, FORMAT, FixtureMeta, Frame, Metadata, NoiseMeta, ObjectMeta, Obstacle, Precontact,
    Reference, Scene, Sign, Source, Split, WrenchMeta,
};
pub use recording::Recording;
pub use table::Table;
