"""Checkpoints from which an interrupted training continues with the same result."""

from __future__ import annotations

import os
import random
from pathlib import Path
from typing import Any

import numpy as np
import torch
from stable_baselines3 import SAC

from trundle._native import TrundleError
from trundle.atomic import atomic_file
from trundle.experiments.training import state_file
from trundle.experiments.training.networks import Algorithm
from trundle.experiments.training.worlds import Worlds, pick_attributes

__all__ = ["read", "restore", "state", "write"]

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
    kept = {
        "networks": learner.get_parameters(),
        "counters": pick_attributes(learner, COUNTERS),
        "worlds": worlds.state(),
        "random": (random.getstate(), np.random.get_state(), torch.get_rng_state()),
        "sampling": learner.action_space.np_random.bit_generator.state,
    }
    if isinstance(learner, SAC):
        kept["memory"] = buffer_state(learner.replay_buffer)
        if learner.ent_coef_optimizer is not None:
            kept["log_ent_coef"] = learner.log_ent_coef.detach()
    return kept


def restore(learner: Algorithm, worlds: Worlds, kept: dict[str, Any]) -> None:
    """Restore a new algorithm and its worlds to a state."""
    learner.set_parameters(kept["networks"], device="cpu")
    vars(learner).update(kept["counters"])
    worlds.restore(kept["worlds"])
    if isinstance(learner, SAC):
        memory = learner.replay_buffer
        memory.pos, memory.full, arrays = kept["memory"]
        for name, filled in arrays.items():
            getattr(memory, name)[: len(filled)] = filled
        if learner.ent_coef_optimizer is not None:
            learner.log_ent_coef.data.copy_(kept["log_ent_coef"])
    learner.action_space.np_random.bit_generator.state = kept["sampling"]
    python, numpy, torch_state = kept["random"]
    random.setstate(python)
    np.random.set_state(numpy)
    torch.set_rng_state(torch_state)


def buffer_state(memory: Any) -> tuple[int, bool, dict[str, Any]]:
    """Return the contents of a replay buffer."""
    filled = memory.buffer_size if memory.full else memory.pos
    return memory.pos, memory.full, {name: getattr(memory, name)[:filled] for name in BUFFER_ARRAYS}


def write(path: Path, kept: dict[str, Any]) -> None:
    """Write a checkpoint atomically."""
    with atomic_file(path) as part, part.open("wb") as file:
        state_file.save(file, kept)
        file.flush()
        os.fsync(file.fileno())


def read(path: Path) -> dict[str, Any] | None:
    """Return a checkpoint, or None without a file.

    Raises
    ------
    TrundleError
        If the file is not a checkpoint.
    """
    if not path.exists():
        return None
    try:
        kept: dict[str, Any] = state_file.load(path)
        return kept
    except Exception as error:  # damaged files raise various errors
        raise TrundleError(
            f"{path}: not a checkpoint ({error}): remove the file to restart the training"
        ) from error
