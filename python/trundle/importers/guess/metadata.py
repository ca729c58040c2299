"""Keys of `[recording]` that no log contains: outline, frame, sign and tare of the wrench."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from trundle.importers.guess.result import Question
from trundle.importers.layout import Floats

__all__ = ["missing_metadata", "quiet_start"]

QUIET_SIGMAS = 8.0
"""Deviation from the initial force, in its standard deviations, at which contact may begin."""
SHAPE_EXAMPLE = "[[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]]"


def missing_metadata(
    recording: Mapping[str, Any], columns: Iterable[str], quiet: str = "", ask_raw: bool = False
) -> list[Question]:
    """Return all keys of `[recording]` that are required and missing.

    Parameters
    ----------
    recording : mapping
        Tables that the map copies to `recording.toml`.
    columns : iterable of str
        Columns of the recording.
    quiet : str
        Evidence about the beginning of contact, for the question about `precontact`.
    ask_raw : bool
        Also ask for `raw`, which is false by default.
    """
    present = set(columns)
    body, wrench = _table(recording, "object"), _table(recording, "wrench")
    on_rail = body.get("dof") == ["x"]
    found = []
    if not on_rail and not body.get("footprint") and not body.get("fixture"):
        text = "corners of the outline of the object, m, in the frame of object_x, object_y, object_theta"
        found.append(Question("recording.object.footprint", text, (), SHAPE_EXAMPLE))
    if "frame" not in wrench:
        no_gripper = "gripper_x" not in present and "object_x" in present
        frames = ("object", "world") if no_gripper else ("sensor", "object", "world")
        found.append(Question("recording.wrench.frame", "axes of the force and the torque", frames))
    if "sign" not in wrench:
        text = "whether the reading is the wrench on the object or its reaction on the sensor"
        found.append(Question("recording.wrench.sign", text, ("on_object", "on_sensor")))
    found += _missing_tare(wrench, present, quiet, ask_raw)
    if (
        not on_rail
        and "torque_z" not in present
        and wrench.get("contact") != "point"
        and "force_x" in present
    ):
        text = "no torque_z; set this if the object is touched at a point, otherwise map columns.torque_z"
        found.append(Question("recording.wrench.contact", text, ("point",)))
    return found


def _table(recording: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    table = recording.get(name, {})
    return table if isinstance(table, Mapping) else {}


def _missing_tare(wrench: Mapping[str, Any], present: set[str], quiet: str, ask_raw: bool) -> list[Question]:
    """Ask whether the reading is raw, and for the interval of the tare."""
    if wrench.get("frame", "sensor") != "sensor" or ("gripper_x" not in present and "raw" not in wrench):
        return []
    found = []
    if ask_raw and "raw" not in wrench:
        text = "whether the reading still includes the sensor's offset and the gripper's weight"
        found.append(Question("recording.wrench.raw", text, ("true", "false")))
    if wrench.get("raw", ask_raw) is True and "precontact" not in wrench:
        only = "" if "raw" in wrench else ", only if raw = true"
        text = f"interval without contact for the tare, s after the start{only}{quiet}"
        found.append(Question("recording.wrench.precontact", text, (), "[0.0, 0.3]"))
    return found


def quiet_start(t: Floats, wrench: Floats) -> float | None:
    """Return how long a wrench stays at its initial level, s; None if that is under 0.1 s.

    Parameters
    ----------
    t : (n,) array
        Times from the start, s.
    wrench : (n, k) array
        Readings, in any units.
    """
    first = t < 0.1
    if np.sum(first) < 5:
        return None
    level, sd = wrench[first].mean(axis=0), wrench[first].std(axis=0, ddof=1)
    moved = np.any(np.abs(wrench - level) > QUIET_SIGMAS * sd + 1e-9, axis=1)
    end = float(t[np.argmax(moved)]) if moved.any() else float(t[-1])
    return end if end >= 0.1 else None
