"""CSV logs of joints, which become recordings together with an MJCF or URDF model."""

from __future__ import annotations

import csv
import math
import os
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from trundle._native import JointRecording, Recording, TrundleError, read
from trundle.joint_episode import STREAMS

__all__ = ["HELD_OUT_SHARE", "open_joints", "read_log"]

Floats = NDArray[np.float64]

HELD_OUT_SHARE = 0.25
"""Share of a log's duration, at its end, that is held out."""

PathLike = str | os.PathLike[str]


def open_joints(
    recording: Recording | JointRecording | PathLike, mjcf: PathLike | None, *, has_simulator: bool = False
) -> JointRecording | None:
    """Return a recording of joints, or None for one of a pushed object.

    Parameters
    ----------
    recording : Recording, JointRecording or path
        A folder, or a CSV file if `mjcf` is given or `has_simulator` is true.
    mjcf : path, optional
    has_simulator : bool
        Whether the user's own simulator replaces a model.
    """
    if isinstance(recording, JointRecording):
        return recording
    if isinstance(recording, Recording):
        return None
    path = Path(recording)
    if path.suffix.lower() == ".csv":
        if mjcf is None and not has_simulator:
            raise TrundleError(
                f"{path}: is a table without a model; give the MJCF or URDF file with --mjcf FILE (`mjcf`), "
                "your own simulator as `step`, or a folder with recording.toml"
            )
        return read_log(path, mjcf)
    found = read(path)
    return found if isinstance(found, JointRecording) else None


def read_log(path: PathLike, mjcf: PathLike | None) -> JointRecording:
    """Return a CSV log of joints as a recording whose last quarter is held out.

    Parameters
    ----------
    path : path
        Columns as in a recording: ``t``, ``q_JOINT``, and ``effort_JOINT`` or ``target_JOINT``; SI units.
    mjcf : path or None
        The MJCF or URDF file with these joints. Without one, all joints are hinges of a black-box simulator.

    Raises
    ------
    TrundleError
        If the file cannot be read, has no such columns, or a cell is not a number.
    """
    path = Path(path)
    columns = _columns(path)
    if "t" not in columns:
        raise TrundleError(
            f"{path}: no column `t` with the time in seconds; the columns are {', '.join(columns)}"
        )
    joints = [name.removeprefix("q_") for name in columns if name.startswith("q_")]
    if not joints:
        listed = ", ".join(columns)
        raise TrundleError(
            f"{path}: no column q_JOINT with a joint's position in rad or m; the columns are {listed}; "
            "rename them, or convert the file with `trundle import`"
        )
    known = {"t", *(f"{prefix}_{joint}" for prefix in STREAMS for joint in joints)}
    unknown = [name for name in columns if name not in known and not name.startswith("note_")]
    if unknown:
        raise TrundleError(
            f"{path}: column {unknown[0]}: is not a stream of the joints {', '.join(joints)}; streams are "
            f"{', '.join(f'{prefix}_JOINT' for prefix in STREAMS)}; begin other columns with note_"
        )
    mechanism: dict[str, object] = {"joints": joints}
    files = {}
    if mjcf is None:
        mechanism["types"] = "hinge"
    else:
        document = Path(mjcf)
        if not document.is_file():
            raise TrundleError(f"{mjcf}: no such file; give an MJCF or URDF file")
        mechanism["model"] = document.name
        files[document.name] = document.read_bytes()
    metadata = {
        "format": "trundle-recording/2",
        "name": path.stem,
        "mechanism": mechanism,
        "split": {"held_out": ["held_out"]},
    }
    return JointRecording(metadata, _split(columns), files)


def _split(columns: dict[str, Floats]) -> dict[str, dict[str, Floats]]:
    """Return the training and the held-out part of a log."""
    t = columns["t"]
    first = int(np.searchsorted(t, t[0] + (1 - HELD_OUT_SHARE) * (t[-1] - t[0])))
    parts = {"training": slice(0, first), "held_out": slice(first, None)}
    return {name: {key: values[rows] for key, values in columns.items()} for name, rows in parts.items()}


def _columns(path: Path) -> dict[str, Floats]:
    """Return the columns of a CSV file; empty cells are NaN, and note_ columns are omitted."""
    try:
        with path.open(encoding="utf-8-sig", newline="") as stream:
            rows = list(csv.reader(stream))
    except FileNotFoundError as error:
        raise TrundleError(f"{path}: no such file") from error
    except (UnicodeDecodeError, csv.Error) as error:
        raise TrundleError(f"{path}: not a CSV file: {error}") from error
    if len(rows) < 2:
        raise TrundleError(f"{path}: is empty; write a header and one line for each sample")
    names = [name.strip() for name in rows[0]]
    if len(set(names)) < len(names):
        raise TrundleError(f"{path}: row 1: a column occurs twice; remove one")
    kept = [k for k, name in enumerate(names) if not name.startswith("note_")]
    lines = [(number, row) for number, row in enumerate(rows[1:], 2) if row]
    found = np.array([_row(path, number, row, names, kept) for number, row in lines])
    return {names[k]: found[:, column] for column, k in enumerate(kept)}


def _row(path: Path, number: int, row: list[str], names: list[str], kept: list[int]) -> list[float]:
    if len(row) != len(names):
        raise TrundleError(f"{path}: row {number}: has {len(row)} cells, the header has {len(names)}")
    return [_number(path, number, names[k], row[k]) for k in kept]


def _number(path: Path, row: int, column: str, text: str) -> float:
    if not text.strip():
        return math.nan
    try:
        return float(text)
    except ValueError as error:
        raise TrundleError(f"{path}: row {row}, column {column}: {text!r} is not a number") from error
