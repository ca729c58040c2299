"""Worlds: an environment at a seed, with effects that the seed draws."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

import trundle
from trundle._optional import require
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
    if worlds.effect:
        env = make_env(worlds.env, chosen)
        env.reset(seed=seed)
        source: Any = env.unwrapped
        more = draw_effects(worlds.effect, source.hidden_model()["body"], seed)
        env.close()
        chosen["effects"] = [*chosen.get("effects", []), *more]
    env = make_env(worlds.env, chosen)
    if worlds.simulator == "mujoco":
        require("mujoco", "mujoco", "worlds that MuJoCo simulates")
        from trundle.experiments.comparison.mujoco_plant import MujocoPlant

        env = MujocoPlant(env)
    observation, _ = env.reset(seed=seed)
    return env, observation


def make_env(name: str, options: Mapping[str, Any]) -> Env:
    """Make an environment."""
    try:
        env = gym.make(name, **options)
    except (gym.error.Error, TypeError) as error:
        raise TrundleError(f"{name} with {dict(options)}: {error}") from error
    flat = isinstance(env.observation_space, gym.spaces.Box)
    if not flat or not isinstance(env.unwrapped, trundle.envs.Push):
        raise TrundleError(f"{name}: choose a flat pushing environment, such as trundle/PushAround-v0")
    return env


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
    given = {key: draw_value(key, value, random) for key, value in effect.items() if key != "at"}
    if "at" in effect:
        keys = PLACE_PARAMETERS.get(effect.get("kind", ""), ("x", "y"))
        given |= zip(keys, draw_place(effect["at"], body, random), strict=True)
    return given


def draw_value(key: str, value: Any, random: np.random.Generator) -> Any:
    """Return a fixed value, a draw from a range, or one of several values."""
    if isinstance(value, Mapping) and list(value) == ["any"] and value["any"]:
        return value["any"][int(random.integers(len(value["any"])))]
    if is_range(value):
        return float(random.uniform(*value))
    if isinstance(value, (Mapping, list)):
        raise TrundleError(f"{key} = {value}: give a number, a range [low, high], or {{any = [...]}}")
    return value


def draw_place(place: Any, body: Mapping[str, Any], random: np.random.Generator) -> tuple[float, float]:
    """Return a place on an object, m."""
    if place == "foot":
        feet = body.get("support", [])
        if not feet:
            raise TrundleError('at = "foot": this object has no supports; give a range')
        x, y = feet[int(random.integers(len(feet)))]
        return float(x), float(y)
    if not is_range(place):
        raise TrundleError(f'at = {place!r}: give "foot" or a range [low, high] of shares')
    low, high = boundary_points(body).min(axis=0), boundary_points(body).max(axis=0)
    share, angle = random.uniform(*place), random.uniform(-np.pi, np.pi)
    direction = np.array([np.cos(angle), np.sin(angle)])
    # The origin need not lie in the middle: each quarter has an ellipse of its own.
    x, y = share * np.where(direction > 0.0, high, -low) * direction
    return float(x), float(y)


def boundary_points(body: Mapping[str, Any]) -> NDArray[np.float64]:
    """Return points (n, 2) whose hull contains an object, m, object frame."""
    return np.concatenate(outlines(body))


def is_range(value: Any) -> bool:
    """Return whether a value is a list of two numbers in order."""
    numbers = isinstance(value, list) and all(type(one) in (int, float) for one in value)
    return numbers and len(value) == 2 and bool(value[0] <= value[1])
