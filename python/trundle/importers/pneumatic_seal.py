"""Piston-seal friction: a 3D-printed pneumatic cylinder driven against constant pressure, about 100 Hz.

E. Zillen, "3D-printed pneumatic actuator" (thesis, Delft University of Technology), GitHub
`EvaZillen/3D-printed-pneumatic-actuator`, `results_pneumatic-actuator/data/friction/`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any, Literal

import numpy as np

from trundle.importers.cmu_frames import numbers
from trundle.importers.config import MapError, typed
from trundle.importers.joints.joint_map import merge
from trundle.importers.layout import Columns, Floats, Imported, ShowProgress, SourceError
from trundle.importers.seal_metadata import JOINT, RAIL

__all__ = ["NEEDS_MAP", "SealMap", "force_on_piston", "read"]

NEEDS_MAP = False

MILLIMETRE = 1e-3
MILLISECOND = 1e-3
BAR = 1e5
COLUMNS = 7
TIME, POSITION, PRESSURE, LOAD_CELL = 0, 4, 5, 6
BORES_M = {"O-ring": 25.0e-3, "X-ring257": 25.7e-3}
"""Bore of the cylinder by seal, m: the part of a file's name before the first `_`."""
MIN_REVERSAL_M = 5e-3
"""Minimum distance of the piston from a reversal, m. The stroke is 39 mm, the noise of the laser 0.1 mm."""
MAX_GAP_S = 0.5
"""Maximum gap within an episode, s. Gaps of up to 0.3 s are common; one log has a gap of 2.7 s."""


@dataclass(frozen=True)
class SealMap:
    """Settings of the import; all are optional.

    Attributes
    ----------
    name : str
        Name of the recording; the name of the file or folder by default.
    held_out : int
        Number of stroke pairs at the end of each file that are held out.
    files : list of str
        Names of the files of a folder to read, without `.csv`: one seal at several pressures.
    bore : float
        Bore of the cylinder in m, for seals other than `O-ring` and `X-ring257`.
    format : int
        Version of the recording's format: 1 for an object on a rail, 2 for a slide joint, whose effort is the
        load cell, with the pressure as a known effort and as the load of friction.
    """

    name: str | None = None
    held_out: int = 2
    files: list[str] | None = None
    bore: float | None = None
    format: Literal[1, 2] = 1


def read(source: Path, settings: Mapping[str, Any], say: ShowProgress) -> Imported:
    """Read one log, or several logs of one seal from a folder, as a rail recording.

    An episode is a pair of strokes, forth and back, from one inner reversal to the next. A pair is the
    shortest piece that separates friction, which changes sign with the motion, from a constant force.
    """
    options = typed(SealMap, settings)
    if options.held_out < 1:
        raise MapError(f"`held_out` = {options.held_out}: must be at least 1 pair of strokes per file")
    files = _files(source, options.files)
    bore = _bore(files, options.bore)
    episodes: dict[str, Columns] = {}
    held_out: list[str] = []
    remarks: list[str] = []
    for path in files:
        say(path.name)
        pairs, new_remarks = _pairs(path, bore, options.format)
        if len(pairs) <= options.held_out:
            raise SourceError(
                path,
                f"{len(pairs)} pairs of strokes and `held_out` = {options.held_out}: no pair to fit remains",
            )
        prefix = "episode" if len(files) == 1 else path.stem
        names = [f"{prefix}_{k:02}" for k in range(len(pairs))]
        episodes |= dict(zip(names, pairs, strict=True))
        held_out += names[-options.held_out :]
        remarks += new_remarks
    metadata = merge(
        RAIL if options.format == 1 else JOINT,
        {
            "name": options.name or f"piston seal, {source.stem}",
            "split": {"held_out": held_out},
            "notes": {"bore_m": bore, "files": [path.name for path in files]},
        },
    )
    return Imported(metadata, episodes, remarks)


def force_on_piston(load_cell: Floats, pressure: Floats, bore: float) -> Floats:
    """Return the known force on the piston along its position, N.

    The load cell reads a push of the drive towards greater position as positive; the air pushes back:

        F = F_load - p π d² / 4

    In slow motion F is the force that overcomes friction, so F has the sign of the velocity. The signs are
    those of the data: F_load grows with the pressure, and F is positive on average in every stroke towards
    greater position and negative in every stroke back.

    Parameters
    ----------
    load_cell : (n,) array
        N.
    pressure : (n,) array
        Gauge pressure, Pa.
    bore : float
        m.
    """
    return load_cell - pressure * (np.pi * bore**2 / 4.0)


def _files(source: Path, chosen: list[str] | None) -> list[Path]:
    """Return the logs to read, in the given order."""
    if not source.is_dir():
        if chosen is not None:
            raise MapError("`files`: applies only to a folder; remove it for a single file")
        return [source]
    if not chosen:
        logs = ", ".join(sorted(path.stem for path in source.glob("*.csv"))) or "none"
        raise SourceError(
            source,
            "is a folder: give one of its files, or a map with `files`, the logs of one seal; "
            f"the logs are {logs}",
        )
    if len(set(chosen)) < len(chosen):
        raise MapError(f"`files` = {chosen}: list each log once")
    return [source / f"{name}.csv" for name in chosen]


def _bore(files: list[Path], given: float | None) -> float:
    """Return the bore of the seal in all files, m."""
    seals = sorted({path.stem.split("_")[0] for path in files})
    if len(seals) > 1:
        raise MapError(
            f"`files` are of the seals {', '.join(seals)}: choose logs of one seal, because a recording is "
            "of one object"
        )
    if given is not None:
        if not 0.0 < given < 1.0:
            raise MapError(f"`bore` = {given}: give the bore of the cylinder in m, 0.025 for example")
        return given
    if seals[0] not in BORES_M:
        raise MapError(
            f"{files[0].name}: seal `{seals[0]}` is not one of {', '.join(BORES_M)}; give its `bore` (m) "
            "in a map"
        )
    return BORES_M[seals[0]]


def _pairs(path: Path, bore: float, form: int) -> tuple[list[Columns], list[str]]:
    """Return one table for each pair of strokes of a log, and remarks."""
    t, x, pressure, load_cell = _samples(path)
    columns = _columns(form, x, pressure, load_cell, bore)
    edges = _inner_reversals(x)
    pairs: list[Columns] = []
    remarks: list[str] = []
    for begin, end in pairwise(edges):
        rows = _longest_run(t, begin, end)
        if len(rows) < end - begin:
            remarks.append(
                f"{path.name}: {end - begin - len(rows)} rows of pair {len(pairs) + 1} omitted because of a "
                f"gap of more than {MAX_GAP_S} s"
            )
        times = np.round(t[rows] - t[rows[0]], 3)
        pairs.append({"t": times} | {name: values[rows] for name, values in columns.items()})
    if edges[-1] < len(t) and pairs:
        remarks.append(
            f"{path.name}: {len(t) - edges[-1]} rows after the last complete pair of strokes omitted"
        )
    if not pairs:
        raise SourceError(
            path,
            f"no pair of strokes: the position moves by less than {MIN_REVERSAL_M * 1e3:g} mm back and forth",
        )
    return pairs, remarks


def _columns(form: int, x: Floats, pressure: Floats, load_cell: Floats, bore: float) -> Columns:
    """Return the columns of a recording of a format version, without the time."""
    if form == 1:
        force = force_on_piston(load_cell, pressure, bore)
        return {"object_x": x, "force_x": force, "note_pressure": pressure}
    return {
        "q_piston": x,
        "effort_piston": load_cell,
        "known_piston": force_on_piston(np.zeros_like(load_cell), pressure, bore),
        "load_piston": pressure,
    }


def _samples(path: Path) -> tuple[Floats, Floats, Floats, Floats]:
    """Return time (s), position (m), pressure (Pa) and load cell (N) of a log."""
    if not path.is_file():
        raise SourceError(path, "no such file")
    lines = path.read_text(encoding="ascii", errors="replace").splitlines()
    table = numbers(path, lines, range(1, len(lines) + 1), COLUMNS)
    t = table[:, TIME] * MILLISECOND
    late = np.flatnonzero(np.diff(t) <= 0.0)
    if len(late):
        row = int(late[0]) + 2
        raise SourceError(
            path, f"row {row}: time {table[row - 1, TIME]:g} ms is not greater than in the row before"
        )
    return t, table[:, POSITION] * MILLIMETRE, table[:, PRESSURE] * BAR, table[:, LOAD_CELL]


def _inner_reversals(x: Floats) -> list[int]:
    """Return the first rows of the pairs of strokes, and the row after the last pair.

    Pairs meet at the reversals at the inner end, where the position is smallest. A log starts and ends there.
    """
    edges = [0]
    extreme, forth = 0, True
    for k in range(1, len(x)):
        away = x[k] - x[extreme] if forth else x[extreme] - x[k]
        if away >= 0.0:
            extreme = k
        elif -away > MIN_REVERSAL_M:
            if not forth:
                edges.append(extreme)
            extreme, forth = k, not forth
    complete = not forth and x[-1] - x[edges[-1]] < MIN_REVERSAL_M
    return [*edges, len(x)] if complete else edges


def _longest_run(t: Floats, begin: int, end: int) -> np.ndarray:
    """Return the longest run of rows in [begin, end) without a gap of more than `MAX_GAP_S`."""
    gaps = begin + 1 + np.flatnonzero(np.diff(t[begin:end]) > MAX_GAP_S)
    runs = np.split(np.arange(begin, end), gaps - begin)
    return max(runs, key=len)
