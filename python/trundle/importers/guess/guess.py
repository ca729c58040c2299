"""Guess of a map of CSV files from the names and values of their columns."""

from __future__ import annotations

from collections.abc import Mapping
from copy import deepcopy
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np

from trundle.importers.csv_dialect import Dialect
from trundle.importers.guess.bodies import Bodies, find_bodies
from trundle.importers.guess.clock import find_clocks, source_name
from trundle.importers.guess.evidence import guess_unit
from trundle.importers.guess.joints import guess_joint_map
from trundle.importers.guess.metadata import missing_metadata, quiet_start
from trundle.importers.guess.names import DIMENSIONS, ColumnName
from trundle.importers.guess.result import Assignment, MapGuess, Question
from trundle.importers.guess.table import Table, read_table
from trundle.importers.tables import DIMENSIONS as COLUMN_DIMENSIONS
from trundle.importers.units import UNITS

__all__ = ["guess_from", "guess_map", "set_key"]


def guess_map(source: Path | str, given: Mapping[str, Any] | None = None) -> MapGuess:
    """Guess a map of CSV files from the names and values of their columns.

    Parameters
    ----------
    source : path
        A CSV file, or a folder whose `*.csv` are episodes with the same columns.
    given : mapping, optional
        Keys of the map that are known, as nested dictionaries: answers to the questions of an earlier guess.
        With a model of joints (`recording.mechanism.model`, an MJCF or URDF file) the map is one of joints.

    Returns
    -------
    MapGuess
        Check `is_complete` and `questions`. Nothing that is ambiguous is assigned: it is a question.

    Raises
    ------
    SourceError
        If the source is not a table of numbers, or its files have different columns.

    Examples
    --------
    >>> guess = trundle.importers.guess_map("log.csv")
    >>> [question.key for question in guess.questions]
    ['recording.object.footprint', 'recording.wrench.frame', 'recording.wrench.sign']
    """
    return guess_from(Path(source), read_table(Path(source)), given or {})


def guess_from(source: Path, table: Table, given: Mapping[str, Any]) -> MapGuess:
    """Guess the map of a source whose table is read."""
    model = given.get("recording", {}).get("mechanism", {}).get("model")
    if model is not None:
        from trundle.mechanism.source import joint_names  # needs trundle[mujoco]

        return guess_joint_map(source, table, joint_names(model)).as_map(source, given)
    known = deepcopy(dict(given))
    faults = {name.text: table.fault(name.text) for name in table.names if name.quantity}
    usable = [name for name in table.names if not faults.get(name.text)]
    given_columns = {
        column: named for column, value in known.get("columns", {}).items() if (named := source_name(value))
    }
    bodies = find_bodies(usable, given_columns)
    assignments, questions = find_clocks(table, usable, known)
    for column, name in bodies.columns.items():
        if column not in given_columns:
            more, asked = _assign(table, bodies, column, name, known.get("columns", {}).get(column, {}))
            assignments, questions = [*assignments, more], questions + asked
    questions += [q for q in bodies.questions if q.key.removeprefix("columns.") not in given_columns]
    settings = _settings(table, assignments, bodies, known)
    if bodies.on_rail:
        assignments += _rail_keys(settings)
    quiet = _quiet_text(table, settings, questions)
    questions += missing_metadata(settings["recording"], settings["columns"], quiet, ask_raw=True)
    unused = _unused(table, settings, {**bodies.others, **faults})
    return MapGuess(source, settings, assignments, questions, unused)


def _assign(
    table: Table, bodies: Bodies, column: str, name: ColumnName, given: object
) -> tuple[Assignment, list[Question]]:
    """Return the key of one column of the recording, with its unit."""
    key, dimension = f"columns.{column}", COLUMN_DIMENSIONS[column]
    role = column.split("_")[0] if column.startswith(("object", "gripper")) else "wrench"
    confidence, basis = bodies.bases[role]
    extra: dict[str, Any] = dict(given) if isinstance(given, Mapping) else {}
    value: dict[str, Any] = {"name": name.text, **extra}
    questions = []
    if "unit" in extra:
        basis = f"{basis}; {extra['unit']} (given)"
    elif name.unit is not None or dimension == "ratio":
        value |= {} if dimension == "ratio" else {"unit": name.unit}
        basis = basis if dimension == "ratio" else f"{basis}; {name.unit}"
    elif name.unknown_unit is not None:
        text = f"{name.text}: unit {name.unknown_unit!r} is not one of a {dimension}"
        questions.append(Question(f"{key}.unit", f"{text}; give a known one", tuple(UNITS[dimension])))
    else:
        found = guess_unit(dimension, table.values(name.text), _lever(table, bodies, column))
        siblings = [other for other in table.names if other.unit and other.quantity == name.quantity]
        if found.unit is None:
            questions.append(Question(f"{key}.unit", f"{name.text}: {found.basis}", found.choices))
        elif siblings and any(other.unit != found.unit for other in siblings):
            text = f"{name.text}: no unit in the name, but {siblings[0].text} has {siblings[0].unit}"
            questions.append(Question(f"{key}.unit", text, tuple(UNITS[dimension])))
        else:
            value["unit"] = found.unit
            confidence, basis = "medium", f"{basis}; {found.basis}"
    return Assignment(key, value, confidence, basis), questions


def _lever(table: Table, bodies: Bodies, column: str) -> float:
    """Return the ratio of the largest torque to the largest force, m if both are in SI units."""
    if not column.startswith("torque"):
        return 0.0
    force = max(
        (_largest(table, name) for part, name in bodies.columns.items() if part.startswith("force")),
        default=0.0,
    )
    return _largest(table, bodies.columns[column]) / force if force > 0.0 else 0.0


def _largest(table: Table, name: ColumnName) -> float:
    scale = UNITS[DIMENSIONS[name.quantity]].get(name.unit or "", 1.0) if name.quantity else 1.0
    return scale * float(np.max(np.abs(table.values(name.text)), initial=0.0))


def _settings(
    table: Table, assignments: list[Assignment], bodies: Bodies, given: dict[str, Any]
) -> dict[str, Any]:
    """Return the map: layout of the files, guessed keys, given keys."""
    settings: dict[str, Any] = {
        field.name: getattr(table.dialect, field.name)
        for field in fields(Dialect)
        if getattr(table.dialect, field.name) != field.default
    }
    settings |= {"columns": {}, "recording": {}}
    for one in assignments:
        set_key(settings, one.key, one.value)
    if bodies.on_rail:
        settings["recording"] = {"object": {"dof": ["x"]}, "wrench": {"frame": "object"}}
    _merge(settings, given)
    return settings


def set_key(settings: dict[str, Any], key: str, value: object) -> None:
    """Set a key such as "columns.object_x.unit"; a string in between becomes a table with that name."""
    *path, last = key.split(".")
    for part in path:
        inner = settings.get(part)
        settings[part] = inner if isinstance(inner, dict) else {} if inner is None else {"name": inner}
        settings = settings[part]
    settings[last] = value


def _merge(settings: dict[str, Any], given: Mapping[str, Any]) -> None:
    for key, value in given.items():
        if isinstance(value, Mapping) and isinstance(settings.get(key), dict):
            _merge(settings[key], value)
        elif isinstance(value, str) and isinstance(settings.get(key), dict) and "name" in settings[key]:
            settings[key] = value if settings[key]["name"] != value else settings[key]
        else:
            settings[key] = value


def _rail_keys(settings: Mapping[str, Any]) -> list[Assignment]:
    recording = settings["recording"]
    return [
        Assignment(
            "recording.object.dof", recording["object"]["dof"], "medium", "one position and one force"
        ),
        Assignment(
            "recording.wrench.frame", recording["wrench"]["frame"], "high", "on a rail all frames agree"
        ),
    ]


def _quiet_text(table: Table, settings: Mapping[str, Any], questions: list[Question]) -> str:
    """Return the evidence about the beginning of contact in the first file."""
    time, columns = settings.get("time"), settings["columns"]
    wrench = [source_name(value) for key, value in columns.items() if key.startswith(("force_", "torque_"))]
    name = source_name(time)
    if (
        not isinstance(time, Mapping)
        or name is None
        or not wrench
        or any(q.key.startswith("time") for q in questions)
    ):
        return ""
    t = table.file.vector(name) * UNITS["time"][time.get("unit", "s")]
    readings = np.column_stack([table.file.vector(column) for column in wrench if column])
    there = np.isfinite(readings).all(axis=1) & np.isfinite(t)
    if not there.any():
        return ""
    end = quiet_start(t[there] - np.nanmin(t), readings[there])
    return (
        ""
        if end is None
        else f"; in {table.file.path.name} the reading keeps its initial level until {end:.2f} s"
    )


def _unused(table: Table, settings: Mapping[str, Any], remarks: Mapping[str, str]) -> dict[str, str]:
    """Return the columns that the map does not use, with reasons."""
    used = _names_in([settings.get("time"), settings.get("times", {}), settings["columns"]])
    reasons = {name.text: remarks.get(name.text) or name.reason for name in table.names}
    return {
        name: reason or "not needed, or not assigned (see the missing keys)"
        for name, reason in reasons.items()
        if name not in used
    }


def _names_in(value: object) -> set[str]:
    """Return the columns of the file that a part of a map names."""
    if isinstance(value, str):
        return {value}
    if isinstance(value, Mapping):
        return set().union(*(_names_in(each) for key, each in value.items() if key not in ("unit", "scale")))
    if isinstance(value, list):
        return set().union(*map(_names_in, value))
    return set()
