"""`trundle.check` has no findings on clean recordings, and names each corruption."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import trundle
from tests.record_prepare.conftest import Corrupt
from tests.record_prepare.table import (
    GRASP,
    NOISE,
    OFFSET,
    TABLES,
    Table,
    metadata,
    recording,
    tables,
    transport,
    turn,
)

Found = Callable[[Corrupt], trundle.Findings]

CLEAN = {
    "locked wheel": Table(),
    "free wheel": Table(wheel=(0.0, 0.0, 0.0, 3.0, 8.0)),
    "stiff wheel": Table(wheel=(0.5, 0.3, 1.0, 10.0, 2000.0)),
    "wheel across the push": Table(wheel=(0.2, 0.35, 1.4, 5.0, 600.0), seed=2),
    "dry friction": Table(dry=12.0, strength=40.0, seed=3),
    "dry friction alone": Table(wheel=(0.0, 0.0, 0.0, 0.0, 0.0), dry=20.0, strength=40.0, seed=4),
    "gentle": Table(strength=12.0, seed=5),
    "one episode": Table(episodes=1, seed=6),
    "two short ones": Table(episodes=2, seconds=2.0, seed=7),
}


@pytest.mark.parametrize("table", CLEAN.values(), ids=CLEAN.keys())
def test_clean_recordings_have_no_findings(table: Table) -> None:
    findings = trundle.check(recording(table))
    assert [f for f in findings if f.severity != "note"] == []
    assert "mass" not in kinds(findings, "note")


def in_world_axes(_: dict[str, Any], episodes: TABLES) -> None:
    """The wrench about the object's origin in world axes, without an offset."""
    for columns in episodes.values():
        held = np.flatnonzero(~np.isnan(columns["force_x"]))
        poses = np.flatnonzero(~np.isnan(columns["object_x"]))
        theta = np.interp(held, poses, columns["object_theta"][poses])
        axes = ("force_x", "force_y", "torque_z")
        readings = OFFSET - np.array([columns[axis][held] for axis in axes]).T
        for row, angle, reading in zip(held, theta, readings, strict=True):
            wrench = transport(GRASP, reading)
            for axis, value in zip(axes, [*(turn(angle) @ wrench[:2]), wrench[2]], strict=True):
                columns[axis][row] = value


def test_a_wrench_in_world_axes_without_a_gripper_has_no_findings(found: Found) -> None:
    def corrupt(described: dict[str, Any], episodes: TABLES) -> None:
        in_world_axes(described, episodes)
        described["wrench"] = {"frame": "world", "reference": "object", "sign": "on_object"}
        for columns in episodes.values():
            for name in [name for name in columns if name.startswith("gripper")]:
                del columns[name]
            held = ~(np.isnan(columns["object_x"]) & np.isnan(columns["force_x"]))
            for name in columns:
                columns[name] = columns[name][held]

    assert kinds(found(corrupt), "error", "warning") == set()


def test_an_object_that_is_released_is_not_far_from_the_gripper(found: Found) -> None:
    """After a short push the gripper stays two metres away without a load: that is no error of a place."""

    def release(described: dict[str, Any], episodes: TABLES) -> None:
        described["wrench"]["contact"] = "point"
        rng = np.random.default_rng(0)
        for columns in episodes.values():
            released = columns["t"] > 2.0
            for axis, offset, sd in zip(
                ("force_x", "force_y", "torque_z"), OFFSET, (0.4, 0.4, 0.05), strict=True
            ):
                rows = released & ~np.isnan(columns[axis])
                columns[axis][rows] = offset + sd * rng.standard_normal(rows.sum())
            columns["gripper_x"][released & ~np.isnan(columns["gripper_x"])] -= 2.0

    assert "place" not in kinds(found(release), "error", "warning")


def test_a_grasp_does_not_slip_where_poses_are_lost(found: Found) -> None:
    """The object's poses end 1 s before those of the gripper, while it moves."""

    def lose(_: dict[str, Any], episodes: TABLES) -> None:
        for columns in episodes.values():
            ended = columns["t"] > 2.0
            for name in ("object_x", "object_y", "object_theta"):
                columns[name][ended] = np.nan

    assert "grasp" not in kinds(found(lose), "error", "warning")


def rail(sign: float) -> trundle.Recording:
    """A cart of 90 kg with viscous and dry friction, driven back and forth on a rail."""
    t = np.arange(0.0, 8.0, 0.002)
    force = 150.0 * np.sin(1.7 * t) + 60.0 * np.sin(5.1 * t)
    x, v = np.zeros_like(t), 0.0
    for i in range(1, len(t)):
        v += 0.002 * (force[i - 1] - 200.0 * v - 20.0 * np.tanh(v / 0.002)) / 90.0
        x[i] = x[i - 1] + 0.002 * v
    rng = np.random.default_rng(0)
    described = {
        "format": "trundle-recording/1",
        "name": "rail",
        "object": {"dof": ["x"]},
        "wrench": {"frame": "world", "sign": "on_object", "source": "commanded"},
    }
    columns = {"t": t, "object_x": x + rng.normal(0.0, 1e-5, len(t)), "force_x": sign * force}
    return trundle.Recording(described, {"a": columns})


def test_a_rail() -> None:
    assert kinds(trundle.check(rail(1.0)), "error", "warning") == set()
    assert kinds(trundle.check(rail(-1.0)), "error") == {"sign"}


def kinds(findings: trundle.Findings, *severities: str) -> set[str]:
    return {f.kind for f in findings if f.severity in severities}


def scale(prefix: tuple[str, ...], factor: float) -> Corrupt:
    def corrupt(_: dict[str, Any], episodes: TABLES) -> None:
        for columns in episodes.values():
            for name in columns:
                if name.startswith(prefix):
                    columns[name] = columns[name] * factor

    return corrupt


def wrong_sign(described: dict[str, Any], _: TABLES) -> None:
    described["wrench"]["sign"] = "on_object"


def exchanged(_: dict[str, Any], episodes: TABLES) -> None:
    for columns in episodes.values():
        columns["force_x"], columns["force_y"] = columns["force_y"], columns["force_x"]


def quarter_turn(_: dict[str, Any], episodes: TABLES) -> None:
    for columns in episodes.values():
        columns["force_x"], columns["force_y"] = -columns["force_y"], columns["force_x"]


def late(seconds: float) -> Corrupt:
    def corrupt(described: dict[str, Any], episodes: TABLES) -> None:
        rows = round(seconds / 0.01)
        for columns in episodes.values():
            for axis in ("force_x", "force_y", "torque_z"):
                held = np.flatnonzero(~np.isnan(columns[axis]))
                values = columns[axis][held]
                columns[axis][held] = np.concatenate([values[:rows], values[:-rows]])

    return corrupt


def tare_in_contact(described: dict[str, Any], _: TABLES) -> None:
    described["wrench"]["precontact"] = {f"episode_{i:02}": [0.0, 0.5] if i else [1.0, 1.5] for i in range(5)}


def clipped(_: dict[str, Any], episodes: TABLES) -> None:
    for columns in episodes.values():
        columns["force_x"] = np.clip(columns["force_x"], OFFSET[0] - 15.0, OFFSET[0] + 15.0)


def slipping(_: dict[str, Any], episodes: TABLES) -> None:
    columns = episodes["episode_01"]
    columns["gripper_x"] = columns["gripper_x"] + 0.04 * (columns["t"] - 0.6).clip(0.0)


def lost_tracker(_: dict[str, Any], episodes: TABLES) -> None:
    columns = episodes["episode_00"]
    rows = np.flatnonzero(~np.isnan(columns["object_x"]))[100:140]
    for name, fake in (("object_x", 0.66854), ("object_y", -0.26052), ("object_theta", 0.3)):
        columns[name][rows] = fake


def never_moves(_: dict[str, Any], episodes: TABLES) -> None:
    rng = np.random.default_rng(1)
    for columns in episodes.values():
        for name in ("object_x", "object_y", "object_theta"):
            here = ~np.isnan(columns[name])
            columns[name][here] = rng.normal(0.0, 5e-4, here.sum())


def no_force(_: dict[str, Any], episodes: TABLES) -> None:
    rng = np.random.default_rng(1)
    for columns in episodes.values():
        for name in ("force_x", "force_y", "torque_z"):
            here = ~np.isnan(columns[name])
            columns[name][here] = rng.normal(0.0, 0.05, here.sum())


def other_epoch(described: dict[str, Any], episodes: TABLES) -> None:
    described["wrench"]["precontact"] = [100.0, 100.55]
    for name, columns in episodes.items():
        poses, wrench = ~np.isnan(columns["object_x"]), ~np.isnan(columns["force_x"])
        both: dict[str, Any] = {"t": np.concatenate([columns["t"][poses], columns["t"][wrench] + 100.0])}
        for column, values in columns.items():
            if column != "t":
                of_wrench = column.startswith(("force", "torque"))
                empty = np.full(poses.sum() if of_wrench else wrench.sum(), np.nan)
                both[column] = (
                    np.concatenate([empty, values[wrench]])
                    if of_wrench
                    else np.concatenate([values[poses], empty])
                )
        episodes[name] = both


def wrong_noise(described: dict[str, Any], _: TABLES) -> None:
    described["noise"] = {"pose": [0.5, 0.5, 0.1], "force": 0.4, "torque": 0.05}


CORRUPTIONS: dict[str, tuple[Corrupt, str]] = {
    "millimetres": (scale(("object_x", "object_y", "gripper_x", "gripper_y"), 1000.0), "units"),
    "millimetres of the object alone": (scale(("object_x", "object_y"), 1000.0), "units"),
    "degrees": (scale(("object_theta", "gripper_theta"), 180.0 / np.pi), "units"),
    "newton millimetres": (scale(("torque_z",), 1000.0), "units"),
    "noise in millimetres": (wrong_noise, "noise"),
    "wrong sign": (wrong_sign, "sign"),
    "exchanged axes": (exchanged, "axes"),
    "sensor turned by a quarter": (quarter_turn, "axes"),
    "wrench 100 ms late": (late(0.1), "clocks"),
    "another epoch": (other_epoch, "clocks"),
    "tare in contact": (tare_in_contact, "tare"),
    "saturated": (clipped, "saturation"),
    "slipping grasp": (slipping, "grasp"),
    "lost tracker": (lost_tracker, "tracker"),
    "never moves": (never_moves, "motion"),
    "no force": (no_force, "force"),
}


@pytest.mark.parametrize(("corrupt", "kind"), CORRUPTIONS.values(), ids=CORRUPTIONS.keys())
def test_each_corruption_is_reported(found: Found, corrupt: Corrupt, kind: str) -> None:
    findings = found(corrupt)
    assert kind in kinds(findings, "error", "warning", "note"), findings
    assert all(f.sentence and f.remedy for f in findings)


def test_a_wrong_sign_is_described(found: Found) -> None:
    first = found(wrong_sign)[0]
    assert first.severity == "error"
    assert "wrong direction" in first.sentence and "on_sensor" in first.remedy


def test_errors_of_preparation_are_findings(found: Found) -> None:
    def tilting(_: dict[str, Any], episodes: TABLES) -> None:
        for columns in episodes.values():
            half = np.where(np.isnan(columns.pop("gripper_theta")), np.nan, 0.1 * columns["t"])
            level = np.where(np.isnan(half), np.nan, 0.0)
            columns |= {"gripper_z": level, "gripper_qy": level, "gripper_qz": level}
            columns |= {"gripper_qw": np.cos(half), "gripper_qx": np.sin(half)}
            columns |= {name: np.zeros_like(half) for name in ("force_z", "torque_x", "torque_y")}
            columns |= {name: np.nan_to_num(columns[name]) for name in ("force_x", "force_y", "torque_z")}

    [finding] = found(tilting)
    assert (finding.kind, finding.severity) == ("unusable", "error")
    assert "gripper_mass" in finding.remedy


def test_a_spinning_table_is_not_in_degrees() -> None:
    table = Table(wheel=(0.0, 0.0, 0.0, 0.0, 0.0), dry=20.0, strength=40.0, seed=4)
    assert (
        np.ptp(np.concatenate([e["pose"][:, 2] for e in trundle.prepare(recording(table)).values()])) > 13.0
    )


def no_noise(table: Table) -> trundle.Recording:
    described, episodes = metadata(table), tables(table, noise=0.0)
    return trundle.Recording(described, episodes)


def late_poses(time: float) -> trundle.Recording:
    """Precise poses whose time stamps err by 2 ms, and the error that the recording states."""
    table, rng = Table(episodes=3), np.random.default_rng(8)
    described, episodes = metadata(table), tables(table, noise=0.0)
    for columns in episodes.values():
        held = np.flatnonzero(~np.isnan(columns["object_x"]))
        t = columns["t"][held]
        for name in ("object_x", "object_y", "object_theta"):
            columns[name][held] = np.interp(t + rng.normal(scale=2e-3, size=len(t)), t, columns[name][held])
    described["noise"] = {**NOISE, "pose": [1e-5, 1e-5, 1e-5], "time": time}
    return trundle.Recording(described, episodes)


def test_errors_of_the_time_stamps_are_part_of_the_noise() -> None:
    assert "noise" in kinds(trundle.check(late_poses(0.0)), "warning")
    assert "noise" not in kinds(trundle.check(late_poses(2e-3)), "warning")


def test_a_noiseless_simulation_has_no_findings() -> None:
    for stated in ({}, {"noise": NOISE}):
        findings = trundle.check(no_noise(Table(episodes=3, metadata=stated)))
        assert [f for f in findings if f.severity != "note"] == []
