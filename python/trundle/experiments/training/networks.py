"""Algorithms from settings, and export of their policies; needs `trundle[rl]`."""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
import torch
from sb3_contrib import TQC, CrossQ, RecurrentPPO
from stable_baselines3 import PPO, SAC, HerReplayBuffer

from trundle.envs.oracle import Oracle
from trundle.experiments.training import hindsight
from trundle.experiments.training.network import Network
from trundle.experiments.training.policy import About, Policy
from trundle.experiments.training.rma import RMA
from trundle.experiments.training.settings import SEED_STRIDE, Settings
from trundle.experiments.training.torch_arrays import layers_of, memory_of
from trundle.experiments.training.worlds import Worlds

__all__ = ["Algorithm", "algorithm", "exported", "is_off_policy"]

Algorithm: TypeAlias = PPO | RecurrentPPO | SAC | TQC | CrossQ | RMA
ALGORITHMS = {kind.__name__: kind for kind in (PPO, RecurrentPPO, SAC, TQC, CrossQ)} | {"HER": SAC}
ACTIVATIONS = {"tanh": torch.nn.Tanh, "relu": torch.nn.ReLU}


def algorithm(settings: Settings, seed: int, worlds: Worlds, device: str = "cpu") -> Algorithm:
    """Return an untrained algorithm on a device of PyTorch."""
    arguments, network = settings.hyperparameters, settings.network
    for key, value in arguments.items():
        if isinstance(value, str) and value.startswith("lin_"):
            arguments[key] = linear_schedule(float(value.removeprefix("lin_")))
    common = {"env": worlds.top, "seed": seed * SEED_STRIDE, "device": device}
    if settings.algorithm == "RMA":
        teacher = arguments.pop("teacher").replace("{seed}", str(seed))
        return RMA(teacher=teacher, **common, **{k: v for k, v in arguments.items() if k != "policy"})
    if "activation_fn" in network:
        network["activation_fn"] = ACTIVATIONS[network["activation_fn"]]
    if settings.algorithm == "HER":
        keys = ("n_sampled_goal", "goal_selection_strategy")
        arguments["replay_buffer_kwargs"] = {key: arguments.pop(key) for key in keys}
        arguments["replay_buffer_class"] = HerReplayBuffer
    return ALGORITHMS[settings.algorithm](policy_kwargs=network, **common, **arguments)


def is_off_policy(learner: Algorithm) -> bool:
    """Return whether an algorithm has a replay buffer; its actions are then squashed."""
    return isinstance(learner, SAC | TQC | CrossQ)


def linear_schedule(most: float) -> Any:
    """Return a linear schedule from `most` to zero over the training."""
    return lambda remaining: most * remaining


def exported(settings: Settings, seed: int, learner: Algorithm, worlds: Worlds) -> Policy:
    """Return the current policy in a form that needs NumPy only."""
    revealed = len(Oracle.NAMES) if settings.privileged else 0
    hidden = 0 if isinstance(learner, RMA) else revealed
    network = network_of(settings, learner)
    mean, deviation, clip = learner.normalisation() if isinstance(learner, RMA) else normalisation(worlds)
    space = worlds.batch.observation_space
    observed = space.shape[0] if space.shape else hindsight.entry_count(space.spaces)
    about = About(
        config=settings.name,
        digest=settings.digest,
        algorithm=settings.algorithm,
        seed=seed,
        steps=int(learner.num_timesteps),
        env=settings.env,
        env_kwargs=settings.env_kwargs,
        entries=observed - revealed + hidden,
        frame=settings.frame,
        frame_stack=settings.frame_stack,
        activation=network.activation,
        squashed=is_off_policy(learner),
        clip_obs=float(clip),
        hidden=hidden,
    )
    return Policy(about, mean, deviation, network)


def network_of(settings: Settings, learner: Algorithm) -> Network:
    """Return the network from observations to mean actions."""
    if isinstance(learner, RMA):
        return learner.network()
    policy = learner.policy
    if is_off_policy(learner):
        modules = [*policy.actor.latent_pi, policy.actor.mu]
    else:
        modules = [*policy.mlp_extractor.policy_net, policy.action_net]
    layers = layers_of(modules)
    if settings.algorithm == "HER":
        layers[0] = hindsight.flat_layer(layers[0], learner.observation_space.spaces)
    memory = memory_of(policy.lstm_actor) if isinstance(learner, RecurrentPPO) else None
    default = "relu" if is_off_policy(learner) else "tanh"
    return Network(layers, settings.network.get("activation_fn", default), memory)


def normalisation(worlds: Worlds) -> tuple[Any, Any, float]:
    """Return mean, deviation and limit of the inputs of a network."""
    space, normalize = worlds.top.observation_space, worlds.normalize
    if normalize is None:
        inputs = space.shape[0] if space.shape else hindsight.entry_count(space.spaces)
        return np.zeros(inputs), np.ones(inputs), np.inf
    scales = normalize.obs_rms
    if isinstance(scales, dict):
        parts = [{key: getattr(one, name) for key, one in scales.items()} for name in ("mean", "var")]
        mean, variance = map(hindsight.flat_scales, parts)
    else:
        mean, variance = scales.mean.copy(), scales.var
    return mean, np.sqrt(variance + normalize.epsilon), normalize.clip_obs
