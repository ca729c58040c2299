"""Worlds: an environment at a seed, with effects that the seed draws."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

import trundle
from trundle.experiments.comparison.config import Worlds
from trundle.picture import outlines
from trundle.recording import TrundleError

__all__ = ["boundary_points", "draw_effects", "make_world"]

Env = gym.Env[Any, Any]
PLACE_PARAMETERS = {"com_offset": ("com_x", "com_y")}
"""Parameters of a place other than x and y."""


def make_world(worlds: Worlds, seed: int, options: Mapping[str, Any]) -> tuple[Env, NDArray[np.float64]]:
    """Make a world.

    Parameters
    ----------
    worlds : Worlds
    seed : int
        Determines object, task and obstacles, whatever the effects and the meaning of actions.
    options : mapping
        Arguments of the environment that replace those of the group.

    Returns
    -------
    env : gymnasium.Env
        At the start of its episode.
    observation : ndarray
        The first observation.
    """
    chosen = {**worlds.options, **options}
    env, observation = make_env(worlds.env, chosen, seed)
    if not worlds.effect:
        return env, observation
    source: Any = env.unwrapped
    more = draw_effects(worlds.effect, source.hidden_model()["body"], seed)
    env.close()
    return make_env(worlds.env, {**chosen, "effects": [*chosen.get("effects", []), *more]}, seed)


def make_env(name: str, options: Mapping[str, Any], seed: int) -> tuple[Env, NDArray[np.float64]]:
    """Make an environment and start its episode."""
    try:
        env = gym.make(name, **options)
    except (gym.error.Error, TypeError) as error:
        raise TrundleError(f"{name} with {dict(options)}: {error}") from error
    flat = isinstance(env.observation_space, gym.spaces.Box)
    if not flat or not isinstance(env.unwrapped, trundle.envs.Push):
        raise TrundleError(f"{name}: choose a flat pushing environment, such as trundle/PushAround-v0")
    observation, _ = env.reset(seed=seed)
    return env, observation


def draw_effects(
    effects: Sequence[Mapping[str, Any]], body: Mapping[str, Any], seed: int
) -> list[dict[str, Any]]:
    """Return effects with all values given.

    Parameters
    ----------
    effects : sequence of mapping
        Tables of a `model.toml` in which a value is a number, a range `[low, high]`, or `{any = [...]}`. `at`
        is a place on the object: "foot" is one of its supports; `[low, high]` is a relative distance, in a
        random direction, from its origin to an ellipse through the extremes of its footprint along each axis.
    body : mapping
        The object, as in a `model.toml`.
    seed : int
    """
    random = np.random.default_rng(seed)
    return [draw_effect(effect, body, random) for effect in effects]


def draw_effect(
    effect: Mapping[str, Any], body: Mapping[str, Any], random: np.random.Generator
) -> dict[str, Any]:
    """Return one effect with all values given."""
    given = {key: draw_value(key, told, random) for key, told in effect.items() if key != "at"}
    if "at" in effect:
        keys = PLACE_PARAMETERS.get(effect.get("kind", ""), ("x", "y"))
        given |= zip(keys, draw_place(effect["at"], body, random), strict=True)
    return given


def draw_value(key: str, told: Any, random: np.random.Generator) -> Any:
    """Return a fixed value, a draw from a range, or one of several values."""
    if isinstance(told, Mapping) and list(told) == ["any"] and told["any"]:
        return told["any"][int(random.integers(len(told["any"])))]
    if isinstance(told, list) and is_range(told):
        return float(random.uniform(*told))
    if isinstance(told, (Mapping, list)):
        raise TrundleError(f"{key} = {told}: give a number, a range [low, high], or {{any = [...]}}")
    return told


def draw_place(told: Any, body: Mapping[str, Any], random: np.random.Generator) -> tuple[float, float]:
    """Return a place on an object, m."""
    if told == "foot":
        feet = body.get("support", [])
        if not feet:
            raise TrundleError('at = "foot": this object has no supports; give a range')
        x, y = feet[int(random.integers(len(feet)))]
        return float(x), float(y)
    if not isinstance(told, list) or not is_range(told):
        raise TrundleError(f'at = {told!r}: give "foot" or a range [low, high] of shares')
    low, high = boundary_points(body).min(axis=0), boundary_points(body).max(axis=0)
    share, angle = random.uniform(*told), random.uniform(-np.pi, np.pi)
    way = np.array([np.cos(angle), np.sin(angle)])
    # The origin need not lie in the middle: each quarter has an ellipse of its own.
    x, y = share * np.where(way > 0.0, high, -low) * way
    return float(x), float(y)


def boundary_points(body: Mapping[str, Any]) -> NDArray[np.float64]:
    """Return points (n, 2) whose hull contains an object, m, object frame."""
    return np.concatenate(outlines(body))


def is_range(told: list[Any]) -> bool:
    """Return whether a list is two numbers in order."""
    numbers = all(isinstance(one, (int, float)) and not isinstance(one, bool) for one in told)
    return len(told) == 2 and numbers and told[0] <= told[1]
