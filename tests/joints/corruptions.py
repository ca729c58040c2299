"""Mistakes in recordings of joints: functions of the columns of an episode, which they change."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from tests.joints.simulated import Columns, Floats

__all__ = ["CORRUPTIONS", "Corruption"]


@dataclass(frozen=True)
class Corruption:
    """A mistake, the kind of its finding, a pattern in its sentence, and further metadata."""

    change: Callable[[Columns], Columns | None]
    kind: str
    words: str
    metadata: Mapping[str, Any] = field(default_factory=dict)
    joints: int = 2


def late(values: Floats, t: Floats, delay: float) -> Floats:
    """Return values that are recorded late."""
    return np.interp(t - delay, t, values)


def scaled(*columns: str, by: float) -> Callable[[Columns], None]:
    def change(table: Columns) -> None:
        for name in columns:
            table[name] *= by

    return change


def delayed(column: str, seconds: float) -> Callable[[Columns], None]:
    def change(table: Columns) -> None:
        table[column] = late(table[column], table["t"], seconds)

    return change


def magnitudes(table: Columns) -> None:
    for name in ("effort_shoulder", "effort_elbow"):
        table[name] = abs(table[name])


def wrapped(table: Columns) -> None:
    turned = 3.0 * table["q_shoulder"] + np.pi  # crosses pi
    table["q_shoulder"] = (turned + np.pi) % (2.0 * np.pi) - np.pi


def quantised(table: Columns) -> None:
    table["q_elbow"] = np.round(table["q_elbow"] / 0.0015) * 0.0015


def swapped(*prefixes: str) -> Callable[[Columns], None]:
    def change(table: Columns) -> None:
        for prefix in prefixes:
            names = [f"{prefix}_{joint}" for joint in ("shoulder", "elbow")]
            table[names[0]], table[names[1]] = table[names[1]], table[names[0]]

    return change


def without_a_second(table: Columns) -> Columns:
    kept = (table["t"] < 2.0) | (table["t"] > 3.0)
    return {name: values[kept] for name, values in table.items()}


def clock_jump(table: Columns) -> None:
    table["t"] = np.where(table["t"] > 3.0, table["t"] + 0.5, table["t"])


def stopped_encoder(table: Columns) -> None:
    rows = (table["t"] > 2.0) & (table["t"] < 2.8)
    table["q_elbow"][rows] = table["q_elbow"][rows][0]


def saturated(table: Columns) -> None:
    limit = np.quantile(abs(table["effort_shoulder"]), 0.8)
    table["effort_shoulder"] = np.clip(table["effort_shoulder"], -limit, limit)


def spikes(table: Columns) -> None:
    table["effort_elbow"][[100, 300]] += 100.0 * np.std(table["effort_elbow"])


def resting(table: Columns) -> None:
    rng = np.random.default_rng(0)
    table["q_elbow"] = 0.3 + 1e-4 * rng.standard_normal(len(table["t"]))
    for name in ("v_elbow", "target_elbow", "effort_elbow"):
        del table[name]


def one_way(table: Columns) -> None:
    t = table["t"]
    table["q_elbow"] = 0.2 * t + 0.05 * t**2
    for name in ("v_elbow", "target_elbow", "effort_elbow"):
        del table[name]


def one_speed(table: Columns) -> None:
    t = table["t"]
    table["q_elbow"] = abs((t + 0.5) % 4.0 - 2.0) + 1e-4 * np.random.default_rng(0).standard_normal(len(t))
    for name in ("v_elbow", "target_elbow", "effort_elbow"):
        del table[name]


def without_targets(table: Columns) -> None:
    for name in ("target_shoulder", "target_elbow"):
        del table[name]


def target_only(table: Columns) -> None:
    """Leave the command of the shoulder, 0.1 s early."""
    for name in ("effort_shoulder", "effort_elbow"):
        del table[name]
    table["target_shoulder"] = late(table["target_shoulder"], table["t"], -0.1)


DEGREES = 180.0 / np.pi

CORRUPTIONS = {
    "magnitudes": Corruption(magnitudes, "sign", "never changes its sign"),
    "declared magnitudes without targets": Corruption(
        without_targets, "effort", "has no target", {"effort": {"signed": False}}
    ),
    "reversed effort": Corruption(scaled("effort_shoulder", by=-1.0), "sign", "opposes its motion"),
    "reversed effort of one axis": Corruption(
        scaled("effort_shoulder", by=-1.0), "sign", "opposes its motion", joints=1
    ),
    "late effort": Corruption(delayed("effort_shoulder", 0.05), "clocks", r"is recorded (49|50)\.\d"),
    "early effort": Corruption(delayed("effort_elbow", -0.04), "clocks", r"its effort by (3|4)\d\.\d"),
    "early target": Corruption(target_only, "clocks", "follows its target by .* dry friction, play or el"),
    "late velocity": Corruption(delayed("v_elbow", 0.02), "velocity", r"lags its positions by 20\.\d ms"),
    "late velocity, wrongly stated": Corruption(
        delayed("v_elbow", 0.02),
        "velocity",
        r"leads its positions by 19\.\d ms",
        {"delay": {"v": {"elbow": 0.04}}},
    ),
    "velocity in degrees": Corruption(scaled("v_elbow", by=DEGREES), "units", "as degrees per second"),
    "velocity in rpm": Corruption(scaled("v_elbow", by=30.0 / np.pi), "units", "revolutions per minute"),
    "reversed velocity": Corruption(scaled("v_elbow", by=-1.0), "units", r"is -(1\.0|0\.9)"),
    "positions in degrees": Corruption(
        scaled("q_elbow", by=DEGREES), "units", "the positions look like degrees"
    ),
    "all in degrees": Corruption(
        scaled(
            *(f"{prefix}_{joint}" for prefix in ("q", "v", "target") for joint in ("shoulder", "elbow")),
            by=DEGREES,
        ),
        "units",
        "looks like degrees",
    ),
    "wrapped angle": Corruption(wrapped, "angles", "is wrapped"),
    "quantised positions": Corruption(quantised, "noise", r"multiples of 1\.5000e-3, which is not stated"),
    "wrong step": Corruption(
        quantised, "noise", "not of the stated step 3.0000e-3", {"noise": {"position_step": {"elbow": 3e-3}}}
    ),
    "noise below the quantisation": Corruption(
        quantised,
        "noise",
        "is below the 4.33e-4 of the quantisation alone",
        {"noise": {"position": {"elbow": 1e-5}, "position_step": {"elbow": 1.5e-3}}},
    ),
    "targets in another order": Corruption(
        swapped("target"), "order", "target_shoulder follows the positions of elbow"
    ),
    "efforts in another order": Corruption(
        swapped("effort"), "order", "the motion of elbow leaves .* of effort_shoulder unexplained"
    ),
    "positions in another order": Corruption(
        swapped("q"), "order", r"columns q_\* .* the motion of shoulder leaves .* of effort_elbow unexplained"
    ),
    "targets and velocities in another order": Corruption(
        swapped("target", "v"), "order", r"the columns target_\* and v_\* are in another order"
    ),
    "velocities in another order": Corruption(
        swapped("v"), "order", "v_elbow follows the velocities of shoulder"
    ),
    "gap": Corruption(without_a_second, "gaps", "for 1.0"),
    "jump of the clock": Corruption(clock_jump, "clocks", "the clock jumps by 0.500 s"),
    "stopped encoder": Corruption(stopped_encoder, "frozen", "stays at"),
    "saturation": Corruption(saturated, "saturation", "stays at its extreme"),
    "spikes": Corruption(spikes, "outliers", "effort_elbow has 2 samples"),
    "resting joint": Corruption(resting, "excitation", "less than ten times its noise"),
    "one direction": Corruption(one_way, "excitation", "in one direction only"),
    "one speed": Corruption(one_speed, "excitation", "at one speed only"),
}
