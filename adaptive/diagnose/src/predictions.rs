//! Tables of simulated and recorded poses, from which the error metrics can be recomputed.

use std::collections::BTreeMap;
use std::path::Path;
use trundle_infer::{Channels, InferError, Score, is_quasi_static, open_loop, score, unscored_time};
use trundle_model::{Model, Plant};
use trundle_record::{Column, Dataset, Error, Prepared, write_parquet};

/// A row for each pose sample, and a group of columns for each simulation.
#[derive(Clone, Debug, Default)]
pub struct Predictions {
    episode: Vec<String>,
    t: Vec<f64>,
    /// Whether a row counts in the metrics. Rows do not count while a law's own state is still being
    /// estimated.
    scored: Vec<bool>,
    /// Name of each group, and its poses: m, m, rad, world; NaN if there is no simulation.
    groups: Vec<(&'static str, Vec<[f64; 3]>)>,
}

impl Predictions {
    /// Recorded poses, and open-loop poses of each named plant; `None` leaves its columns empty. Rows within
    /// `settling` seconds after contact are not scored.
    pub fn new<'a>(
        episodes: impl Iterator<Item = &'a Prepared> + Clone,
        simulations: &[(&'static str, Option<&Plant<f64>>)],
        settling: f64,
    ) -> Self {
        let scored = |e: &'a Prepared| {
            let settles = move |t: f64| t >= e.contact && t < e.contact + settling;
            e.pose.iter().map(move |p| !settles(p.t))
        };
        let seen = episodes.clone().flat_map(|e| e.pose.iter().map(|p| p.pose)).collect();
        let mut groups = vec![("observed", seen)];
        for (name, plant) in simulations {
            let simulate = |e: &Prepared| match plant {
                Some(plant) => open_loop(plant, e),
                None => vec![[f64::NAN; 3]; e.pose.len()],
            };
            groups.push((name, episodes.clone().flat_map(simulate).collect()));
        }
        Self {
            episode: episodes
                .clone()
                .flat_map(|e| std::iter::repeat_n(e.name.clone(), e.pose.len()))
                .collect(),
            scored: episodes.clone().flat_map(scored).collect(),
            t: episodes.flat_map(|e| e.pose.iter().map(|p| p.t)).collect(),
            groups,
        }
    }

    /// Recorded poses, and named groups of poses that were simulated elsewhere, one for each recorded pose.
    /// Rows within `settling` seconds after contact are not scored.
    pub(crate) fn simulated<'a>(
        episodes: impl Iterator<Item = &'a Prepared> + Clone,
        groups: Vec<(&'static str, Vec<[f64; 3]>)>,
        settling: f64,
    ) -> Self {
        let mut all = Self::new(episodes, &[], settling);
        all.groups.extend(groups);
        all
    }

    /// Name of the episode of each row.
    pub fn episode(&self) -> &[String] {
        &self.episode
    }

    /// Time of each row, s.
    pub fn t(&self) -> &[f64] {
        &self.t
    }

    /// Whether each row counts in the metrics.
    pub fn scored(&self) -> &[bool] {
        &self.scored
    }

    /// Poses of each group by its name: m, m, rad, world; NaN if there is no simulation.
    pub fn groups(&self) -> impl Iterator<Item = (&'static str, &[[f64; 3]])> {
        self.groups.iter().map(|(name, poses)| (*name, poses.as_slice()))
    }

    /// Write as Parquet: `episode`, `t` in s, `scored`, and `NAME_x`, `NAME_y`, `NAME_theta` of each group.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), Error> {
        let axes = ["x", "y", "theta"];
        let titles: Vec<String> =
            self.groups.iter().flat_map(|(name, _)| axes.map(|axis| format!("{name}_{axis}"))).collect();
        let cells: Vec<Vec<f64>> = self
            .groups
            .iter()
            .flat_map(|(_, poses)| [0, 1, 2].map(|k| poses.iter().map(|p| p[k]).collect()))
            .collect();
        let mut columns = vec![("episode", Column::Texts(&self.episode)), ("t", Column::Numbers(&self.t))];
        columns.push(("scored", Column::Flags(&self.scored)));
        columns.extend(titles.iter().map(String::as_str).zip(cells.iter().map(|c| Column::Numbers(c))));
        write_parquet(path, &columns)
    }
}

/// Open-loop predictions of some episodes by a model without free values.
///
/// # Errors
/// If a value is free.
pub fn predict<'a>(
    episodes: impl Iterator<Item = &'a Prepared> + Clone,
    model: &Model,
) -> Result<Predictions, InferError> {
    Ok(Predictions::new(episodes, &[("predicted", Some(&model.resolved()?))], unscored_time(model)))
}

/// Error metrics of a model without free values on the training and the held-out episodes; `None` without episodes.
///
/// # Errors
/// If a value is free.
pub fn prediction_scores(data: &Dataset, model: &Model) -> Result<[Option<Score>; 2], InferError> {
    let values = model.values_with(&BTreeMap::new())?;
    let (channels, quasi_static) = (Channels::of(&data.noise), is_quasi_static(data));
    let of = |episodes: &[Prepared]| {
        let scored = || score(model, &values, &channels, episodes, &data.noise, quasi_static);
        (!episodes.is_empty()).then(scored).transpose()
    };
    Ok([of(&data.training)?, of(&data.held_out)?])
}
