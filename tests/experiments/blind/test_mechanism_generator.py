"""The generator of the benchmark of mechanisms: engines agree, and effects change recordings."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("mujoco")

from trundle.experiments.blind.mechanism.families import CATALOGUE, drooping_drive
from trundle.experiments.blind.mechanism.family import HiddenEffect
from trundle.experiments.blind.mechanism.generator import (
    FAMILIES,
    allowed_sources,
    draw_effects,
    statistics,
)
from trundle.experiments.blind.mechanism.measurement import record
from trundle.experiments.blind.mechanism.oracle import effort_misfits
from trundle.experiments.blind.mechanism.outside import OUT_OF_CATALOGUE
from trundle.experiments.blind.mechanism.robots import ROBOTS
from trundle.experiments.blind.mechanism.scene import Scene, draw_scene
from trundle.experiments.blind.mechanism.simulation import simulate
from trundle.experiments.blind.plan import plan_cases
from trundle.experiments.blind.settings import read

CONFIG = Path(__file__).parents[3] / "configs/experiments/mechanism.toml"


def scene_of(robot: str, source: str = "measured", episodes: int = 1, length: float = 1.0) -> Scene:
    scene = draw_scene(np.random.default_rng(3), [ROBOTS[robot]], (source,), None)
    waves = [[dict(one, kind="sines") for one in waves] for waves in scene.waves[:episodes]]
    instrument = {**scene.instrument, "side": "joint", "noise_given": False, "effort_noise": 0.002}
    for key in ("position_noise", "position_step"):
        instrument[key] = dict.fromkeys(ROBOTS[robot].joints, 2e-5)
    return replace(
        scene,
        payloads=[None] * episodes,
        waves=waves,
        length=length,
        rate=250,
        instrument=instrument,
        fixed=[],
    )


def test_ranges_have_the_stated_cases_and_disjoint_seeds() -> None:
    seen: set[int] = set()
    for name, count in {"smoke": 40, "tune": 150, "report": 600}.items():
        cases = plan_cases(read(CONFIG, name))
        seeds = {one.seed for one in cases}
        assert len(cases) == len(seeds) == count
        assert not seeds & seen
        seen |= seeds
        assert {one.engine for one in cases} == {"mujoco", "lugre"}
        assert all(allowed_sources(one.names) for one in cases)


@pytest.mark.parametrize("robot", sorted(ROBOTS))
def test_engines_agree_without_effects(robot: str) -> None:
    scene = scene_of(robot, length=0.6)
    found = [simulate(engine, scene, []) for engine in ("mujoco", "lugre")]
    assert found[0] is not None
    assert found[1] is not None
    spans = [high - low for low, high in ROBOTS[robot].spans.values()]
    assert np.all(np.abs(found[0][0].q - found[1][0].q).max(0) < 2e-3 * np.array(spans))


@pytest.mark.parametrize("engine", ["mujoco", "lugre"])
@pytest.mark.parametrize("name", ["joint_backlash", "joint_load_friction", "effort_delay", *OUT_OF_CATALOGUE])
def test_hidden_effects_change_what_is_recorded(engine: str, name: str, tmp_path: Path) -> None:
    source = allowed_sources([name])[0]
    scene = scene_of("planar_arm", source, length=0.5)
    bare = simulate(engine, scene, [])
    assert bare is not None
    seen = statistics(bare)
    family = FAMILIES[name]
    values = family.draw(np.random.default_rng(1), scene, seen, 1)
    assert values is not None
    hidden = [HiddenEffect(family, {"joint": 1, **values})]
    motions = simulate(engine, scene, hidden)
    assert motions is not None
    record(scene, hidden, motions, seen.effort, 0, tmp_path / "with")
    record(scene, [], bare, seen.effort, 0, tmp_path / "bare")
    tables = [
        np.loadtxt(tmp_path / one / "episode_00.csv", delimiter=",", skiprows=1) for one in ("with", "bare")
    ]
    assert np.abs(tables[0] - tables[1]).max() > 1e-6


def test_both_engines_give_the_dry_friction_that_was_drawn(tmp_path: Path) -> None:
    scene = scene_of("pendulum", episodes=1)
    values = {"joint": 0, "effort": 0.2, "static_effort": 0.2, "velocity": 0.1}
    hidden = [HiddenEffect(CATALOGUE["joint_dry_friction"], values)]
    for engine in ("mujoco", "lugre"):
        with_it, bare = simulate(engine, scene, hidden), simulate(engine, scene, [])
        assert with_it is not None
        assert bare is not None
        moving = np.abs(with_it[0].v[:, 0]) > 0.3 * np.abs(with_it[0].v).max()
        change = (with_it[0].effort - bare[0].effort)[:, 0] * np.sign(with_it[0].v[:, 0])
        assert np.median(change[moving]) == pytest.approx(0.2, abs=0.06)


def test_a_hidden_spring_raises_the_misfit(tmp_path: Path) -> None:
    scene = scene_of("planar_arm", episodes=5, length=4.0)
    values = {"joint": 1, "stiffness": 6.0, "rest": 0.4}
    misfits = []
    for hidden in ([], [HiddenEffect(CATALOGUE["joint_spring"], values)]):
        motions = simulate("mujoco", scene, hidden)
        assert motions is not None
        folder = tmp_path / str(len(hidden))
        record(scene, hidden, motions, statistics(motions).effort, 0, folder)
        misfits.append(effort_misfits(folder))
    assert np.all(np.array(misfits[1]) > 3 * np.array(misfits[0]))


def test_a_drooping_drive_never_exerts_less_for_a_larger_command() -> None:
    act = drooping_drive({"joint": 0, "droop": 0.4, "largest": 2.0})
    commands = np.linspace(0.0, 5.0, 101)
    efforts = np.array([act(np.array([u]))[0] for u in commands])
    assert np.all(np.diff(efforts) > 0.0)
    assert efforts[40] == pytest.approx(2.0 * (1.0 - 0.4))


def test_a_spring_and_a_bias_are_hidden_at_different_joints() -> None:
    families = [FAMILIES[name] for name in ("joint_spring", "effort_bias")]
    scene = scene_of("planar_arm")
    bare = simulate("lugre", scene, [])
    assert bare is not None
    seen = statistics(bare)
    found = [draw_effects(np.random.default_rng(seed), scene, families, seen) for seed in range(8)]
    assert any(hidden is None for hidden in found)
    drawn = [[one.values["joint"] for one in hidden] for hidden in found if hidden is not None]
    assert drawn
    assert all(first != second for first, second in drawn)
