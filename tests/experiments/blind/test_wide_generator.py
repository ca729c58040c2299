"""The generator of the wide benchmark: both engines agree, and conventions do not change the data."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

pytest.importorskip("mujoco")

import tomli_w

import trundle
from trundle.experiments.blind.case import draw_effects
from trundle.experiments.blind.family import Context, HiddenEffect
from trundle.experiments.blind.instrument import FRAMES
from trundle.experiments.blind.oracle import build_model
from trundle.experiments.blind.plan import plan_cases
from trundle.experiments.blind.push import CONTACT_TIME_S
from trundle.experiments.blind.readings import Readings
from trundle.experiments.blind.scene import Scene, Wheel
from trundle.experiments.blind.settings import read
from trundle.experiments.blind.wide.families import (
    CATALOGUE,
    FAMILIES,
    OUT_OF_CATALOGUE,
    is_allowed,
    merge_wheels,
)
from trundle.experiments.blind.wide.generator import GENERATOR, simulate_case
from trundle.experiments.blind.wide.measurement import make_recording
from trundle.experiments.blind.wide.ode_engine import TIME_STEP_S, Plant
from trundle.experiments.blind.wide.outlines import draw_outline
from trundle.experiments.blind.wide.scene import draw_scene

Floats = NDArray[np.float64]
CONFIG = Path(__file__).parents[3] / "configs/experiments/wide.toml"


def scene_with(contact: str, engine: str = "ode", seed: int = 100, seconds: float = 2.5) -> Scene:
    """Return a short scene of a contact with fine instruments."""
    while (scene := draw_scene(seed, 0, engine)).instrument.contact != contact:
        seed += 1
    fine = replace(
        scene.instrument, tracker=250.0, dropout=0.0, sensor=1000.0, jitter=0.0, filtered=False, raw=False
    )
    few = 3
    return replace(
        scene,
        instrument=fine,
        pushes=scene.pushes[:few],
        seconds=(seconds,) * few,
        strokes=scene.strokes[:few],
        clock=scene.clock[:few],
        rest=scene.rest[:few],
        held_out=1,
        pose_noise=(1e-5, 1e-5, 1e-5),
        wrench_noise=(1e-3, 1e-3, 1e-4),
    )


@pytest.mark.parametrize("contact", ["grasp", "compliant"])
def test_the_engines_agree_on_a_grasp(contact: str) -> None:
    scene = scene_with(contact)
    for ode, mujoco in zip(
        simulate_case(scene, []), simulate_case(replace(scene, engine="mujoco"), []), strict=True
    ):
        assert np.abs(ode.pose - mujoco.pose).max() < 1e-3
        assert np.abs(ode.gripper - mujoco.gripper).max() < 5e-3
        assert np.abs(ode.wrench - mujoco.wrench).max() < 0.02 * np.abs(ode.wrench).max()


@pytest.mark.parametrize("engine", ["ode", "mujoco"])
@pytest.mark.parametrize("contact", ["grasp", "compliant", "point"])
def test_the_true_motion_follows_from_the_true_reading(engine: str, contact: str) -> None:
    scene = scene_with(contact, engine)
    for k, seen in enumerate(simulate_case(scene, [])):
        error = np.abs(replayed(scene, k, seen) - at_steps(seen)).max(axis=0)
        assert error.max() < (1e-4 if engine == "ode" else 3e-3)


def at_steps(seen: Readings) -> Floats:
    """Return the poses at the steps of the solver."""
    t = np.arange(CONTACT_TIME_S, float(seen.t[-1]), TIME_STEP_S)
    return np.column_stack([np.interp(t, seen.t, seen.pose[:, k]) for k in range(3)])


def replayed(scene: Scene, episode: int, seen: Readings) -> Floats:
    """Return the poses of the object with only its wheel under the measured wrench."""
    angle = seen.gripper[:, 2]
    fx = np.cos(angle) * seen.wrench[:, 0] - np.sin(angle) * seen.wrench[:, 1]
    fy = np.sin(angle) * seen.wrench[:, 0] + np.cos(angle) * seen.wrench[:, 1]
    rx, ry = (seen.gripper - seen.pose)[:, :2].T
    torque = seen.wrench[:, 2] + rx * fy - ry * fx
    c, s = np.cos(seen.pose[:, 2]), np.sin(seen.pose[:, 2])
    along, across = c * fx + s * fy, c * fy - s * fx

    def driver(t: float, at: Any) -> tuple[float, float, float]:
        a, b, m = (float(np.interp(t, seen.t, values)) for values in (along, across, torque))
        return at.c * a - at.s * b, at.s * a + at.c * b, m

    plant = Plant(scene, [], episode)
    state, poses = plant.initial(), []
    for t in np.arange(CONTACT_TIME_S, float(seen.t[-1]), TIME_STEP_S).tolist():
        poses.append(state[:3])
        state = plant.step(t, state, driver)
    return np.array(poses)


def test_a_finger_keeps_touching_under_load() -> None:
    scene = draw_scene(72123, 0, "mujoco")
    assert scene.instrument.contact == "point"
    wrench = np.concatenate([one.wrench for one in simulate_case(scene, [])])
    force = np.hypot(wrench[:, 0], wrench[:, 1])
    before, now, after = force[:-2], force[1:-1], force[2:]
    loaded = (before > 1.0) & (after > 1.0)
    assert loaded.sum() > 1000
    assert not np.any(loaded & (now < 0.7 * np.minimum(before, after)))


def test_an_oracle_keeps_the_time_of_an_event() -> None:
    # The thinned recording, with which a fit starts, prefers a time 1.4 s earlier.
    scene = draw_scene(72011, 23, "mujoco")
    load = {"episode": 1, "time": 5.4226, "mass": -6.9746}
    hidden = [HiddenEffect(FAMILIES["mass_change"], load)]
    made = make_recording(scene, hidden, simulate_case(scene, hidden), "load")
    model, start = build_model(scene, [{"kind": "mass_change", **load}])
    found = {p["name"]: p for p in trundle.fit(made, model, start=start, starts=0).summary["parameters"]}
    for name in ("time", "mass"):
        estimate = found[f"mass_change.{name}"]
        assert abs(estimate["mean"] - load[name]) < 4 * estimate["sd"]


@pytest.mark.parametrize(("frame", "reference"), FRAMES)
@pytest.mark.parametrize("sign", ["on_object", "on_sensor"])
def test_every_convention_gives_the_same_data(frame: str, reference: str, sign: str) -> None:
    scene = scene_with("compliant")
    published = replace(scene.instrument, frame=frame, reference=reference, sign=sign)
    scene = replace(scene, instrument=published)
    made = make_recording(scene, [], simulate_case(scene, []), "case")
    body = {**scene.shape.described(with_feet=False), "mass": scene.mass}
    wheel = {"kind": "viscous_wheel", **{name: float(value) for name, value in vars(scene.wheel).items()}}
    model = trundle.Model.from_toml(
        tomli_w.dumps({"format": "trundle-model/1", "body": body, "effect": [wheel]})
    )
    off = np.concatenate([one.error[:, :2] for one in trundle.predict(made, model).values()])
    assert np.sqrt(np.mean(np.sum(off**2, axis=1))) < 2e-3


def test_one_wheel_and_spin_damping_represent_two_wheels() -> None:
    one, two = Wheel(0.1, 0.2, 0.3, 10.0, 100.0), Wheel(-0.2, 0.1, 1.3, 8.0, 150.0)
    left = one.damping() + two.damping() - merge_wheels(one, two).damping()
    assert np.abs(left[:2]).max() < 1e-9
    assert left[2, 2] > 0.0


@pytest.mark.parametrize("name", sorted(CATALOGUE | OUT_OF_CATALOGUE))
def test_every_family_has_an_influence_in_its_engines(name: str) -> None:
    for engine in ("ode", "mujoco"):
        if not is_allowed(name, scene_with("grasp", engine)):
            continue
        scene, bare, hidden = next(
            found for seed in range(300, 400, 10) if (found := placed(name, engine, seed))
        )
        seen = simulate_case(scene, hidden)
        moved = max(float(np.abs(a.pose - b.pose).max()) for a, b in zip(seen, bare, strict=True))
        read = [(distorted(scene, hidden, k, one), one) for k, one in enumerate(seen)]
        wrench = max(float(np.abs(a.wrench - b.wrench).max()) for a, b in read)
        pose = max(float(np.abs(a.pose - b.pose).max()) for a, b in read)
        assert moved > 1e-4 or wrench > 0.05 or pose > 1e-3


@cache
def unaffected(engine: str, seed: int, seconds: float) -> tuple[Scene, list[Readings]]:
    """Return a scene and its motion without effects."""
    scene = scene_with("grasp", engine, seed, seconds)
    return scene, simulate_case(scene, [])


def placed(name: str, engine: str, seed: int) -> tuple[Scene, list[Readings], list[HiddenEffect]] | None:
    """Return a scene that supports a family, its motion without it, and the family with values."""
    scene, bare = unaffected(engine, seed, 5.0 if name == "obstacle_contact" else 2.0)
    found = (draw_effects(GENERATOR, [name], 1, attempt, scene, bare) for attempt in range(10))
    hidden = next((one for one in found if one is not None), None)
    return None if hidden is None else (scene, bare, hidden)


def distorted(scene: Scene, hidden: list[HiddenEffect], episode: int, seen: Readings) -> Readings:
    """Return the measurements of a motion."""
    for one in hidden:
        seen = one.distort(seen, Context(scene, episode))
    return seen


def test_outlines_have_their_area_and_inertia() -> None:
    for seed in range(40):
        outline = draw_outline(np.random.default_rng(seed))
        if outline.disc is None:
            assert sum(area(part) for part in outline.parts) == pytest.approx(outline.area, rel=1e-3)
        assert outline.spin > 0.0


def area(ring: Floats) -> float:
    """Return the area of a counter-clockwise polygon."""
    x, y = ring.T
    return float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)) / 2)


def test_the_smoke_set_is_part_of_the_tuning_range_and_ranges_do_not_overlap() -> None:
    smoke, tune, report = (plan_cases(read(CONFIG, name)) for name in ("smoke", "tune", "report"))
    assert len(smoke) == 60
    assert len(tune) <= 200
    assert set(smoke) <= set(tune)
    assert sum(not one.names for one in report) >= 600
    assert not {one.seed for one in tune} & {one.seed for one in report}
    assert all(name in FAMILIES for one in report for name in one.names)
