"""The state from which an interrupted training continues with the same result; needs `trundle[rl]`."""

from __future__ import annotations

import random
from typing import Any

import numpy as np
import torch
from sb3_contrib import RecurrentPPO
from sb3_contrib.common.recurrent.type_aliases import RNNStates
from stable_baselines3 import HerReplayBuffer

from trundle.experiments.training import hindsight
from trundle.experiments.training.networks import is_off_policy
from trundle.experiments.training.rma import RMA
from trundle.experiments.training.worlds import Worlds, pick_attributes, set_attributes

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
LSTM_STATES = "_last_lstm_states"
EPISODE_STARTS = "_current_ep_start"
"""Attribute of `HerReplayBuffer`."""
BUFFER_ARRAYS = ("observations", "next_observations", "actions", "rewards", "dones", "timeouts")
"""Arrays of a replay buffer; the first axis is filled from the start."""


def state(learner: Any, worlds: Worlds) -> dict[str, Any]:
    """Return the state between two rollouts: networks, optimisers, replay buffer, worlds, random numbers."""
    found = {
        "networks": learner.get_parameters(),
        "counters": pick_attributes(learner, COUNTERS),
        "worlds": worlds.state(),
        "random": (random.getstate(), np.random.get_state(), torch.get_rng_state()),
        "random_cuda": torch.cuda.get_rng_state_all() if torch.cuda.is_available() else [],
        "sampling": learner.action_space.np_random.bit_generator.state,
    }
    if isinstance(learner, RecurrentPPO):
        found["memory"] = [tuple(pair) for pair in getattr(learner, LSTM_STATES)]
    if isinstance(learner, RMA):
        found["memory"] = learner.memory_state
    if is_off_policy(learner):
        buffer = learner.replay_buffer
        filled = buffer.buffer_size if buffer.full else buffer.pos
        arrays = {name: array[:filled] for name, array in buffer_arrays(buffer).items()}
        found["buffer"] = (buffer.pos, buffer.full, arrays)
        if isinstance(buffer, HerReplayBuffer):
            found["episodes"] = getattr(buffer, EPISODE_STARTS)
        if learner.ent_coef_optimizer is not None:
            found["log_ent_coef"] = learner.log_ent_coef.detach()
    return found


def buffer_arrays(buffer: Any) -> dict[str, Any]:
    """Return the arrays of a replay buffer; an array in a dictionary has the name "observations.KEY"."""
    names = BUFFER_ARRAYS + (hindsight.BUFFER_ARRAYS if isinstance(buffer, HerReplayBuffer) else ())
    found: dict[str, Any] = {}
    for name in names:
        value = getattr(buffer, name)
        inner = value.items() if isinstance(value, dict) else ()
        found |= {f"{name}.{key}": one for key, one in inner} if inner else {name: value}
    return found


def restore(learner: Any, worlds: Worlds, found: dict[str, Any]) -> None:
    """Restore a new algorithm and its worlds to a state."""
    learner.set_parameters(found["networks"], device=learner.device)
    set_attributes(learner, found["counters"])
    worlds.restore(found["worlds"])
    if isinstance(learner, RecurrentPPO):
        pairs = (tuple(one.to(learner.device) for one in pair) for pair in found["memory"])
        setattr(learner, LSTM_STATES, RNNStates(*pairs))
    if isinstance(learner, RMA):
        learner.memory_state = tuple(one.to(learner.device) for one in found["memory"])
    if is_off_policy(learner):
        buffer = learner.replay_buffer
        buffer.pos, buffer.full, arrays = found["buffer"]
        whole = buffer_arrays(buffer)
        for name, filled in arrays.items():
            whole[name][: len(filled)] = filled
        if isinstance(buffer, HerReplayBuffer):
            setattr(buffer, EPISODE_STARTS, found["episodes"])
        if learner.ent_coef_optimizer is not None:
            learner.log_ent_coef.data.copy_(found["log_ent_coef"])
    learner.action_space.np_random.bit_generator.state = found["sampling"]
    python, numpy, torch_state = found["random"]
    random.setstate(python)
    np.random.set_state(numpy)
    torch.set_rng_state(torch_state)
    if torch.cuda.is_available():
        torch.cuda.set_rng_state_all(found["random_cuda"])
