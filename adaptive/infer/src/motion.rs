//! Likelihood of the motion under the recorded wrench (eq. 5, 6), by prediction errors of a filter.

use crate::brent::best_factor;
use crate::filter::{EpisodeFilter, FilterRun, Innovation, Residual, Response, filter};
use crate::likelihood::{Evaluation, Likelihood, Linearised};
use crate::resting_readings::RestingReadings;
use crate::{Channels, InferError, Track, sensitivity};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use std::sync::Arc;
use trundle_model::{Model, transport};
use trundle_record::{Noise, Prepared};

/// Likelihood of the poses given the recorded wrench. The noise of the wrench drives the motion, and the tare
/// is uncertain in each episode.
#[derive(Clone)]
pub struct MotionLikelihood {
    tracks: Arc<[Track]>,
    /// The same episodes in longer steps.
    thinned: Arc<[Track]>,
    coarse: Option<Arc<MotionLikelihood>>,
    resting: RestingReadings,
    channels: Channels,
    /// Factor on the pose noise, in addition to that in `channels`.
    pose_noise_factor: f64,
    /// Least random walk of the model discrepancy: N/√s, N/√s, N·m/√s.
    wander: [f64; 3],
    /// Random walk that changes by the recorded wrench (root mean square) over an episode.
    recorded_wander: [f64; 3],
    stated: bool,
}

/// Range of factors on the initial guess of unstated noise, of readings and of poses.
const READING_NOISE_FACTORS: (f64, f64) = (0.02, 50.0);
const POSE_NOISE_FACTORS: (f64, f64) = (0.3, 3.0);

/// Factor on the pose noise in a first search from distant starts. With weak corrections by the poses, the
/// error of the simulation grows along a whole push and gives a smooth path to the wheel. With full
/// corrections the density has many local optima.
const DISTANT_POSE_NOISE_FACTOR: f64 = 300.0;
/// Duration of each push in that search, s: over minutes such a simulation diverges.
const DISTANT_SEARCH_S: f64 = 8.0;

/// Up to three episodes, evenly spaced.
fn subset(tracks: &[Track]) -> impl Iterator<Item = &Track> {
    let every = tracks.len().div_ceil(3).max(1);
    tracks.iter().step_by(every)
}

/// Random walk that changes by the recorded wrench (root mean square) over an episode of mean duration.
fn recorded_wander(episodes: &[Prepared]) -> [f64; 3] {
    let readings = || episodes.iter().flat_map(|e| e.wrench.iter().filter(|w| w.t >= e.contact));
    let mut sum = [0.0; 3];
    for sample in readings() {
        let [x, y, torque] = transport(sample.reading, sample.frame);
        sum = [sum[0] + 0.5 * (x * x + y * y), sum[1] + 0.5 * (x * x + y * y), sum[2] + torque * torque];
    }
    let count = readings().count().max(1) as f64;
    let pushed = episodes.iter().filter_map(|e| Some(e.pose.last()?.t - e.contact).filter(|&t| t > 0.0));
    let duration = pushed.clone().sum::<f64>() / pushed.count().max(1) as f64;
    sum.map(|sum| if duration > 0.0 { (sum / count / duration).sqrt() } else { 0.0 })
}

impl MotionLikelihood {
    /// Likelihood of the given episodes.
    ///
    /// # Errors
    /// When an episode is too short.
    pub fn new(episodes: &[Prepared], noise: &Noise) -> Result<Self, InferError> {
        let fine = episodes.iter().map(|e| Track::new(e, noise)).collect::<Result<Vec<_>, _>>()?;
        let thinned = episodes.iter().map(|e| Track::coarse(e, noise)).collect::<Result<Vec<_>, _>>()?;
        let recorded_wander = recorded_wander(episodes);
        let of = |tracks: Vec<Track>, pose_noise_factor, coarse: Option<Self>| Self {
            resting: RestingReadings::default(),
            tracks: tracks.into(),
            thinned: [].into(),
            coarse: coarse.map(Arc::new),
            channels: Channels::of(noise).scaled(pose_noise_factor, 1.0),
            pose_noise_factor,
            wander: [0.0; 3],
            recorded_wander,
            stated: noise.stated,
        };
        let distant = of(
            subset(&thinned).map(|t| t.until(t.start + DISTANT_SEARCH_S)).collect(),
            DISTANT_POSE_NOISE_FACTOR,
            None,
        );
        let coarse = of(subset(&thinned).cloned().collect(), 1.0, Some(distant));
        let resting = RestingReadings::new(episodes, noise);
        Ok(Self { thinned: thinned.into(), resting, ..of(fine, 1.0, Some(coarse)) })
    }

    /// The same likelihood with a random-walk wrench that changes by `share` of the recorded wrench over an
    /// episode. Without it the density has many local optima far from the best one, because errors of the simulated
    /// velocity persist.
    #[must_use]
    pub fn softened(&self, share: f64) -> Self {
        let wander = self.recorded_wander.map(|size| share * size);
        Self { wander, ..self.clone() }.with_channels(self.channels)
    }

    /// The same likelihood in steps three times as long, where available, for ranking candidates.
    #[must_use]
    pub fn thinned(&self) -> Self {
        let tracks = if self.thinned.is_empty() { &self.tracks } else { &self.thinned };
        Self { tracks: tracks.clone(), ..self.clone() }
    }

    /// The same likelihood with other noise.
    #[must_use]
    pub fn with_channels(&self, channels: Channels) -> Self {
        let coarse = self.coarse.as_ref().map(|c| Arc::new(c.with_channels(channels)));
        let wander = [0, 1, 2].map(|k| channels.wander[k].max(self.wander[k]));
        let channels = Channels { wander, ..channels.scaled(self.pose_noise_factor, 1.0) };
        Self { channels, coarse, ..self.clone() }
    }

    /// The same likelihood over a subset of the episodes.
    #[must_use]
    pub fn only(&self, keep: impl Fn(usize) -> bool) -> Self {
        let kept = |tracks: &[Track]| {
            tracks.iter().enumerate().filter(|(k, _)| keep(*k)).map(|(_, t)| t.clone()).collect()
        };
        let resting = self.resting.only(&keep);
        Self { tracks: kept(&self.tracks), thinned: kept(&self.thinned), resting, ..self.clone() }
    }

    /// The episodes.
    pub fn tracks(&self) -> &[Track] {
        &self.tracks
    }

    /// Whether the recording states its noise.
    pub fn noise_is_stated(&self) -> bool {
        self.stated
    }

    /// Innovations of each episode; `None` if the model cannot be evaluated.
    ///
    /// # Errors
    /// When `values` has the wrong length.
    pub fn innovations(
        &self,
        model: &Model,
        values: &[f64],
    ) -> Result<Option<Vec<Vec<Innovation>>>, InferError> {
        let filter = self.filter(model, values)?;
        let run = |track| filter.run(track).map(|found| found.innovations);
        Ok(self.tracks.par_iter().map(run).collect())
    }

    /// Missing wrench along each episode, estimated as a random walk.
    ///
    /// # Errors
    /// When `values` has the wrong length.
    pub fn residuals(&self, model: &Model, values: &[f64]) -> Result<Option<Vec<Vec<Residual>>>, InferError> {
        let filter = self.filter(model, values)?;
        Ok(self.tracks.par_iter().map(|t| filter.smooth(t)).collect())
    }

    /// Each episode as a linear system: the effect of a missing wrench on the innovations.
    ///
    /// # Errors
    /// When `values` has the wrong length.
    pub fn responses(&self, model: &Model, values: &[f64]) -> Result<Option<Vec<Response>>, InferError> {
        let filter = self.filter(model, values)?;
        Ok(self.tracks.par_iter().map(|t| filter.response(t)).collect())
    }

    /// Maps the tracks on all cores; a single track runs on the calling thread.
    fn map_tracks<T: Send>(&self, of: impl Fn(usize, &Track) -> T + Sync + Send) -> Vec<T> {
        match &*self.tracks {
            [single] => vec![of(0, single)],
            tracks => tracks.par_iter().enumerate().map(|(k, track)| of(k, track)).collect(),
        }
    }

    fn filter(&self, model: &Model, values: &[f64]) -> Result<Box<dyn EpisodeFilter>, InferError> {
        filter(model, values, &self.channels)
    }
}

/// Filter results of each episode under one model, for linearising other models around it.
pub struct FilteredEpisodes<'a> {
    tracks: &'a [Track],
    runs: Vec<FilterRun>,
}

impl MotionLikelihood {
    /// Filters the episodes with a model; `None` if the model cannot be evaluated.
    ///
    /// # Errors
    /// When `values` has the wrong length.
    pub fn filtered(
        &self,
        model: &Model,
        values: &[f64],
    ) -> Result<Option<FilteredEpisodes<'_>>, InferError> {
        let filter = self.filter(model, values)?;
        let runs: Option<Vec<_>> = self.tracks.par_iter().map(|t| filter.run(t)).collect();
        Ok(runs.map(|runs| FilteredEpisodes { tracks: &self.tracks, runs }))
    }
}

impl FilteredEpisodes<'_> {
    /// Whitened innovations of all episodes, in order.
    pub fn residual(&self) -> DVector<f64> {
        let all: Vec<f64> =
            self.runs.iter().flat_map(|p| sensitivity::whitened(p).as_slice().to_vec()).collect();
        DVector::from_vec(all)
    }

    /// Derivatives of the innovations by the slots `free`, one matrix for each episode with three rows for
    /// each pose sample and one column for each slot. The filter's gains are held fixed. At `values`, `model`
    /// must behave as the filtered model.
    ///
    /// # Errors
    /// When `values` has the wrong length.
    pub fn slopes(
        &self,
        model: &Model,
        values: &[f64],
        free: &[usize],
    ) -> Result<Vec<DMatrix<f64>>, InferError> {
        let of = |(track, run)| sensitivity::slopes(model, values, free, track, run);
        self.tracks.par_iter().zip(&self.runs).map(of).collect()
    }
}

impl Likelihood for MotionLikelihood {
    fn cost(&self, model: &Model, values: &[f64]) -> Result<f64, InferError> {
        let filter = self.filter(model, values)?;
        let one = |_, track: &Track| filter.cost(track).unwrap_or(f64::INFINITY);
        let moving: f64 = self.map_tracks(one).into_iter().sum();
        Ok(moving + self.resting.cost(model, values)?)
    }

    fn linearise(&self, model: &Model, values: &[f64], free: &[usize]) -> Result<Linearised, InferError> {
        self.evaluate(model, values, free, true)?.linearise()
    }

    /// The filter run is kept for the derivatives.
    fn evaluate<'a>(
        &'a self,
        model: &'a Model,
        values: &[f64],
        free: &'a [usize],
        _likely: bool,
    ) -> Result<Evaluation<'a>, InferError> {
        let filter = self.filter(model, values)?;
        let runs = self.map_tracks(|_, track| filter.run(track));
        let moving: f64 = runs.iter().map(|p| p.as_ref().map_or(f64::INFINITY, FilterRun::cost)).sum();
        let cost = moving + self.resting.cost(model, values)?;
        let values = values.to_vec();
        Ok(Evaluation::new(cost, move || {
            let part = |k: usize, track: &Track| match runs.get(k).and_then(Option::as_ref) {
                Some(run) => sensitivity::linearise(model, &values, free, track, run),
                None => Ok(Linearised { cost: f64::INFINITY, ..Linearised::sum(free.len(), []) }),
            };
            let mut parts = self.map_tracks(part).into_iter().collect::<Result<Vec<_>, InferError>>()?;
            parts.push(self.resting.linearise(model, &values, free)?);
            Ok(Linearised::sum(free.len(), parts))
        }))
    }

    fn chi_squared(&self, model: &Model, values: &[f64]) -> Result<(f64, usize), InferError> {
        let all = self.innovations(model, values)?.unwrap_or_default();
        let directions = |i: &Innovation| (0..3).filter(|&k| i.whitener[(k, k)] > 0.0).count();
        Ok(all.iter().flatten().fold((0.0, 0), |(sum, count), i| {
            (sum + (i.whitener * i.error).norm_squared(), count + directions(i))
        }))
    }

    fn channels(&self) -> Channels {
        self.channels
    }

    fn split(&self) -> Vec<(String, Box<dyn Likelihood + '_>)> {
        let one = |(k, track): (usize, &Track)| {
            let single: Box<dyn Likelihood> = Box::new(self.only(|other| other == k));
            (track.name.clone(), single)
        };
        self.tracks.iter().enumerate().map(one).collect()
    }

    fn coarse(&self) -> Option<&dyn Likelihood> {
        self.coarse.as_ref().map(|c| &**c as &dyn Likelihood)
    }

    fn tuned(&self, model: &Model, values: &[f64]) -> Result<Option<Box<dyn Likelihood + '_>>, InferError> {
        if self.stated {
            return Ok(None);
        }
        Ok(Some(Box::new(self.with_tuned_noise(model, values)?)))
    }
}

impl MotionLikelihood {
    /// The same likelihood with noise factors that maximise it at the given values: first that of the
    /// readings, then that of the poses.
    ///
    /// # Errors
    /// When `values` has the wrong length.
    pub fn with_tuned_noise(&self, model: &Model, values: &[f64]) -> Result<Self, InferError> {
        let tried = |pose, reading| self.with_channels(self.channels.scaled(pose, reading));
        let reading = best_factor(&|f| tried(1.0, f).cost(model, values), READING_NOISE_FACTORS)?;
        let pose = best_factor(&|f| tried(f, reading).cost(model, values), POSE_NOISE_FACTORS)?;
        Ok(tried(pose, reading))
    }
}
