"""Logged motions of a LeRobot SO-101 arm with Feetech STS3215 servos, 50 Hz.

GitHub `isaac-sim2real/sage`, `output/real/so101/custom/`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from trundle.importers.config import MapError, typed
from trundle.importers.joints.columns import Kind, known
from trundle.importers.joints.csv_map import CsvFileMap, JointCsvMap, read_csv
from trundle.importers.joints.joint_map import mechanism_of, merge
from trundle.importers.layout import Columns, Imported, ShowProgress, SourceError
from trundle.importers.quantity import Quantity

__all__ = ["NEEDS_MAP", "ArmMap", "read"]

NEEDS_MAP = False

LIST = "joint_list.txt"
FILES: dict[str, dict[Kind, str]] = {
    "state_motor.csv": {"q": "positions", "v": "velocities", "effort": "torques"},
    "control.csv": {"target": "positions"},
}
"""Columns of lists in each file of a motion."""
SPEED_DELAY_S = 0.018
"""Delay of the logged velocities, s: 16 to 20 ms."""
POSITION_STEP_RAD = 2.0 * np.pi / 4096
JAW = "Jaw"
JAW_RADIANS = 1523 * POSITION_STEP_RAD
"""Angle of the jaw's servo for the opening 1, rad.

The log has an opening from 0 to 1 in steps of 1/1523, but the velocity of the servo in rad/s.
"""
VERTICAL = "Rotation"
"""The joint with a vertical axis, on which gravity does not act."""


@dataclass(frozen=True)
class ArmMap:
    """Settings of the import; all are optional, but several joints need a model.

    Attributes
    ----------
    name : str
        Name of the recording.
    joint : str
        The joint to import as a single axis.
    joints : list of str, or dict of str to str
        The joints of a model to import; as a dictionary, the name in the log of each joint of the model.
    motions : list of str
        Motions to import; by default all in the folder.
    piece : float
        Length of an episode, s. Every third piece of a motion is held out.
    recording : dict
        Tables that are added to `recording.toml`: `mechanism.model` is required for several joints.
    """

    name: str | None = None
    joint: str | None = None
    joints: list[str] | dict[str, str] | None = None
    motions: list[str] | None = None
    piece: float = 20.0
    recording: dict[str, Any] = field(default_factory=dict)


def read(source: Path, settings: Mapping[str, Any], say: ShowProgress) -> Imported:
    """Read one motion, or the motions in a folder."""
    options = typed(ArmMap, settings)
    if not source.is_dir():
        raise SourceError(source, "not a folder; give the folder of a motion, or that of several")
    if not 0.5 <= options.piece < float("inf"):
        raise MapError(f"`piece` = {options.piece}: must be at least 0.5 s")
    one = (source / LIST).is_file()
    folder = source.parent if one else source
    motions = [source.name] if one else _motions(source, options.motions)
    order = _order(folder / motions[0] / LIST)
    joints = _joints(options, order)
    recording = merge(_metadata(joints, options.joint is not None), options.recording)
    imported: dict[str, Imported] = {}
    for motion in motions:
        files = tuple(
            CsvFileMap(
                path=f"{motion}/{name}",
                time=Quantity(name="timestamp", unit="us"),
                lists=dict(lists),
                order=_order(folder / motion / LIST),
            )
            for name, lists in FILES.items()
        )
        log_map = JointCsvMap(joints=joints, angle="radians", file=files, recording=recording)
        imported[motion] = read_csv(folder, log_map, say)
        _open_jaw(imported[motion], joints)
    episodes, held_out = _pieces(imported, options.piece)
    first = imported[motions[0]]
    metadata = merge(first.metadata, {"name": options.name or f"SO-101, {', '.join(joints)}"})
    if held_out:
        metadata.setdefault("split", {"held_out": held_out})
    remarks = [f"{motion}: {remark}" for motion, each in imported.items() for remark in each.remarks]
    return Imported(metadata, episodes, remarks)


def _motions(source: Path, chosen: list[str] | None) -> list[str]:
    found = sorted(path.parent.name for path in source.glob(f"*/{LIST}"))
    if not found:
        raise SourceError(source, f"no folder with {LIST}; give the folder of the data set")
    for motion in chosen or []:
        if motion not in found:
            raise MapError(f"`motions`: no motion {motion!r}; the motions are {', '.join(found)}")
    return chosen or found


def _order(path: Path) -> list[str]:
    """Return the names of the joints in the order of the lists."""
    try:
        names = path.read_text(encoding="utf-8").split()
    except (OSError, UnicodeError) as error:
        raise SourceError(
            path, f"cannot be read ({error}); it must contain the names of the joints"
        ) from error
    if not names or len(set(names)) < len(names):
        raise SourceError(
            path, f"must contain the name of each joint once, but has {' '.join(names) or 'none'}"
        )
    return names


def _joints(options: ArmMap, order: list[str]) -> list[str] | dict[str, str]:
    """Return the joints to import."""
    if options.joint is not None and options.joints is not None:
        raise MapError("give either `joint`, a single axis, or `joints`, those of a model")
    joints = [options.joint] if options.joint is not None else options.joints or order
    for name in joints.values() if isinstance(joints, dict) else joints:
        if name not in order:
            raise MapError(f"`{'joint' if options.joint else 'joints'}`: no joint {name!r}; {known(order)}")
    model = mechanism_of(options.recording).get("model")
    if options.joint is None and model is None:
        raise MapError(
            f"{len(joints)} joints need a model, which the data set does not contain: set `model` in "
            "[recording.mechanism] to an MJCF or URDF file whose joints have these names (or give their "
            f'names in `joints`), or import a single axis with `joint` = "{order[1 % len(order)]}"'
        )
    return joints


def _metadata(joints: list[str] | dict[str, str], single: bool) -> dict[str, Any]:
    """Return the tables of `recording.toml`, without the model of several joints."""
    log_names = joints.values() if isinstance(joints, dict) else joints
    axis = {"axis": "hinge", "gravity": VERTICAL not in log_names}
    return {
        **({"mechanism": axis} if single else {}),
        "effort": {"source": "current", "gain": "free", "signed": False},
        "target": {"stiffness": "free", "damping": "free"},
        "noise": {"position_step": POSITION_STEP_RAD},
        "delay": {"v": SPEED_DELAY_S},
        "notes": {
            "origin": "github.com/isaac-sim2real/sage, output/real/so101/custom",
            "licence": "Apache-2.0",
            "effort": "magnitude of the current times a constant of unverified scale, in steps of 0.0228",
            "control": "position control with gains P 16, I 0, D 32 of the firmware",
            "jaw": f"{JAW}: logged opening from 0 to 1 times {JAW_RADIANS:.4g} rad, the angle of the servo",
        },
    }


def _open_jaw(imported: Imported, joints: list[str] | dict[str, str]) -> None:
    """Convert positions and targets of the jaw from openings to angles, in place."""
    log_names = joints if isinstance(joints, dict) else {name: name for name in joints}
    for joint, name in log_names.items():
        for table in imported.episodes.values() if name == JAW else ():
            for kind in ("q", "target"):
                table[f"{kind}_{joint}"] = table[f"{kind}_{joint}"] * JAW_RADIANS


def _pieces(imported: Mapping[str, Imported], length: float) -> tuple[dict[str, Columns], list[str]]:
    """Return pieces of the motions, and the names of those that are held out."""
    episodes: dict[str, Columns] = {}
    held_out: list[str] = []
    for motion, each in imported.items():
        (table,) = each.episodes.values()
        count = max(1, round(float(table["t"][-1]) / length))
        piece = np.minimum((table["t"] / length).astype(int), count - 1)
        for k in range(count):
            rows = np.flatnonzero(piece == k)
            name = f"{motion}_{k:02}"
            episodes[name] = {column: values[rows] for column, values in table.items()}
            episodes[name]["t"] = table["t"][rows] - table["t"][rows[0]]
            if k % 3 == 2:
                held_out.append(name)
    return episodes, held_out
