"""CMU's single pushes: 50 in a file, force and tip throughout, the object's pose before and after."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from trundle.importers.cmu_frames import MILLIMETRE, numbers, wrench_metadata
from trundle.importers.layout import Columns, Floats, Imported, Say, SourceError
from trundle.importers.rotations import heading
from trundle.importers.streams import Stream, join, unstale

__all__ = ["FOOTPRINT", "MASS", "read", "support"]

FOOTPRINT = [[0.0, 0.0], [0.15, 0.0], [0.0, 0.15]]
"""The aluminium triangle, m: origin at the right-angled corner, axes along the legs."""
MASS = 1.518
"""kg, weighed by the authors."""
TOOL_FROM_SENSOR = np.array([[1.0, 1.0], [1.0, -1.0]]) / np.sqrt(2.0)
"""The sensor hangs upside down, turned by 45 degrees in the tool; it reads the force on itself."""
TARE_SAMPLES = 5
"""The authors' own zero: so many samples are free of contact in every push."""
TARE_LIMIT = 0.3
"""s; most pushes are free of contact for so long."""
TOUCH = 0.1
"""N, off the first samples' mean: the pusher touches (the sensor's noise is 0.01 N)."""


def read(source: Path, name: str | None, held_out_every: int, say: Say) -> Imported:
    """Read one file of pushes; every `held_out_every`th is held out."""
    log = _Log(source)
    count = int(log.take(1, 1)[0, 0])
    episodes: dict[str, Columns] = {}
    precontact: dict[str, list[float]] = {}
    stale = 0
    for index in range(count):
        episode = f"push_{index + 1:02d}"
        say(f"{source.name}: {episode}")
        episodes[episode], free, dropped = _push(log)
        precontact[episode] = [0.0, free]
        stale += dropped
    shape: dict[str, object] = {"footprint": FOOTPRINT, "mass": MASS}
    feet = support(source)
    if feet:
        shape["support"] = feet
    metadata = {
        "format": "trundle-recording/1",
        "name": name or f"CMU pushes, {source.stem}",
        "at_rest": True,
        "object": shape,
        "wrench": wrench_metadata("on_sensor", precontact),
        "split": {"held_out": list(episodes)[held_out_every - 1 :: held_out_every]},
        "notes": {
            "origin": "github.com/robinzhoucmu/MLab_EXP, Zhou, Paolini, Bagnell and Mason, ICRA 2016",
            "split": f"every {held_out_every}th push is held out",
            "motion": "quasi-static, 2.5 mm/s: the mass is weighed, the pushes do not hold it",
        },
    }
    early = sum(free < TARE_LIMIT for _, free in precontact.values())
    remarks = [
        f"{stale} repeated tip positions left out",
        f"{early} pushes touch within {TARE_LIMIT} s: shorter tare",
    ]
    return Imported(metadata, episodes, remarks)


def support(source: Path) -> list[list[float]]:
    """Return the feet, m, from a file name `surface__x1_x2_x3_y1_y2_y3`; none where the face is flat."""
    named = re.fullmatch(r"[a-z]+__(.+)", source.stem)
    if not named:
        raise SourceError(
            source,
            "the file's name says where the feet are, surface__x1_x2_x3_y1_y2_y3.txt or surface__patch.txt",
        )
    if named[1] == "patch":
        return []
    try:
        x1, x2, x3, y1, y2, y3 = (float(word) * MILLIMETRE for word in named[1].split("_"))
    except ValueError as error:
        raise SourceError(
            source, f"the name's part {named[1]!r} is neither `patch` nor six numbers"
        ) from error
    return [[round(x, 6), round(y, 6)] for x, y in ((x1, y1), (x2, y2), (x3, y3))]


class _Log:
    """The lines of one file, taken from the top."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._lines = path.read_text(encoding="ascii", errors="replace").splitlines()
        self._at = 0

    def take(self, count: int, width: int) -> Floats:
        """Return the next `count` lines of `width` numbers."""
        lines = self._lines[self._at : self._at + count]
        if len(lines) < count:
            raise SourceError(
                self.path, f"ends after row {len(self._lines)}, within a push; is the file whole?"
            )
        values = numbers(self.path, lines, self._at + 1, width)
        self._at += count
        return values

    def block(self, width: int) -> Floats:
        """Return a counted block: a line with a number of lines, then those."""
        return self.take(int(self.take(1, 1)[0, 0]), width)


def _push(log: _Log) -> tuple[Columns, float, int]:
    """Return the table of the next push, the end of its tare in s, and the repeats left out."""
    poses = log.take(2, 7)
    force, tip = log.block(3), log.block(8)
    start = min(force[0, 0], tip[0, 0])
    wrench = Stream(["force_x", "force_y"], force[:, 0] - start, force[:, 1:] @ TOOL_FROM_SENSOR.T)
    planar = np.column_stack([tip[:, 1:3] * MILLIMETRE, heading(tip[:, 4:])])
    gripper, dropped = unstale(Stream(["gripper_x", "gripper_y", "gripper_theta"], tip[:, 0] - start, planar))
    end = max(wrench.t[-1], tip[-1, 0] - start)
    before_after = np.column_stack([poses[:, :2] * MILLIMETRE, heading(poses[:, 3:])])
    table = join(
        [
            Stream(["object_x", "object_y", "object_theta"], np.array([0.0, end]), before_after),
            gripper,
            wrench,
        ]
    )
    return table, _free(wrench), dropped


def _free(wrench: Stream) -> float:
    """Return until when, s, nothing touches: the tare's end, the authors' five samples at least."""
    zero = wrench.values[:TARE_SAMPLES].mean(axis=0)
    touching = np.flatnonzero(np.hypot(*(wrench.values - zero).T) > TOUCH)
    last = touching[0] - 1 if len(touching) else len(wrench.t) - 1
    return float(round(min(TARE_LIMIT, wrench.t[max(last, TARE_SAMPLES - 1)]), 3))
