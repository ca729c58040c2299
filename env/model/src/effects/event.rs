//! Something that happens at one moment, for good: the time that the laws of events share.

use super::{choice, signed};
use crate::Real;
use crate::law::{Clock, Param, Prior, Role};

/// Ordinal of the episode in which it happens.
pub(crate) const fn episode() -> Param {
    choice("episode", "ordinal of the episode in which it happens, from 0, held-out ones counted too")
}

/// When in that episode it happens, s of the recording's own time.
pub(crate) const fn time() -> Param {
    let time = signed("time", "s", 1e5, 3.0, "when it happens, the table's t");
    Param { lower: 0.0, prior: Prior::Normal { mean: 3.0, sd: 3.0 }, role: Role::Time, ..time }
}

/// The moment.
#[derive(Clone, Debug)]
pub(crate) struct Event<T> {
    episode: f64,
    time: T,
}

impl<T: Real> Event<T> {
    pub fn new(episode: T, time: T) -> Self {
        Self { episode: episode.re(), time }
    }

    /// Share of the step that lies after it.
    #[inline]
    pub fn fraction_after(&self, clock: Clock) -> T {
        clock.fraction_after(self.episode, self.time)
    }
}
