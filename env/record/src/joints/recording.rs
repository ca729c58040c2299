//! A recording of joints in memory, its reading and writing.

use std::collections::BTreeMap;
use std::path::Path;

use super::columns::{check_title, title};
use super::files::read_models;
use super::metadata::JointMetadata;
use super::validate::check_metadata;
use crate::episode::Episode;
use crate::error::Error;
use crate::folder::Folder;
use crate::table::Table;
use crate::write::write_folder;

/// A recording of a mechanism with hinge and slide joints.
///
/// ```
/// use trundle_record::{Episode, JointMetadata, JointRecording};
///
/// let metadata = JointMetadata::from_toml(
///     "format = \"trundle-recording/2\"\nname = \"arm\"\n[mechanism]\naxis = \"hinge\"\njoints = [\"arm\"]\n",
/// )?;
/// let mut episode = Episode { name: "swing".to_owned(), ..Episode::default() };
/// episode.insert("t".to_owned(), vec![0.0, 0.1, 0.2]);
/// episode.insert("q_arm".to_owned(), vec![0.5, f64::NAN, 0.4]);
/// episode.insert("effort_arm".to_owned(), vec![1.0, 2.0, 3.0]);
/// let recording = JointRecording::new(metadata, vec![episode], Default::default())?;
/// assert_eq!(recording.stream("swing", "q", "arm"), Some((vec![0.0, 0.2], vec![0.5, 0.4])));
/// # Ok::<(), trundle_record::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct JointRecording {
    /// Content of `recording.toml`.
    pub metadata: JointMetadata,
    /// Episodes, sorted by name.
    pub episodes: Vec<Episode>,
    /// Documents of the models by their paths inside the folder: MJCF and URDF files, and the files that they include.
    /// Meshes and textures are not part of a recording.
    pub files: BTreeMap<String, Vec<u8>>,
}

impl JointRecording {
    /// Creates a recording of `episodes` with the documents of its models, sorts the episodes by name, and validates it.
    ///
    /// # Errors
    /// As [`JointRecording::validate`].
    pub fn new(
        metadata: JointMetadata,
        mut episodes: Vec<Episode>,
        files: BTreeMap<String, Vec<u8>>,
    ) -> Result<Self, Error> {
        episodes.sort_by(|a, b| a.name.cmp(&b.name));
        let recording = Self { metadata, episodes, files };
        recording.validate()?;
        Ok(recording)
    }

    /// Reads and validates the folder `path`: `recording.toml`, each `NAME.csv` or `NAME.parquet`, and the documents of the
    /// models. Ignores all other files, and files whose name begins with a dot.
    ///
    /// # Errors
    /// If a file cannot be read, or the recording is invalid (see [`JointRecording::validate`]).
    pub fn read(path: &Path) -> Result<Self, Error> {
        Self::from_folder(&Folder::open(path)?)
    }

    pub(crate) fn from_folder(folder: &Folder) -> Result<Self, Error> {
        let read = || {
            let metadata = JointMetadata::from_toml(&folder.text)?;
            // Wrong joints make all columns unknown, so the error is about the joints.
            check_metadata(&metadata)?;
            let files = read_models(&metadata, &folder.path)?;
            let episodes = folder.episodes(&|title| check_title(title, &metadata.mechanism.joints))?;
            Self::new(metadata, episodes, files)
        };
        read().map_err(|error| folder.locate(error))
    }

    /// Writes the folder `path` with its models and replaces an earlier recording there. Equal recordings give equal bytes.
    ///
    /// # Errors
    /// If the recording is invalid, `path` contains anything but a recording, or a file operation fails. `path` is then
    /// unchanged.
    pub fn write(&self, path: &Path, table: Table) -> Result<(), Error> {
        self.validate()?;
        write_folder(path, &self.metadata.to_toml()?, &self.episodes, &self.files, table)
    }

    /// The episode `name`.
    pub fn episode(&self, name: &str) -> Option<&Episode> {
        self.episodes.iter().find(|episode| episode.name == name)
    }

    /// Times, s, and values of the stream `prefix` (`q`, `v`, `effort`, …) of `joint` in an episode, without empty cells;
    /// `None` if there is no sample.
    pub fn stream(&self, episode: &str, prefix: &str, joint: &str) -> Option<(Vec<f64>, Vec<f64>)> {
        self.episode(episode)?.joint_stream(prefix, joint)
    }
}

impl Episode {
    /// Times, s, and values of the stream `prefix` (`q`, `v`, `effort`, …) of `joint`, without empty cells; `None` if there
    /// is no sample.
    pub fn joint_stream(&self, prefix: &str, joint: &str) -> Option<(Vec<f64>, Vec<f64>)> {
        let values = self.columns.get(&title(prefix, joint))?;
        let samples = self.t.iter().copied().zip(values.iter().copied()).filter(|(_, value)| !value.is_nan());
        let (t, values): (Vec<f64>, Vec<f64>) = samples.unzip();
        (!t.is_empty()).then_some((t, values))
    }
}
