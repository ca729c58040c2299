//! A permanent change at one time, shared by the laws of events.

use super::{choice, signed};
use crate::Real;
use crate::law::{Clock, Param, Prior, Role};

/// Index of the episode of the event.
pub(crate) const fn episode() -> Param {
    choice("episode", "index of the episode of the event, from 0; held-out episodes count")
}

/// Time of the event in its episode, s, in the time of the recording.
pub(crate) const fn time() -> Param {
    let time = signed("time", "s", 1e5, 3.0, "time of the event, in the time column of the recording");
    Param { lower: 0.0, prior: Prior::Normal { mean: 3.0, sd: 3.0 }, role: Role::Time, ..time }
}

/// Episode and time of an event.
#[derive(Clone, Debug)]
pub(crate) struct Event<T> {
    episode: f64,
    time: T,
}

impl<T: Real> Event<T> {
    pub fn new(episode: T, time: T) -> Self {
        Self { episode: episode.re(), time }
    }

    /// Fraction of the step after the event.
    #[inline]
    pub fn fraction_after(&self, clock: Clock) -> T {
        clock.fraction_after(self.episode, self.time)
    }
}
