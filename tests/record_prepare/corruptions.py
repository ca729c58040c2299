"""Corruptions of clean recordings, with the expected kind of finding and words of its remedy."""

from __future__ import annotations

from collections.abc import Callable
from copy import deepcopy
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

import trundle
from tests.record_prepare.varied import Drawn, Tables, draw

__all__ = ["CORRUPTIONS", "Corruption"]

Floats = NDArray[np.float64]
Change = Callable[[Drawn, dict[str, Any], Tables], None]

WRENCH = ("force_x", "force_y", "torque_z")
KGF = 9.80665


@dataclass(frozen=True)
class Corruption:
    """A change of a clean recording, its finding, and the recordings on which it is detectable."""

    change: Change
    kinds: tuple[str, ...]
    words: tuple[str, ...]
    """Words, of which the sentence or the remedy must contain one."""
    chosen: dict[str, Any]
    """Fixed choices of the clean recording."""
    hits: float = 0.8
    """Minimum share of random recordings in which it is found. Some do not determine a short delay."""

    def apply(self, drawn: Drawn) -> tuple[dict[str, Any], Tables]:
        """Return metadata and tables of the corrupted recording."""
        metadata, tables = deepcopy(drawn.metadata), deepcopy(drawn.tables)
        self.change(drawn, metadata, tables)
        return metadata, tables

    def found(self, findings: trundle.Findings) -> bool:
        """Return whether the finding exists, with the right remedy."""
        return any(
            finding.kind in self.kinds
            and finding.severity != "note"
            and any(word in finding.sentence + finding.remedy for word in self.words)
            for finding in findings
        )


def scaled(factors: dict[str, float], *, footprint: float = 1.0) -> Change:
    """Multiply columns whose names begin so, and the outline."""

    def change(_: Drawn, metadata: dict[str, Any], tables: Tables) -> None:
        for columns in tables.values():
            for name in columns:
                for prefix, factor in factors.items():
                    if name.startswith(prefix):
                        columns[name] = columns[name] * factor
        corners = np.array(metadata["object"]["footprint"])
        metadata["object"]["footprint"] = (footprint * corners).tolist()
        metadata.pop("noise", None)

    return change


def late(
    seconds: float, *, drift: float = 0.0, jump: float = 0.0, one: bool = False, after: float = 0.5
) -> Change:
    """Delay the wrench, or let its clock drift, or jump after a share of one or all episodes."""

    def change(_: Drawn, metadata: dict[str, Any], tables: Tables) -> None:
        for k, (name, columns) in enumerate(tables.items()):
            t = columns["t"]
            of_wrench = ~np.isnan(columns["force_x"])
            stamps = t[of_wrench] * (1.0 + drift) + seconds
            if not (one and k != 1):
                stamps = stamps + jump * (t[of_wrench] >= after * t[-1])
            tables[name] = restamped(columns, of_wrench, stamps)
        interval = metadata["wrench"].get("precontact")
        if interval:
            metadata["wrench"]["precontact"] = [interval[0], interval[1] + min(seconds, 0.0)]

    return change


def restamped(columns: dict[str, Any], of_wrench: NDArray[np.bool_], stamps: Floats) -> dict[str, Any]:
    """Return the table with other times of its wrench."""
    poses = ~np.isnan(columns["object_x"])
    pose_t = columns["t"][poses]
    stamps = np.round(stamps, 7)
    t = np.unique(np.concatenate([pose_t, stamps]))
    t = t[t >= 0.0]
    whole: dict[str, Any] = {"t": t}
    for name, values in columns.items():
        if name == "t":
            continue
        whole[name] = np.full(len(t), np.nan)
        when, kept = (stamps, values[of_wrench]) if name in WRENCH else (pose_t, values[poses])
        inside = when >= 0.0
        whole[name][np.searchsorted(t, when[inside])] = kept[inside]
    return whole


def turned_force(angle: float) -> Change:
    """Turn the axes of the reading."""

    def change(_: Drawn, __: dict[str, Any], tables: Tables) -> None:
        c, s = np.cos(angle), np.sin(angle)
        for columns in tables.values():
            x, y = columns["force_x"], columns["force_y"]
            columns["force_x"], columns["force_y"] = c * x - s * y, s * x + c * y

    return change


def turned_gripper(_: Drawn, __: dict[str, Any], tables: Tables) -> None:
    """Turn the gripper by 20 degrees."""
    for columns in tables.values():
        columns["gripper_theta"] = columns["gripper_theta"] + np.radians(20.0)


def other_sign(_: Drawn, metadata: dict[str, Any], __: Tables) -> None:
    """State the other sign."""
    sign = metadata["wrench"]["sign"]
    metadata["wrench"]["sign"] = "on_sensor" if sign == "on_object" else "on_object"


def other_frame(frame: str) -> Change:
    """State another frame than that of the reading."""

    def change(_: Drawn, metadata: dict[str, Any], __: Tables) -> None:
        metadata["wrench"]["frame"] = frame

    return change


def frozen(_: Drawn, __: dict[str, Any], tables: Tables) -> None:
    """Keep the first pose of the gripper, with noise, in all episodes."""
    rng = np.random.default_rng(5)
    for columns in tables.values():
        held = ~np.isnan(columns["gripper_x"])
        for name in ("gripper_x", "gripper_y", "gripper_theta"):
            columns[name][held] = columns[name][held][0] + rng.normal(0.0, 1e-5, held.sum())


def gap(streams: tuple[str, ...]) -> Change:
    """Remove one second of streams in one episode."""

    def change(_: Drawn, __: dict[str, Any], tables: Tables) -> None:
        columns = tables["episode_01"]
        t = columns["t"]
        middle = 0.6 * t[-1]
        lost = (t > middle - 0.5) & (t < middle + 0.5)
        for name in columns:
            if name.startswith(streams):
                columns[name][lost] = np.nan
        some = ~np.all([np.isnan(values) for name, values in columns.items() if name != "t"], axis=0)
        tables["episode_01"] = {name: values[some] for name, values in columns.items()}

    return change


def another_object(drawn: Drawn, metadata: dict[str, Any], tables: Tables) -> None:
    """Record a heavier object in one episode, with the same instruments."""
    del metadata, drawn
    other = draw(
        977, contact="grasp", frame="sensor", slow=False, raw=False, sign="on_object", rates=(100.0, 200.0)
    )
    tables["episode_01"] = other.tables["episode_01"]


def not_tared(drawn: Drawn, metadata: dict[str, Any], tables: Tables) -> None:
    """Add an offset that is not tared."""
    del drawn
    peak = np.nanquantile(np.hypot(tables["episode_00"]["force_x"], tables["episode_00"]["force_y"]), 0.95)
    for columns in tables.values():
        columns["force_x"] = columns["force_x"] + 0.2 * peak
        columns["force_y"] = columns["force_y"] - 0.15 * peak
    metadata["wrench"]["raw"] = False
    metadata["wrench"].pop("precontact", None)


def unsigned(_: Drawn, __: dict[str, Any], tables: Tables) -> None:
    """Record magnitudes."""
    for columns in tables.values():
        for name in ("force_x", "force_y"):
            columns[name] = np.abs(columns[name])


def mirrored_poses(_: Drawn, metadata: dict[str, Any], tables: Tables) -> None:
    """Give the poses, and the outline, in left-handed frames."""
    for columns in tables.values():
        for name in ("object_y", "object_theta", "gripper_y", "gripper_theta"):
            columns[name] = -columns[name]
    corners = metadata["object"]["footprint"]
    metadata["object"]["footprint"] = [[x, -y] for x, y in corners][::-1]


def mirrored_position(_: Drawn, __: dict[str, Any], tables: Tables) -> None:
    """Reverse y of the poses and not their angle."""
    for columns in tables.values():
        for name in ("object_y", "gripper_y"):
            columns[name] = -columns[name]


def clockwise(_: Drawn, __: dict[str, Any], tables: Tables) -> None:
    """Count angles clockwise."""
    for columns in tables.values():
        for name in ("object_theta", "gripper_theta"):
            columns[name] = -columns[name]


LENGTHS = ("object_x", "object_y", "gripper_x", "gripper_y")
PUSH: dict[str, Any] = {"slow": False}
SENSOR = {**PUSH, "frame": "sensor"}
GRASP = {**SENSOR, "contact": "grasp"}
TARED = {**PUSH, "raw": False}
FAST = {**PUSH, "rates": (100.0, 100.0), "contact": "grasp"}


def lengths(unit: float) -> Change:
    """Give lengths in a unit of `unit` metres."""
    return scaled(dict.fromkeys(LENGTHS, 1.0 / unit), footprint=1.0 / unit)


CORRUPTIONS: dict[str, Corruption] = {
    "wrench 5 ms late at 100 Hz": Corruption(late(0.005), ("clocks",), (" ms late",), FAST, hits=0.1),
    "wrench 10 ms late at 100 Hz": Corruption(late(0.010), ("clocks",), (" ms late",), FAST, hits=0.4),
    "wrench 24 ms late": Corruption(late(0.024), ("clocks",), (" ms late",), PUSH, hits=0.7),
    "wrench 96 ms late": Corruption(late(0.096), ("clocks",), (" ms late",), PUSH),
    "wrench 60 ms early": Corruption(late(-0.06), ("clocks",), ("early",), PUSH),
    "clock drift of 3 %": Corruption(late(0.0, drift=0.03), ("clocks",), ("drift",), PUSH, hits=0.7),
    "clock jump in one episode": Corruption(
        late(0.0, jump=0.2, one=True), ("clocks",), ("clock jumps",), PUSH, hits=0.7
    ),
    "clock jump in all episodes": Corruption(late(0.0, jump=0.2), ("clocks",), ("clock jumps",), PUSH),
    "one episode 150 ms early": Corruption(
        late(0.0, jump=-0.15, one=True, after=0.0), ("clocks",), (" ms early relative",), PUSH, hits=0.7
    ),
    "gripper turned by 20 degrees": Corruption(turned_gripper, ("axes",), ("gripper_theta",), SENSOR),
    "gripper angles in degrees": Corruption(
        scaled({"gripper_theta": 180 / np.pi}), ("units",), ("π/180",), GRASP
    ),
    "all angles in degrees": Corruption(
        scaled({"gripper_theta": 180 / np.pi, "object_theta": 180 / np.pi}), ("units",), ("π/180",), GRASP
    ),
    "millimetres": Corruption(lengths(0.001), ("units",), ("millimetres",), PUSH),
    "centimetres": Corruption(lengths(0.01), ("units",), ("centimetres",), PUSH),
    "inches": Corruption(lengths(0.0254), ("units",), ("inches",), PUSH),
    "positions in centimetres": Corruption(
        scaled(dict.fromkeys(LENGTHS, 100.0)), ("units",), ("positions appear to be in centimetres",), PUSH
    ),
    "footprint in centimetres": Corruption(
        scaled({}, footprint=100.0), ("units",), ("lengths of the object appear to be in centimetres",), PUSH
    ),
    "N cm": Corruption(scaled({"torque": 100.0}), ("units",), ("N cm",), GRASP),
    "N mm": Corruption(scaled({"torque": 1000.0}), ("units",), ("N mm",), GRASP),
    "kgf against a weighed mass": Corruption(
        scaled({"force": 1 / KGF, "torque": 1 / KGF}), ("units",), ("kgf",), {**PUSH, "mass_given": True}
    ),
    "gain of 1.3 against a weighed mass": Corruption(
        scaled({"force": 1.3, "torque": 1.3}),
        ("mass",),
        ("gain of 1.",),
        {**PUSH, "mass_given": True},
        hits=0.7,
    ),
    "torque sign alone": Corruption(scaled({"torque": -1.0}), ("sign",), ("negate torque_z",), GRASP),
    "wrong sign": Corruption(other_sign, ("sign",), ("on_sensor", "on_object"), PUSH),
    "force_y reversed": Corruption(scaled({"force_y": -1.0}), ("axes",), ("negate force_y",), SENSOR),
    "quarter turn": Corruption(turned_force(np.pi / 2), ("axes",), ("gripper_theta",), SENSOR),
    "left-handed poses": Corruption(mirrored_poses, ("axes",), ("left-handed",), GRASP),
    "y of the poses reversed": Corruption(mirrored_position, ("axes",), ("left-handed",), GRASP),
    "angles clockwise": Corruption(clockwise, ("axes",), ("clockwise",), GRASP),
    "no tare": Corruption(not_tared, ("tare",), ("not tared",), {**TARED, "frame": "sensor"}),
    "sensor axes stated as world": Corruption(
        other_frame("world"),
        ("axes",),
        ('frame = "sensor"',),
        {**TARED, "frame": "sensor", "contact": "grasp"},
    ),
    "world axes stated as sensor": Corruption(
        other_frame("sensor"),
        ("axes",),
        ('frame = "world"',),
        {**TARED, "frame": "world", "contact": "grasp"},
    ),
    "object axes stated as world": Corruption(
        other_frame("world"),
        ("axes",),
        ('frame = "object"',),
        {**TARED, "frame": "object", "contact": "grasp"},
    ),
    "no pose for 1 s": Corruption(
        gap(("object", "gripper")), ("gaps",), ("no object pose sample",), {**PUSH, "rates": (60.0, 200.0)}
    ),
    "no wrench for 1 s": Corruption(gap(("force", "torque")), ("gaps",), ("no wrench sample",), PUSH),
    "frozen gripper": Corruption(frozen, ("gripper",), ("is frozen",), GRASP),
    "frozen gripper of a pusher": Corruption(
        frozen, ("gripper",), ("is frozen",), {**SENSOR, "contact": "point"}
    ),
    "another object in one episode": Corruption(
        another_object, ("episodes",), ("another object",), {**GRASP, "raw": False, "sign": "on_object"}
    ),
    "unsigned force": Corruption(unsigned, ("sign",), ("never negative",), {**TARED, "frame": "sensor"}),
}
