//! What a foreign simulator with laws predicts, by its own answers.

use super::black_box::BlackBox;
use super::gains::Ahead;
use crate::design::{BLIND, Certificate, Simulated, of_simulations};
use crate::engine::{Engine, Tried};
use crate::outlook::{End, Outlook};
use nalgebra::Vector3;
use trundle_infer::{InferError, unscored_time};

/// Length of a prediction, s.
const WINDOW: f64 = 1.0;

impl BlackBox<'_> {
    /// The simulator predicts; how uncertain that is, by the instruments' noise, its linearisation tells.
    pub(super) fn predictions(&self, tried: &Tried) -> Result<Outlook, InferError> {
        let (along, dof, values) = (self.along(tried), self.data.dof, self.own(tried));
        let (rollout, settling) = (self.rollout(tried, &values)?, unscored_time(&tried.fit.model));
        let judged = if settling > 0.0 { settling } else { f64::NEG_INFINITY };
        let moves = |v: [f64; 3]| [0, 1, 2].map(|k| if dof[k] { v[k] } else { 0.0 });
        let mut ends = vec![];
        for (k, (path, episode)) in along.paths.iter().zip(&self.data.training).enumerate() {
            let (known, seen) = (episode.motion_so_far(&self.data.noise), rollout.seen(episode)?);
            for Ahead { from, to, covariance } in along.ahead(k, &known, WINDOW) {
                let [from, to] = [from, to].map(|k| &path.intervals[k]);
                let span = [from, to].map(|interval| interval.t + interval.span);
                if span[0] < judged + episode.contact {
                    continue;
                }
                let Some(root) = covariance.cholesky() else { continue };
                let Some(error) = rollout.ahead(&seen, span)? else { continue };
                let whitened: Vector3<f64> =
                    root.l().solve_lower_triangular(&Vector3::from(error)).unwrap_or_default();
                let motion = [0, 1, 2].map(|k| to.seen[k] - from.seen[k]);
                ends.push(End { error: moves(error), whitened: moves(whitened.into()), motion });
            }
        }
        Ok(Outlook::over(ends.into_iter(), dof, self.bare.body.gyration))
    }

    /// By simulations in open loop, beside what the instruments' noise makes of one.
    pub(super) fn compared(&self, names: [&str; 2], models: [&Tried; 2]) -> Result<Certificate, InferError> {
        let blind = self.doubting(models[0])?.with_channels(self.along.channels.scaled(BLIND, 1.0));
        let pose = self.along.channels.pose;
        let mut simulated = vec![];
        for (episode, spreads) in self.data.training.iter().zip(blind.spreads()) {
            let [a, b] = models.map(|tried| self.open_loop(tried, episode));
            let (a, b) = (a?.unwrap_or_default(), b?.unwrap_or_default());
            let at = |&(t, sd): &(f64, [f64; 3])| {
                let k = episode.pose.partition_point(|p| p.t < t - 1e-6);
                let sd = [0, 1, 2].map(|c| sd[c].hypot(pose[c]));
                Some((t, [*a.get(k)?, *b.get(k)?], sd))
            };
            let samples = spreads.iter().filter_map(at).collect();
            simulated.push(Simulated { episode: episode.name.clone(), samples });
        }
        let costs = models.map(|tried| tried.fit.cost);
        Ok(of_simulations(names, costs, &simulated, self.data.dof))
    }
}
