"""Recordings from MuJoCo agree with trundle's laws, and effects of size zero have no influence."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import tomli_w
from numpy.typing import NDArray

import trundle
from trundle.experiments.blind.family import HiddenEffect
from trundle.experiments.blind.furniture.families import FAMILIES
from trundle.experiments.blind.furniture.generator import simulate_case
from trundle.experiments.blind.furniture.scene import draw_scene
from trundle.experiments.blind.furniture.simulation import Motion, episode_table, make_recording, simulate
from trundle.experiments.blind.push import CONTACT_TIME_S, Grasp, WrenchPush
from trundle.experiments.blind.scene import Scene

EPISODES = 4
SEED = 4


@cache
def scene(seed: int = SEED) -> Scene:
    return draw_scene(seed, 0, EPISODES)


@cache
def bare(seed: int = SEED) -> tuple[Motion, ...]:
    return tuple(simulate(scene(seed), [], k) for k in range(EPISODES))


@cache
def drawn(name: str) -> tuple[int, HiddenEffect]:
    """Return a family's values in the first scene that supports it."""
    for seed in range(SEED, SEED + 20):
        paths = [one.pose for one in bare(seed)]
        values = FAMILIES[name].draw(np.random.default_rng(seed), scene(seed), paths)
        if values:
            return seed, HiddenEffect(FAMILIES[name], values)
    raise AssertionError(f"{name} finds no place")


def simulated(true: Motion, effects: list[dict[str, object]], seed: int = SEED) -> NDArray[np.float64]:
    """Return poses (n, 3) of the model under the same wrench."""
    found = scene(seed)
    body = {**found.shape.described(with_feet=True), "mass": found.mass}
    wheel = {"kind": "viscous_wheel", **vars(found.wheel)}
    text = tomli_w.dumps({"format": "trundle-model/1", "body": body, "effect": [wheel, *effects]})
    grasp = true.push.grasp
    c, s = np.cos(grasp.angle), np.sin(grasp.angle)
    force = true.wrench[:, :2] @ np.array([[c, s], [-s, c]])
    torque = true.wrench[:, 2] + grasp.x * force[:, 1] - grasp.y * force[:, 0]
    every = slice(None, None, 4)
    wrench = np.column_stack([force, torque])[every]
    model = trundle.Model.from_toml(text)
    poses, _ = model.rollout(
        list(true.push.start), [0.0, 0.0, 0.0], true.t[every] - CONTACT_TIME_S, wrench, contact=0.0
    )
    return np.asarray(poses - true.pose[every])


@pytest.mark.parametrize("seed", range(SEED, SEED + 4))
def test_a_pushed_object_follows_the_model_of_the_paper(seed: int) -> None:
    for true in bare(seed):
        assert np.ptp(true.pose[:, :2], axis=0).max() > 0.1
        off = np.abs(simulated(true, [], seed))
        assert off[:, :2].max() < 2e-3
        assert off[:, 2].max() < 4e-3


def test_the_commanded_wrench_moves_the_object() -> None:
    knots = np.array([[0.0, 0, 0, 0], [0.2, 15, 0, 3], [1.5, 15, 0, 3], [1.7, -15, 0, 0], [3, 0, 0, 0]])
    push = WrenchPush((0.2, 0.1, 0.6), Grasp(0.3, -0.2, 0.4), knots)
    true = simulate(replace(scene(), pushes=(push,)), [], 0)
    np.testing.assert_allclose(true.wrench[1000, 0], 15.0, atol=1e-6)
    assert np.ptp(true.pose[:, :2], axis=0).max() > 0.1
    assert np.abs(simulated(true, [])[:, :2]).max() < 2e-3


@pytest.mark.parametrize("name", FAMILIES)
def test_an_effect_of_size_zero_has_no_influence(name: str) -> None:
    seed, hidden = drawn(name)
    nothing = [hidden.scaled(0.0)]
    clean = episode_table(scene(seed), [], 1, bare(seed)[1])
    found = episode_table(scene(seed), nothing, 1, simulate(scene(seed), nothing, 1))
    assert clean.keys() == found.keys()
    for column, values in clean.items():
        # A small body of up to 10 g remains.
        limit = 0.05 if column.startswith(("force", "torque")) else 2e-4
        np.testing.assert_allclose(found[column], values, atol=limit, err_msg=column)


@pytest.mark.parametrize("name", FAMILIES)
def test_an_effect_of_full_size_has_an_influence(name: str) -> None:
    seed, hidden = drawn(name)

    def differs(k: int) -> bool:
        clean = episode_table(scene(seed), [], k, bare(seed)[k])
        found = episode_table(scene(seed), [hidden], k, simulate(scene(seed), [hidden], k))
        return any(not np.allclose(found[c], clean[c], atol=5e-3, equal_nan=True) for c in clean)

    assert any(differs(k) for k in range(EPISODES))


SIMPLE = {
    "coulomb_friction": 0.01,
    "com_offset": 0.01,
    "mass_spread": 0.01,
    "floor_slope": 0.002,
    "floor_patch": 0.03,  # soft edges
    "floor_grain": 0.002,
    "obstacle_contact": 0.06,  # gives way by a millimetre
    "tether": 0.002,
}
"""Largest remaining share, for effects on the object without internal state, event or further wheel."""


@pytest.mark.parametrize("name", SIMPLE)
def test_the_true_law_reproduces_mujoco(name: str) -> None:
    """With true values and the same wrench, little of the effect's influence remains."""
    seed, hidden = drawn(name)
    truly = [simulate(scene(seed), [hidden], k) for k in range(EPISODES)]
    laws = hidden.laws(scene(seed))
    left, whole = (apart(truly, more, seed) for more in (laws, []))
    assert whole > 0.01
    assert left < SIMPLE[name] * whole


def apart(truly: list[Motion], laws: list[dict[str, object]], seed: int) -> float:
    """Return the RMS distance of simulated from true positions, m."""
    return float(np.sqrt(np.mean([np.mean(simulated(one, laws, seed)[:, :2] ** 2) for one in truly])))


def recorded(seed: int, hidden: list[HiddenEffect]) -> trundle.Recording:
    """The recording of a scene."""
    return make_recording(scene(seed), hidden, simulate_case(scene(seed), hidden), "case_0001")


def test_the_same_seed_gives_the_same_recording() -> None:
    seed, hidden = drawn("caster_swivel")
    first, second = (recorded(seed, [hidden]) for _ in range(2))
    assert first == second


def test_a_recording_does_not_name_the_hidden_effect() -> None:
    seed, hidden = drawn("floor_patch")
    found, clean = recorded(seed, [hidden]), recorded(seed, [])
    assert found.metadata == clean.metadata


def test_families_are_found_by_name() -> None:
    names = {effect["effect"] for effect in trundle.effects()}
    for name, family in FAMILIES.items():
        assert family.out_of_catalogue == (name not in names)
