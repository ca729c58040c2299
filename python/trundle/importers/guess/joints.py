"""Guess of a map of a CSV log of joints from the names of its columns."""

from __future__ import annotations

import shlex
from collections.abc import Container, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

from trundle.importers.csv_dialect import Dialect
from trundle.importers.guess.clock import find_clocks
from trundle.importers.guess.joint_names import JointColumn, parse_joint_name, words_of
from trundle.importers.guess.result import Assignment, MapGuess
from trundle.importers.guess.table import Table
from trundle.importers.guess.vocabulary import words
from trundle.importers.joints.joint_map import merge
from trundle.importers.layout import SourceError

__all__ = ["JointGuess", "guess_joint_map", "is_driven"]

EPISODE_WORDS = words("episode run trial take trajectory traj demo rollout")
COUNTER_WORDS = words("index idx id number no")
REMEDY = (
    "rename the columns to t, q_JOINT, and effort_JOINT or target_JOINT, or convert the file with "
    "`trundle import` and a map (docs/import.md)"
)


@dataclass(frozen=True)
class JointGuess:
    """A guessed map of a CSV log of joints.

    Attributes
    ----------
    settings : dict
        The map, as `trundle.importers.read` accepts it, without a model.
    unused : list of str
        Columns of the file that the map does not use.
    """

    settings: dict[str, Any]
    unused: list[str]

    def as_map(self, source: Path, given: Mapping[str, Any]) -> MapGuess:
        """Return the guess with keys that the caller has given, such as the model, for a map file."""
        found = {"time": self.settings["time"]}
        found |= {f"columns.{name}": value for name, value in self.settings["columns"].items()}
        assignments = [Assignment(key, value, "high", "the name") for key, value in found.items()]
        unused = dict.fromkeys(self.unused, "no stream of a joint")
        return MapGuess(source, merge(self.settings, given), assignments, [], unused)

    @property
    def undriven(self) -> list[str]:
        """The joints without an effort or a target."""
        return [joint for joint in self.settings["joints"] if not is_driven(joint, self.settings["columns"])]

    @property
    def text(self) -> str:
        """What a reader of the columns' names may not expect, as one line; empty if there is nothing.

        Columns whose names are not those of a recording, unused columns, and joints without a drive.
        """
        columns = {"t": self.settings["time"], **self.settings["columns"]}
        named = {column: _text(source) for column, source in columns.items()}
        pairs = [f"{column} = {text}" for column, text in named.items() if text != column]
        if (episode := self.settings.get("episode_column")) is not None:
            pairs.append(f"episodes by {episode}")
        unused = f"not used: {', '.join(self.unused)}" if self.unused else ""
        undriven = f"taken as not driven: {', '.join(self.undriven)}" if self.undriven else ""
        return "; ".join(filter(None, [", ".join(pairs), unused, undriven]))


def is_driven(joint: str, columns: Container[str]) -> bool:
    """Whether a joint has an effort or a target among columns of a recording."""
    return f"effort_{joint}" in columns or f"target_{joint}" in columns


def guess_joint_map(source: Path, table: Table, joints: Sequence[str] | None) -> JointGuess:
    """Guess a map of a CSV log of joints, or of a folder of such files, from the names of its columns.

    A column belongs to the joint whose name it contains. Without any such column, numbered columns belong to
    the joints of the model in its order, if there are as many positions as joints.

    Parameters
    ----------
    source : Path
        For messages.
    table : Table
        Its first file.
    joints : sequence of str or None
        The joints of the model. None: joints are what columns ``q_JOINT`` name.

    Raises
    ------
    SourceError
        If the source is no table of numbers, has no time or no position of a joint, several columns may be
        one stream, or the stream of a joint's column is not known.
    """
    names = [name for name in table.file.names if not name.startswith("note_")]
    if joints is None:
        joints = [name.removeprefix("q_") for name in names if name.startswith("q_")]
    units: list[str] | list[None] = table.file.units or [None] * len(table.file.names)
    unit_of = dict(zip(table.file.names, units, strict=True))
    parsed = [parse_joint_name(name, joints, unit_of[name]) for name in names]
    clock = _clock(source, table)
    episode = next((name for name in names if _is_episode(name)), None)
    times = [part["name"] for part in clock.get("sum", [clock])]
    left = [column for column in parsed if column.text not in (*times, episode)]
    columns = _streams(source, left, joints)
    used = {column.text for column in columns.values()}
    unused = [column for column in left if column.text not in used]
    _refuse_doubtful(source, unused, columns, joints)
    settings: dict[str, Any] = {
        **_layout(table.dialect),
        "joints": [joint for joint in joints if f"q_{joint}" in columns],
        "time": clock,
        "columns": {name: _source(column) for name, column in columns.items()},
    }
    if episode is not None:
        settings["episode_column"] = episode
    commanded = [name.removeprefix("effort_") for name, column in columns.items() if column.commanded]
    if commanded:
        efforts = [name.removeprefix("effort_") for name in columns if name.startswith("effort_")]
        sources = {joint: "commanded" if joint in commanded else "measured" for joint in efforts}
        settings["recording"] = {"effort": {"source": sources}}
    return JointGuess(settings, [column.text for column in unused])


def _layout(dialect: Dialect) -> dict[str, Any]:
    """Return the keys of the layout that differ from their defaults."""
    return {
        each.name: getattr(dialect, each.name)
        for each in fields(Dialect)
        if getattr(dialect, each.name) != each.default
    }


def _clock(source: Path, table: Table) -> dict[str, Any]:
    """Return the time column with its unit."""
    times = [name for name in table.names if name.quantity == "time" and not table.fault(name.text)]
    exact = [name for name in times if name.text == "t"]
    assignments, questions = find_clocks(table, exact or times, {})
    if questions or not assignments:
        found = questions[0].text if questions else "no column of times"
        raise SourceError(source, f"{found}; the columns are {', '.join(table.file.names)}; {REMEDY}")
    clock = dict(assignments[0].value)
    return {"name": clock["name"]} if clock.get("unit") == "s" else clock


def _text(source: Mapping[str, Any]) -> str:
    """Return a source of a map in words."""
    return " + ".join(" in ".join(part.values()) for part in source.get("sum", [source]))


def _is_episode(name: str) -> bool:
    found = set(words_of(name))
    return bool(found & EPISODE_WORDS) and found <= EPISODE_WORDS | COUNTER_WORDS


def _source(column: JointColumn) -> dict[str, Any]:
    return {"name": column.text} | ({} if column.unit is None else {"unit": column.unit})


def _streams(source: Path, columns: Sequence[JointColumn], joints: Sequence[str]) -> dict[str, JointColumn]:
    """Return the column of each stream, by its name in a recording."""
    by_joint = [column for column in columns if column.joint is not None]
    if not any(column.kind == "q" for column in by_joint):
        by_joint = _numbered(source, columns, joints)
    found: dict[str, list[JointColumn]] = {}
    for column in by_joint:
        if column.kind is not None:
            found.setdefault(f"{column.kind}_{column.joint}", []).append(column)
    recorded = {column.joint for column in by_joint if column.kind == "q"}
    chosen = {name: _chosen(source, name, each) for name, each in found.items()}
    return {name: column for name, column in chosen.items() if column.joint in recorded}


def _numbered(source: Path, columns: Sequence[JointColumn], joints: Sequence[str]) -> list[JointColumn]:
    """Return numbered columns with the joints of the model in its order, counted for each stream."""
    found: list[JointColumn] = []
    for kind in dict.fromkeys(column.kind for column in columns if column.index is not None):
        own = [column for column in columns if column.kind == kind and column.index is not None]
        numbers = sorted({column.index for column in own if column.index is not None})
        if kind is None:
            continue
        if len(numbers) != len(joints) or numbers[-1] - numbers[0] + 1 != len(joints):
            raise SourceError(
                source,
                f"{', '.join(column.text for column in own)}: {len(numbers)} numbers, but the model has "
                f"the joints {', '.join(joints)}; {REMEDY}",
            )
        named = dict(zip(numbers, joints, strict=True))
        found += [replace(column, joint=named[column.index]) for column in own if column.index is not None]
    if not any(column.kind == "q" for column in found):
        listed = ", ".join(column.text for column in columns)
        if not joints:
            raise SourceError(
                source,
                f"no column with a joint's position among {listed}; {REMEDY}; a log of a pushed object: "
                f"`trundle import {shlex.quote(str(source))} --guess --out DIR`",
            )
        known = f"the joints of the model are {', '.join(joints)}"
        raise SourceError(source, f"no column with a joint's position among {listed}; {known}; {REMEDY}")
    return found


def _chosen(source: Path, name: str, columns: Sequence[JointColumn]) -> JointColumn:
    """Return the column of a stream: measured rather than commanded, with the fewest unknown words."""

    def rank(column: JointColumn) -> tuple[bool, bool, int]:
        return (column.is_current, column.commanded, len(column.unknown))

    best = min(columns, key=rank)
    equal = [column.text for column in columns if rank(column) == rank(best)]
    if len(equal) > 1:
        raise SourceError(source, f"{name} may be {' or '.join(equal)}; begin the others with note_")
    if best.is_current:
        raise SourceError(
            source,
            f"column {best.text}: a current needs a gain in N·m (or N) per unit; multiply it and name the "
            f'column {name}, or import the file with a map with [recording.effort] source = "current", '
            "gain = …",
        )
    return best


def _refuse_doubtful(
    source: Path, unused: Sequence[JointColumn], columns: Mapping[str, JointColumn], joints: Sequence[str]
) -> None:
    """Refuse columns that are not used, but may be needed."""
    unrecorded = [joint for joint in joints if f"q_{joint}" not in columns]
    driven = {name.split("_", 1)[1] for name in columns if name.startswith(("effort_", "target_"))}
    passive = [joint for joint in joints if joint not in unrecorded and joint not in driven]
    for column in unused:
        joint = column.joint
        lacking = {"q": unrecorded, "effort": passive, "target": passive}.get(column.kind or "", [])
        if joint is None and lacking:
            what = {"q": "a position", "effort": "an effort"}.get(column.kind or "", "a target")
            raise SourceError(
                source,
                f"column {column.text}: {what} of no joint of the model; joints without one are "
                f"{', '.join(lacking)}; rename it, or begin it with note_",
            )
        if joint in unrecorded and column.kind is not None:
            raise SourceError(
                source,
                f"column {column.text}: there is no position of joint {joint}; name its column q_{joint}, or "
                "begin the others of the joint with note_",
            )
        if joint is not None and joint not in driven and column.kind is None and not column.is_other:
            raise SourceError(
                source,
                f"column {column.text}: not known which quantity of joint {joint} it is; name it q_{joint}, "
                f"v_{joint}, effort_{joint} or target_{joint}, or begin it with note_",
            )
