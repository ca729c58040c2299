"""What a path holds - a recording, a diagnosis or a run - and the recording of a diagnosis."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from trundle._native import _pushed
from trundle._optional import require
from trundle.diagnosis import ANSWER_FILE, Diagnosis
from trundle.model import Model
from trundle.recording import Recording, TrundleError
from trundle.report.series import Series
from trundle.viewing.diagnosed import SIDES, Diagnosed, diagnosed_scene
from trundle.viewing.recorded import recorded_scene
from trundle.viewing.scene import Floats, Motion, Scene

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

__all__ = ["load_scene"]

RECORDING_FILE = "recording.toml"
RUN_FILE = "settings.json"
DIAGNOSIS_FORMAT = "trundle-diagnosis/1"


def load_scene(source: Recording | Diagnosis | Path, recording: Recording | Path | None) -> Scene:
    """Return the scene of a source; `recording` is that of a diagnosis.

    Raises
    ------
    TrundleError
        If a path holds none of the three, or the recording of a diagnosis is missing or another one.
    """
    if isinstance(source, Diagnosis):
        if recording is None:
            raise TrundleError("a Diagnosis does not contain its recording: pass `recording`")
        return diagnosed_scene(from_object(source), open_recording(recording))
    if isinstance(source, Path) and (source / ANSWER_FILE).is_file():
        diagnosed = from_folder(source)
        found = find_recording(source, diagnosed.answer["recording"]) if recording is None else recording
        return diagnosed_scene(diagnosed, open_recording(found))
    if recording is not None:
        raise TrundleError(f"{name_of(source)}: is not a diagnosis; only a diagnosis takes --recording")
    if isinstance(source, Path) and (source / RUN_FILE).is_file():
        from trundle.viewing.closed_loop import closed_loop_scene

        return closed_loop_scene(source)
    if isinstance(source, Path):
        check_source(source)
    return recorded_scene(open_recording(source))


def check_source(path: Path) -> None:
    """Refuse a path that holds no recording; the message names what a source holds."""
    if not path.exists():
        raise FileNotFoundError(2, "No such file or directory", str(path))
    if not (path / RECORDING_FILE).is_file():
        raise TrundleError(
            f"{path}: is neither a recording (a folder with {RECORDING_FILE}), a diagnosis ({ANSWER_FILE}) "
            f"nor a run ({RUN_FILE})"
        )


def open_recording(recording: Recording | Path) -> Recording:
    """Return a recording, read from its folder if it is a path."""
    return _pushed(recording)


def name_of(source: Recording | Path) -> str:
    """Return the name of a source for messages."""
    return source.name if isinstance(source, Recording) else str(source)


def find_recording(diagnosis: Path, name: str) -> Path:
    """Return the folder of a recording with this name near a diagnosis or in the current folder."""
    near = diagnosis.resolve().parents
    places = [
        *near[:2],
        *(folder / "recordings" for folder in near[:2]),
        Path.cwd(),
        Path.cwd() / "recordings",
    ]
    for folder in dict.fromkeys(child for place in places for child in folders_in(place)):
        if read_name(folder) == name:
            return folder
    raise TrundleError(
        f"{diagnosis}: its recording {name!r} is not in {', '.join(str(place) for place in near[:2])} or "
        "`recordings` there: pass its folder with --recording"
    )


def folders_in(place: Path) -> Iterator[Path]:
    """Yield the folders of recordings in a folder, in the order of their names."""
    if place.is_dir():
        yield from sorted(file.parent for file in place.glob(f"*/{RECORDING_FILE}"))


def read_name(folder: Path) -> object:
    """Return the name of a recording; None if its description is damaged."""
    try:
        return tomllib.loads((folder / RECORDING_FILE).read_text(encoding="utf-8")).get("name")
    except (ValueError, OSError):
        return None


def from_folder(folder: Path) -> Diagnosed:
    """Return the diagnosis in a folder."""
    file = folder / ANSWER_FILE
    try:
        answer: Mapping[str, Any] = json.loads(file.read_text(encoding="utf-8"))
    except ValueError as error:
        raise TrundleError(f"{file}: is damaged ({error}); repeat the diagnosis") from error
    if answer.get("format") != DIAGNOSIS_FORMAT:
        raise TrundleError(
            f"{file}: `format` = {answer.get('format')!r}; this trundle reads {DIAGNOSIS_FORMAT!r}"
        )
    return Diagnosed(
        answer, Model.read(folder / "model.toml"), read_predictions(folder / "predictions.parquet")
    )


def read_predictions(file: Path) -> dict[str, dict[str, Motion]]:
    """Return the motions in predictions.parquet by episode."""
    table = require("pyarrow.parquet", "rerun", "predictions of a diagnosis").read_table(file)
    columns = {name: table.column(name).to_numpy(zero_copy_only=False) for name in table.column_names}
    names = columns["episode"]
    return {name: episode_motions(columns, names == name) for name in dict.fromkeys(names.tolist())}


def episode_motions(columns: Mapping[str, Any], rows: Any) -> dict[str, Motion]:
    """Return the motions of one episode; a simulation without any pose is omitted."""
    t = np.asarray(columns["t"][rows], dtype=float)
    motions = {}
    for group in ("observed", *SIDES):
        pose = np.column_stack(
            [columns[f"{group}_{axis}"][rows].astype(float) for axis in ("x", "y", "theta")]
        )
        if np.isfinite(pose).any():
            motions[group] = Motion(t, pose)
    return motions


def from_object(diagnosis: Diagnosis) -> Diagnosed:
    """Return a diagnosis in memory, which has simulations and missing wrenches of every episode."""
    poses, residuals = {}, {}
    for episode in Series.parse(diagnosis.series).episodes:
        sides = {"observed": episode.observed, "before": episode.before, "after": episode.after}
        poses[episode.name] = {
            name: Motion(episode.t, pose) for name, pose in sides.items() if pose is not None
        }
        curves: dict[str, tuple[Floats, Floats]] = {}
        if (residual := episode.residual) is not None:
            wrenches = {side: getattr(residual, side) for side in SIDES}
            curves = {side: (residual.t, one) for side, one in wrenches.items() if one is not None}
        residuals[episode.name] = curves
    return Diagnosed(diagnosis.answer, diagnosis.model, poses, residuals)
