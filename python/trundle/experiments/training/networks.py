"""Algorithms of stable-baselines3 from settings, and export of their policies; needs `trundle[rl]`."""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
import torch
from stable_baselines3 import PPO, SAC

from trundle.experiments.training.config import SEED_STRIDE, Settings
from trundle.experiments.training.policy import About, Policy
from trundle.experiments.training.worlds import Worlds

__all__ = ["Algorithm", "algorithm", "exported"]

Algorithm: TypeAlias = PPO | SAC
ALGORITHMS = {"PPO": PPO, "SAC": SAC}
ACTIVATIONS = {"tanh": torch.nn.Tanh, "relu": torch.nn.ReLU}


def algorithm(settings: Settings, seed: int, worlds: Worlds) -> Algorithm:
    """Return an untrained algorithm."""
    arguments, network = settings.hyperparameters, settings.network
    for key, value in arguments.items():
        if isinstance(value, str) and value.startswith("lin_"):
            arguments[key] = linear_schedule(float(value.removeprefix("lin_")))
    if "activation_fn" in network:
        network["activation_fn"] = ACTIVATIONS[network["activation_fn"]]
    chosen = ALGORITHMS[settings.algorithm]
    return chosen(env=worlds.top, seed=seed * SEED_STRIDE, device="cpu", policy_kwargs=network, **arguments)


def linear_schedule(most: float) -> Any:
    """Return a linear schedule from `most` to zero over the training."""
    return lambda remaining: most * remaining


def exported(settings: Settings, seed: int, learner: Algorithm, worlds: Worlds) -> Policy:
    """Return the current policy in a form that needs NumPy only."""
    policy = learner.policy
    squashed = isinstance(learner, SAC)
    if squashed:
        modules = [*policy.actor.latent_pi, policy.actor.mu]
    else:
        modules = [*policy.mlp_extractor.policy_net, policy.action_net]
    layers = [
        (module.weight.detach().numpy().copy(), module.bias.detach().numpy().copy())
        for module in modules
        if isinstance(module, torch.nn.Linear)
    ]
    inputs = layers[0][0].shape[1]
    mean, deviation, clip = np.zeros(inputs), np.ones(inputs), np.inf
    if worlds.normalize is not None:
        scales = worlds.normalize.obs_rms
        mean, deviation = scales.mean.copy(), np.sqrt(scales.var + worlds.normalize.epsilon)
        clip = worlds.normalize.clip_obs
    about = About(
        config=settings.name,
        digest=settings.digest,
        algorithm=settings.algorithm,
        seed=seed,
        steps=int(learner.num_timesteps),
        env=settings.env,
        env_kwargs=settings.env_kwargs,
        entries=worlds.batch.observation_space.shape[0],
        frame=settings.frame,
        frame_stack=settings.frame_stack,
        activation=settings.network.get("activation_fn", "relu" if squashed else "tanh"),
        squashed=squashed,
        clip_obs=float(clip),
    )
    return Policy(about, mean, deviation, layers)
