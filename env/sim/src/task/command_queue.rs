//! Commands on their way to the arm.

use std::collections::VecDeque;

use serde::{Deserialize, Serialize};

use super::constants::MAX_ACTION_WIDTH;

/// Commands in order, each with the simulation step in which it takes effect.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct CommandQueue(VecDeque<(u32, [f64; MAX_ACTION_WIDTH])>);

impl CommandQueue {
    /// An empty queue with space for `count` commands.
    pub fn with_capacity(count: usize) -> Self {
        Self(VecDeque::with_capacity(count))
    }

    /// Add a command that takes effect in the simulation step `due`.
    pub fn push(&mut self, due: u32, target: [f64; MAX_ACTION_WIDTH]) {
        self.0.push_back((due, target));
    }

    /// Remove and return the next command if it is due.
    pub fn pop_due(&mut self, tick: u32) -> Option<[f64; MAX_ACTION_WIDTH]> {
        let is_due = self.0.front().is_some_and(|(due, _)| *due <= tick);
        if is_due { self.0.pop_front().map(|(_, target)| target) } else { None }
    }
}
