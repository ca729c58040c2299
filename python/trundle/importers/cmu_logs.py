"""Continuous CMU logs: force, tip and object while a flat tip pushes a small wooden triangle."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from trundle.importers.cmu_frames import MILLIMETRE, numbers, wrench_metadata
from trundle.importers.layout import Columns, Floats, Imported, ShowProgress, SourceError
from trundle.importers.rotations import heading, product
from trundle.importers.streams import Stream, interval, join
from trundle.importers.takes import clean_stream

__all__ = ["read"]

LOST_POSE_MM = np.array([668.54, -260.52])
"""Position that the tracker wrote when it had lost the object, mm."""
BODY_Y_UP = np.array([0.5, -0.5, -0.5, -0.5])
"""Rotation from the tracked body, which has y up, to the object frame, whose x and y are its z and x."""
TOOL_SIGNS = np.array([1.0, -1.0, -1.0])
"""Signs that rotate sensor axes to tool axes: the sensor hangs upside down, turned about the tool's x.

The reading is the force on the object. With these signs the force is along the normals of the touched sides,
and on average within 10 degrees of the motion of the contact point, in every log. The rotation by 45 degrees
of `pushes/` does not have this property.
"""
FOOTPRINT = [[-0.0402, -0.0077], [0.0415, -0.0653], [0.0174, 0.0740]]
"""Inferred footprint, m: the right-angled triangle with legs of 100 mm whose sides fit the tip positions in
contact best (0.25 mm RMS). The tip touched two sides only. The leg length is that of the authors, and the fit
includes the radius of the tip, so the position is uncertain by a few millimetres."""
FOOTPRINT_NOTE = (
    "the transform from the tracker's body to the triangle was not published: the footprint is inferred from "
    "the tip positions in contact; third side and mass centre follow from the shape, accurate to a few mm"
)
POINT_CONTACT_END_S = {"exp3_1": 35.0}
"""End of the point contact by log, s: later the flat tip is up to 2 cm past the end of the side, and a
corner of the object slides on its face."""
EARLIER_SESSION = ("exp3_1", "exp3_2")
"""Logs pushed at 3 and 2 mm/s; the others are pushed at 5 mm/s. Straight sliding takes half the force of the
other logs, at any speed within a log. The load or the floor was therefore different. A recording is of one
object, so these two logs make a separate recording."""
MIN_QUIET_DURATION_S = 1.0
"""Minimum duration of the tare interval, s."""


def read(
    source: Path, name: str | None, held_out_every: int, say: ShowProgress, chosen: list[str] | None = None
) -> Imported:
    """Read every `NAME_force.txt`, `NAME_pos.txt`, `NAME_robot.txt` of a folder as the episode NAME.

    Without `chosen` logs, those in `EARLIER_SESSION` are omitted.
    """
    found = sorted(path.name.removesuffix("_force.txt") for path in source.glob("*_force.txt"))
    if not found:
        raise SourceError(
            source, "no file NAME_force.txt; give the folder timeseries/, or one file of pushes/"
        )
    later = [log for log in found if log not in EARLIER_SESSION]
    logs = sorted(chosen) if chosen is not None else later or found
    remarks = [
        f"{log}: omitted, another load or floor; list it in `logs` of a map"
        for log in found
        if chosen is None and log not in logs
    ]
    episodes: dict[str, Columns] = {}
    precontact: dict[str, list[float]] = {}
    for log in logs:
        say(f"{source.name}: {log}")
        episodes[log], precontact[log], new_remarks = _episode(source, log)
        remarks += new_remarks
    metadata = {
        "format": "trundle-recording/1",
        "name": name or "CMU continuous logs",
        "at_rest": True,
        "object": {"footprint": FOOTPRINT},
        "wrench": wrench_metadata("on_object", precontact),
        "split": {"held_out": logs[held_out_every - 1 :: held_out_every]},
        "notes": {
            "origin": "github.com/robinzhoucmu/MLab_EXP, Zhou, Paolini, Bagnell and Mason, ICRA 2016",
            "motion": "quasi-static: the mass is not identifiable",
            "footprint": FOOTPRINT_NOTE,
            "split": f"one log of every {held_out_every} is held out",
        },
    }
    return Imported(metadata, episodes, remarks)


def _episode(source: Path, log: str) -> tuple[Columns, list[float], list[str]]:
    """Return the table, the tare interval (s) and the remarks on one log."""
    force_t, force = _records(source / f"{log}_force.txt", 3)
    pose_t, pose = _records(source / f"{log}_pos.txt", 7)
    tip_t, tip = _records(source / f"{log}_robot.txt", 7)
    start = min(force_t[0], pose_t[0], tip_t[0])
    seen = np.hypot(*(pose[:, :2] - LOST_POSE_MM).T) > 0.01
    remarks = [f"{np.sum(~seen)} poses of a lost tracker omitted"] if not np.all(seen) else []
    planar = np.column_stack([pose[:, :2] * MILLIMETRE, heading(product(pose[:, 3:], BODY_Y_UP))])[seen]
    tool = np.column_stack([tip[:, :2] * MILLIMETRE, heading(tip[:, 3:])])
    end = POINT_CONTACT_END_S.get(log, np.inf)
    if np.isfinite(end):
        remarks.append(f"cut at {end} s: afterwards a corner of the object slides on the face of the tip")
    streams = []
    for names, t, values in (
        (["object_x", "object_y", "object_theta"], pose_t[seen], planar),
        (["gripper_x", "gripper_y", "gripper_theta"], tip_t, tool),
        (["force_x", "force_y", "force_z"], force_t, force * TOOL_SIGNS),
    ):
        # Stamps are rounded to 10 ms, so differences are multiples of 10 ms.
        stream, new_remarks = clean_stream(
            Stream(names, np.round(t - start, 2), values), names[0].split("_")[0], False
        )
        streams.append(interval(stream, 0.0, end))
        remarks += new_remarks
    return join(streams), longest_quiet_interval(streams[-1]), [f"{log}: {remark}" for remark in remarks]


def _records(path: Path, width: int) -> tuple[Floats, Floats]:
    """Return times (n,) and values (n, width) of a file with two lines per record."""
    if not path.is_file():
        raise SourceError(
            path, "no such file; a log consists of NAME_force.txt, NAME_pos.txt, NAME_robot.txt"
        )
    lines = path.read_text(encoding="ascii", errors="replace").splitlines()
    if len(lines) % 2:
        raise SourceError(path, f"row {len(lines)}: time stamp without values; is the file complete?")
    times = numbers(path, lines[::2], range(1, len(lines), 2), 1)[:, 0]
    return times, numbers(path, lines[1::2], range(2, len(lines) + 1, 2), width)


def longest_quiet_interval(wrench: Stream) -> list[float]:
    """Return the longest interval without contact, s: the longest in which the force hardly varies.

    In contact, friction under the object varies the force by tens of millinewtons; without contact only the
    sensor noise of a few millinewtons remains. The first samples are not suitable: two logs begin in contact.
    """
    step = round(MIN_QUIET_DURATION_S / float(np.median(np.diff(wrench.t))))
    windows = np.lib.stride_tricks.sliding_window_view(wrench.values[:, :2], step, axis=0)
    spread = np.max(windows.max(axis=-1) - windows.min(axis=-1), axis=-1)
    still = np.append(spread <= 3.0 * max(spread.min(), 1e-3), False)
    edges = np.flatnonzero(np.diff(np.append(False, still).astype(int)))
    begins, ends = edges[::2], edges[1::2] - 1
    longest = int(np.argmax(ends - begins))
    return [float(wrench.t[begins[longest]]), float(wrench.t[ends[longest] + step - 1])]
