"""CSV logs of joints, which become recordings together with an MJCF or URDF model."""

from __future__ import annotations

import os
import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from trundle._native import JointRecording, Recording, TrundleError, read
from trundle.importers.config import typed
from trundle.importers.guess.joints import guess_joint_map, is_driven
from trundle.importers.guess.table import read_table
from trundle.importers.joints.csv_map import JointCsvMap, read_csv
from trundle.importers.joints.documents import add_models
from trundle.importers.joints.joint_map import merge
from trundle.importers.layout import Columns
from trundle.mechanism.source import joint_names

__all__ = [
    "HELD_OUT_SHARE",
    "import_command",
    "is_log",
    "open_joints",
    "open_log",
    "read_log",
    "undriven_warnings",
]

HELD_OUT_SHARE = 0.25
"""Share of a log's duration, or of its episodes, at its end, that is held out."""

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
    if is_log(path):
        if mjcf is None and not has_simulator:
            raise TrundleError(
                f"{path}: is a table without a model; give the MJCF or URDF file with --mjcf FILE (`mjcf`), "
                "your own simulator as `step`, or a folder with recording.toml"
            )
        return read_log(path, mjcf)
    found = read(path)
    return found if isinstance(found, JointRecording) else None


def open_log(
    recording: Recording | JointRecording | PathLike, mjcf: PathLike | None
) -> JointRecording | None:
    """Return the recording of a CSV log, or None for any other recording, which needs no `mjcf`."""
    if isinstance(recording, str | os.PathLike) and is_log(recording):
        return read_log(recording, mjcf)
    if mjcf is not None:
        raise TrundleError(
            "mjcf: applies to CSV logs only; remove it, because a recording names its model in recording.toml"
        )
    return None


def is_log(path: PathLike | None) -> bool:
    """Whether a path is that of a CSV log rather than of a recording."""
    return path is not None and Path(path).suffix.lower() == ".csv"


def read_log(path: PathLike, mjcf: PathLike | None) -> JointRecording:
    """Return a CSV log of joints as a recording whose last quarter is held out.

    `trundle.importers.guess.joints` assigns the columns; the note `columns` of the recording lists them.

    Parameters
    ----------
    path : path
        A file with times, positions, and efforts or targets of joints.
    mjcf : path or None
        The MJCF or URDF file with these joints. Without one, all joints are hinges of a black-box simulator,
        and columns are called as in a recording.

    Raises
    ------
    TrundleError
        If the file cannot be read, a needed column is missing or ambiguous, a cell is not a number, or no
        joint has an effort or a target.
    """
    path = Path(path)
    mechanism: dict[str, Any] = {"types": "hinge"} if mjcf is None else {"model": Path(mjcf).name}
    try:
        guess = guess_joint_map(path, read_table(path), None if mjcf is None else joint_names(mjcf))
        if guess.undriven == guess.settings["joints"]:
            raise TrundleError(_undriven_message(path, guess.undriven, mjcf))
        recording = merge(guess.settings.pop("recording", {}), {"mechanism": mechanism})
        settings = {**guess.settings, "recording": recording}
        imported = read_csv(path, typed(JointCsvMap, settings), lambda _: None)
        if mjcf is not None:
            add_models(imported, Path(mjcf).parent)
    except ValueError as error:
        raise TrundleError(str(error)) from error
    episodes = imported.episodes if len(imported.episodes) > 1 else _split(*imported.episodes.values())
    names = list(episodes)
    last = max(1, round(HELD_OUT_SHARE * len(names)))
    imported.metadata["split"] = {"held_out": names[len(names) - last :]}
    if guess.text:
        imported.metadata["notes"] = {"columns": guess.text}
    return JointRecording(imported.metadata, episodes, imported.files)


def undriven_warnings(recording: JointRecording) -> list[str]:
    """Return a warning about joints of a CSV log that have no effort and no target."""
    columns = [set(episode) for episode in recording.values()]
    undriven = [joint for joint in recording.joints if not any(is_driven(joint, own) for own in columns)]
    if not undriven:
        return []
    first = undriven[0]
    return [
        f"the log has no effort and no target of {', '.join(undriven)}, taken as not driven: "
        f"if {'it has a drive' if len(undriven) == 1 else 'they have drives'}, add columns such as "
        f"effort_{first} or target_{first}"
    ]


def _undriven_message(path: Path, joints: Sequence[str], mjcf: PathLike | None) -> str:
    """Return why a log without any drive is refused, and what to do."""
    first = joints[0]
    return (
        f"{path}: no column is an effort or a target of {', '.join(joints)}, so that nothing tells what "
        f"moves the mechanism; add columns such as effort_{first} or target_{first}. If it moves freely, "
        f"write a recording that states so with `{import_command(path, mjcf)}`, and diagnose its folder"
    )


def import_command(path: PathLike, mjcf: PathLike | None) -> str:
    """Return the command that writes a CSV log as a recording."""
    words = ["trundle", "import", os.fspath(path), "--guess"]
    if mjcf is not None:
        words += ["--set", f"recording.mechanism.model={os.fspath(mjcf)}"]
    return shlex.join([*words, "--out", "DIR"])


def _split(columns: Columns) -> dict[str, Columns]:
    """Return the training and the held-out part of a log."""
    t = columns["t"]
    first = int(np.searchsorted(t, t[0] + (1 - HELD_OUT_SHARE) * (t[-1] - t[0])))
    parts = {"training": slice(0, first), "held_out": slice(first, None)}
    return {name: {key: values[rows] for key, values in columns.items()} for name, rows in parts.items()}
