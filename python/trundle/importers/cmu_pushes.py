"""Single CMU pushes: 50 per file, with force and tip throughout and the object pose before and after."""

from __future__ import annotations

import itertools
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from trundle.importers.cmu_frames import MILLIMETRE, numbers, wrench_metadata
from trundle.importers.layout import Columns, Floats, Imported, ShowProgress, SourceError
from trundle.importers.rotations import heading
from trundle.importers.streams import Stream, drop_stale, join

__all__ = ["FOOTPRINT", "MASS_KG", "read", "support"]

FOOTPRINT = [[0.0, 0.0], [0.15, 0.0], [0.0, 0.15]]
"""Footprint of the aluminium triangle, m: origin at the right-angled corner, axes along the legs."""
MASS_KG = 1.518
"""Mass as weighed by the authors, kg."""
TOOL_FROM_SENSOR = np.array([[1.0, 1.0], [1.0, -1.0]]) / np.sqrt(2.0)
"""Rotation from sensor to tool axes: the sensor hangs upside down, turned by 45 degrees. It reads the force
on itself."""
RESOLUTION = 1e-6
"""Resolution of the logs, m, rad and N."""
TARE_SAMPLES = 5
"""Number of initial samples without contact in every push, as the authors use them."""
MAX_TARE_DURATION_S = 0.3
"""Maximum duration of the tare, s: most pushes have no contact for this long."""
MIN_CONTACT_FORCE_N = 0.1
"""Change of force from the mean of the first samples that indicates contact, N (sensor noise: 0.01 N)."""


def read(source: Path, name: str | None, held_out_every: int, say: ShowProgress) -> Imported:
    """Read one file of pushes; every `held_out_every`-th push is held out."""
    shape: dict[str, object] = {"footprint": FOOTPRINT, "mass": MASS_KG}
    feet = support(source)
    if feet:
        shape["support"] = feet
    log = _Log(source)
    pushes: dict[str, _Push] = {}
    for index in range(int(log.take(1, 1)[0, 0])):
        episode = f"push_{index + 1:02d}"
        say(f"{source.name}: {episode}")
        pushes[episode] = _push(log)
    precontact = {episode: [0.0, push.free] for episode, push in pushes.items()}
    metadata: dict[str, Any] = {
        "format": "trundle-recording/1",
        "name": name or f"CMU pushes, {source.stem}",
        "at_rest": True,
        "object": shape,
        "wrench": wrench_metadata("on_sensor", precontact),
        "split": {"held_out": list(pushes)[held_out_every - 1 :: held_out_every]},
        "notes": {
            "origin": "github.com/robinzhoucmu/MLab_EXP, Zhou, Paolini, Bagnell and Mason, ICRA 2016",
            "split": f"every {held_out_every}th push is held out",
            "motion": "quasi-static, 2.5 mm/s: the mass was weighed and is not identifiable",
            "noise": "pose: last pose of a push minus first pose of the next; force: readings before contact",
        },
    }
    if len(pushes) > 1:
        metadata["noise"] = _noise(list(pushes.values()))
    stale = sum(push.stale for push in pushes.values())
    early = sum(push.free < MAX_TARE_DURATION_S for push in pushes.values())
    remarks = [
        f"{stale} repeated tip positions omitted",
        f"{early} pushes begin contact within {MAX_TARE_DURATION_S} s: their tare is shorter",
    ]
    return Imported(metadata, {episode: push.table for episode, push in pushes.items()}, remarks)


@dataclass(frozen=True)
class _Push:
    """One push: table, end of the tare (s), dropped repeats, poses at both ends (2, 3), force noise (N)."""

    table: Columns
    free: float
    stale: int
    poses: Floats
    force_noise: float


def _noise(pushes: Sequence[_Push]) -> dict[str, object]:
    """Return the table `[noise]`, from the pose difference between the end of a push and the next start."""
    gaps = np.array([after.poses[0] - before.poses[1] for before, after in itertools.pairwise(pushes)])
    gaps[:, 2] = np.remainder(gaps[:, 2] + np.pi, 2.0 * np.pi) - np.pi
    # The median is robust against an object that was repositioned; 1.4826 scales it to a normal deviation.
    pose = 1.4826 * np.median(np.abs(gaps), axis=0) / np.sqrt(2.0)
    force = float(np.median([push.force_noise for push in pushes]))
    return {"pose": [_rounded(sd) for sd in pose], "force": _rounded(force)}


def _rounded(sd: float) -> float:
    return float(f"{max(sd, RESOLUTION):.2g}")


def support(source: Path) -> list[list[float]]:
    """Return the support points, m, from a file name `surface__x1_x2_x3_y1_y2_y3`; empty for a flat face."""
    named = re.fullmatch(r"[a-z]+__(.+)", source.stem)
    if not named:
        raise SourceError(
            source,
            "the file name must be surface__x1_x2_x3_y1_y2_y3.txt (support points, mm) or surface__patch.txt",
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
    """Sequential reader of the lines of one file."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._lines = path.read_text(encoding="ascii", errors="replace").splitlines()
        self._at = 0

    def take(self, count: int, width: int) -> Floats:
        """Return the next `count` lines of `width` numbers."""
        lines = self._lines[self._at : self._at + count]
        if len(lines) < count:
            raise SourceError(
                self.path, f"ends after row {len(self._lines)}, within a push; is the file complete?"
            )
        values = numbers(self.path, lines, range(self._at + 1, self._at + count + 1), width)
        self._at += count
        return values

    def block(self, width: int) -> Floats:
        """Return a counted block: a line with a number of lines, then those."""
        return self.take(int(self.take(1, 1)[0, 0]), width)


def _push(log: _Log) -> _Push:
    """Read the next push."""
    before_after = log.take(2, 7)
    poses = np.column_stack([before_after[:, :2] * MILLIMETRE, heading(before_after[:, 3:])])
    force, tip = log.block(3), log.block(8)
    start = min(force[0, 0], tip[0, 0])
    wrench = Stream(["force_x", "force_y"], force[:, 0] - start, force[:, 1:] @ TOOL_FROM_SENSOR.T)
    planar = np.column_stack([tip[:, 1:3] * MILLIMETRE, heading(tip[:, 4:])])
    gripper, stale = drop_stale(
        Stream(["gripper_x", "gripper_y", "gripper_theta"], tip[:, 0] - start, planar)
    )
    end = max(wrench.t[-1], gripper.t[-1])
    body = Stream(["object_x", "object_y", "object_theta"], np.array([0.0, end]), poses)
    free = _contact_free_until(wrench)
    quiet = wrench.values[wrench.t <= free]
    noise = float(np.sqrt(np.mean(np.var(quiet, axis=0, ddof=1))))
    return _Push(join([body, gripper, wrench]), free, stale, poses, noise)


def _contact_free_until(wrench: Stream) -> float:
    """Return the end of the tare, s: the last time without contact, at least `TARE_SAMPLES` samples."""
    zero = wrench.values[:TARE_SAMPLES].mean(axis=0)
    touching = np.flatnonzero(np.hypot(*(wrench.values - zero).T) > MIN_CONTACT_FORCE_N)
    last = touching[0] - 1 if len(touching) else len(wrench.t) - 1
    return float(round(min(MAX_TARE_DURATION_S, wrench.t[max(last, TARE_SAMPLES - 1)]), 3))
