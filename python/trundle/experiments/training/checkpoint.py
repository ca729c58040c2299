"""The state from which an interrupted training continues with the same result; needs `trundle[rl]`."""

from __future__ import annotations

import random
from typing import Any

import numpy as np
import torch
from stable_baselines3 import SAC

from trundle.experiments.training.networks import Algorithm
from trundle.experiments.training.worlds import Worlds, pick_attributes

__all__ = ["restore", "state"]

COUNTERS = (
    "num_timesteps",
    "_n_updates",
    "_episode_num",
    "_current_progress_remaining",
    "_last_obs",
    "_last_original_obs",
    "_last_episode_starts",
    "ep_info_buffer",
    "ep_success_buffer",
)
BUFFER_ARRAYS = ("observations", "next_observations", "actions", "rewards", "dones", "timeouts")
"""Arrays of a replay buffer; the first axis is filled from the start."""


def state(learner: Algorithm, worlds: Worlds) -> dict[str, Any]:
    """Return the state between two rollouts: networks, optimisers, replay buffer, worlds, random numbers."""
    found = {
        "networks": learner.get_parameters(),
        "counters": pick_attributes(learner, COUNTERS),
        "worlds": worlds.state(),
        "random": (random.getstate(), np.random.get_state(), torch.get_rng_state()),
        "sampling": learner.action_space.np_random.bit_generator.state,
    }
    if isinstance(learner, SAC):
        buffer = learner.replay_buffer
        filled = buffer.buffer_size if buffer.full else buffer.pos
        arrays = {name: getattr(buffer, name)[:filled] for name in BUFFER_ARRAYS}
        found["buffer"] = (buffer.pos, buffer.full, arrays)
        if learner.ent_coef_optimizer is not None:
            found["log_ent_coef"] = learner.log_ent_coef.detach()
    return found


def restore(learner: Algorithm, worlds: Worlds, found: dict[str, Any]) -> None:
    """Restore a new algorithm and its worlds to a state."""
    learner.set_parameters(found["networks"], device="cpu")
    vars(learner).update(found["counters"])
    worlds.restore(found["worlds"])
    if isinstance(learner, SAC):
        buffer = learner.replay_buffer
        buffer.pos, buffer.full, arrays = found["buffer"]
        for name, filled in arrays.items():
            getattr(buffer, name)[: len(filled)] = filled
        if learner.ent_coef_optimizer is not None:
            learner.log_ent_coef.data.copy_(found["log_ent_coef"])
    learner.action_space.np_random.bit_generator.state = found["sampling"]
    python, numpy, torch_state = found["random"]
    random.setstate(python)
    np.random.set_state(numpy)
    torch.set_rng_state(torch_state)
