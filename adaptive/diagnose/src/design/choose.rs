//! The best push: the coarse net, then the neighbours of the best, until none is better.

use super::bench::{Bench, Instruments};
use super::imagine::{imagine, within_limits};
use super::library::{neighbours, net};
use super::push::Push;
use super::rival::Rival;
use super::separation::{Quadratic, refit};
use rayon::prelude::*;
use trundle_infer::{InferError, Watch, open_loop};
use trundle_model::Plant;
use trundle_record::Prepared;

/// Poses a second that sort pushes: six of the filter's longest steps from one to the next.
pub(super) const SORTING_RATE: f64 = 21.0;
/// Shares of the longest push that are tried until one keeps all limits.
const SHORTER: [f64; 3] = [1.0, 0.5, 0.25];
/// A neighbour must be better by this share.
const BETTER: f64 = 0.02;
/// Pushes that part the models by less are of no use, nats.
pub(super) const LEAST: f64 = 0.05;
/// So many nats are about what makes a name sure; beyond them more is worth ever less.
const PLENTY: f64 = 10.0;

/// What a set of pushes does: the second model's errors if the first is true, and the other way about.
#[derive(Clone, Debug)]
pub(super) struct Ledger([Quadratic; 2]);

impl Ledger {
    /// No push yet.
    pub fn empty(rivals: &[&Rival; 2]) -> Self {
        Self([Quadratic::none(rivals[1]), Quadratic::none(rivals[0])])
    }

    fn plus(&self, other: &Self) -> Self {
        Self([self.0[0].plus(&other.0[0]), self.0[1].plus(&other.0[1])])
    }

    /// The separations: if the first model is true, and if the second is, nats.
    fn separations(&self, rivals: &[&Rival; 2]) -> [f64; 2] {
        [self.0[0].separation(rivals[1]), self.0[1].separation(rivals[0])]
    }

    /// Mean of the two separations, nats.
    pub fn separation(&self, rivals: &[&Rival; 2]) -> f64 {
        self.separations(rivals).iter().sum::<f64>() / 2.0
    }

    /// What they are worth: either is to be large, so that it does not matter which model is true.
    fn worth(&self, rivals: &[&Rival; 2]) -> f64 {
        self.separations(rivals).iter().map(|separation| (separation / PLENTY).ln_1p()).sum()
    }
}

/// A push that was tried.
#[derive(Clone, Debug)]
pub(super) struct Trial {
    pub push: Push,
    /// Of this push alone.
    pub alone: f64,
    /// What it adds to the pushes before, times how readily it is made.
    worth: f64,
    /// Together with the pushes before.
    pub together: f64,
    pub ledger: Ledger,
}

/// Looks for pushes that tell two models apart.
pub(super) struct Search<'a> {
    bench: &'a Bench,
    rivals: [&'a Rival; 2],
    plants: [Plant<f64>; 2],
    sorting: Instruments,
    watch: &'a dyn Watch,
}

impl<'a> Search<'a> {
    pub fn new(bench: &'a Bench, rivals: [&'a Rival; 2], watch: &'a dyn Watch) -> Result<Self, InferError> {
        let plants = [rivals[0].plant()?, rivals[1].plant()?];
        Ok(Self { bench, rivals, plants, sorting: bench.instruments.thinned(SORTING_RATE), watch })
    }

    /// The push that adds most to those before; `None` where none tells anything.
    pub fn best(&self, before: &Ledger, ordinal: usize) -> Result<Option<Trial>, InferError> {
        let mut best = None;
        // What drifts by itself leaves the room that there is in a long push, however weak.
        for share in SHORTER {
            let shorter = |push: Push| Push { duration: share * push.duration, ..push };
            let pushes: Vec<Push> = net(self.bench).into_iter().map(shorter).collect();
            best = self.better(best, &pushes, before, ordinal)?;
            if best.is_some() {
                break;
            }
        }
        for fine in [false, true] {
            for _ in 0..self.bench.rounds {
                let Some(now) = &best else { return Ok(None) };
                let near = neighbours(self.bench, &now.push, fine);
                let was = now.worth;
                best = self.better(best, &near, before, ordinal)?;
                if best.as_ref().is_none_or(|b| b.worth == was) {
                    break;
                }
            }
        }
        Ok(best.filter(|b| b.together - before.separation(&self.rivals) > LEAST))
    }

    /// The better of a push and the best of some others.
    fn better(
        &self,
        best: Option<Trial>,
        pushes: &[Push],
        before: &Ledger,
        ordinal: usize,
    ) -> Result<Option<Trial>, InferError> {
        if self.watch.cancelled() {
            return Err(InferError::Interrupted);
        }
        let tried: Vec<Option<Trial>> =
            pushes.par_iter().map(|push| self.tried(push, before, ordinal)).collect::<Result<_, _>>()?;
        let ahead = |best: Option<Trial>, next: Trial| match best {
            Some(best) if next.worth <= (1.0 + BETTER) * best.worth => Some(best),
            _ => Some(next),
        };
        Ok(tried.into_iter().flatten().fold(best, ahead))
    }

    fn tried(&self, push: &Push, before: &Ledger, ordinal: usize) -> Result<Option<Trial>, InferError> {
        let [first, second] = &self.plants;
        let moves = [first, second].map(|plant| |episode: &Prepared| Ok(open_loop(plant, episode)));
        let Some(push) = within_limits(&[&moves[0], &moves[1]], push, self.bench)? else { return Ok(None) };
        let errors = |truth: &Plant<f64>, other: &Rival| {
            let episode = imagine(truth, &push, &self.sorting, ordinal);
            Quadratic::of(other, other.point(), &[episode], &self.sorting.noise)
        };
        let (Some(forth), Some(back)) = (errors(first, self.rivals[1])?, errors(second, self.rivals[0])?)
        else {
            return Ok(None);
        };
        let own = Ledger([forth, back]);
        let ledger = before.plus(&own);
        let (alone, together) = (own.separation(&self.rivals), ledger.separation(&self.rivals));
        let gain = ledger.worth(&self.rivals) - before.worth(&self.rivals);
        let worth = push.ease(self.bench.stands[2]) * gain;
        Ok(worth.is_finite().then_some(Trial { push, alone, worth, together, ledger }))
    }

    /// The separations that some pushes bring with the other model truly refitted: if the first is true, if the second.
    pub fn refitted(&self, pushes: &[Push]) -> Result<[f64; 2], InferError> {
        let of = |truth: usize| {
            let one = |(k, push): (usize, &Push)| {
                imagine(&self.plants[truth], push, &self.bench.instruments, self.bench.recorded + k)
            };
            let episodes: Vec<Prepared> = pushes.iter().enumerate().map(one).collect();
            refit(self.rivals[1 - truth], &episodes, &self.bench.instruments)
        };
        Ok([of(0)?, of(1)?])
    }
}
