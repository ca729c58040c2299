"""The time columns: one for all streams, or one for each stream."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from trundle.importers.guess.evidence import guess_time_unit
from trundle.importers.guess.names import ColumnName
from trundle.importers.guess.result import Assignment, Question
from trundle.importers.guess.table import Table
from trundle.importers.guess.vocabulary import GRIPPER_WORDS, OBJECT_WORDS, WRENCH_WORDS
from trundle.importers.units import UNITS

__all__ = ["find_clocks"]

HEADER_WORDS = ("stamp", "header")
"""Words of a time of measurement, in contrast to the time at which a logger wrote the row."""

Found = tuple[list[Assignment], list[Question]]


def find_clocks(table: Table, names: list[ColumnName], given: Mapping[str, Any]) -> Found:
    """Return the keys `time` and `times`, and the questions about them.

    Parameters
    ----------
    table : Table
    names : list of ColumnName
        Columns with usable values.
    given : mapping
        Keys of the map that the caller has given.
    """
    clocks = [name for name in names if name.quantity == "time"]
    chosen = source_name(given.get("time"))
    if chosen is not None:
        found = [name for name in table.names if name.text == chosen] or [ColumnName(chosen)]
        return _clock(table, "time", found[0], given.get("time"), "given")
    by_role = {
        role: [name for name in clocks if role_of(name) == role] for role in ("object", "gripper", "wrench")
    }
    shared = [name for name in clocks if role_of(name) is None]
    pair = _seconds_and_nanoseconds(shared)
    if pair:
        value = {"sum": [{"name": pair[0].text}, {"name": pair[1].text, "unit": "ns"}]}
        basis = "seconds and nanoseconds of one time stamp"
        return [Assignment("time", value, "high", basis)], []
    assignments, questions = _shared_clock(table, shared, given)
    for role, own in by_role.items():
        if len(own) == 1 and source_name(given.get("times", {}).get(role)) is None:
            more, asked = _clock(
                table, f"times.{role}", own[0], given.get("times", {}).get(role), "its own clock"
            )
            assignments, questions = assignments + more, questions + asked
    if not assignments and not questions:
        candidates = tuple(name.text for name in table.names if name.quantity == "time")
        fault = f" ({candidates[0]} {table.fault(candidates[0])})" if candidates else ""
        questions.append(Question("time", f"no column of times{fault}", (), "NAME"))
    return assignments, questions


def source_name(value: object) -> str | None:
    """Return the column of the file that a given value of the map names."""
    name = value.get("name") if isinstance(value, Mapping) else value
    return name if isinstance(name, str) else None


def role_of(name: ColumnName) -> str | None:
    """Return the stream whose clock a time column is; None for all streams."""
    words = set(name.body)
    if words & WRENCH_WORDS:
        return "wrench"
    return "object" if words & OBJECT_WORDS else "gripper" if words & GRIPPER_WORDS else None


def _seconds_and_nanoseconds(clocks: list[ColumnName]) -> tuple[ColumnName, ColumnName] | None:
    by_unit = {name.unit: name for name in clocks}
    return (
        (by_unit["s"], by_unit["ns"])
        if len(clocks) == 2
        and by_unit.keys() == {"s", "ns"}
        and _split(by_unit["s"].text, by_unit["ns"].text)
        else None
    )


def _split(seconds: str, nanoseconds: str) -> bool:
    """Return whether two names are the parts of one time stamp, such as stamp.secs and stamp.nsecs."""
    stems = [name.rstrip("]").lower().rpartition("sec")[0] for name in (seconds, nanoseconds)]
    return all("sec" in name.lower() for name in (seconds, nanoseconds)) and (
        stems[1].removesuffix("nano").removesuffix("n") == stems[0]
    )


def _shared_clock(table: Table, shared: list[ColumnName], given: Mapping[str, Any]) -> Found:
    measured = [name for name in shared if any(word in name.text.lower() for word in HEADER_WORDS)]
    logged = [name for name in shared if name.text.startswith(("%", "__"))]
    basis = "the name"
    if len(shared) > 1 and len(measured) == 1 and len(measured) + len(logged) == len(shared):
        shared, basis = measured, "the time of measurement, not that of the logger"
    if len(shared) > 1 and all(_same_increments(table, shared[0], other) for other in shared[1:]):
        basis = f"the same increments as {', '.join(name.text for name in shared[1:])}"
        shared = shared[:1]
    if len(shared) > 1:
        names = tuple(name.text for name in shared)
        return [], [Question("time", f"several columns may be the time: {', '.join(names)}", names)]
    return _clock(table, "time", shared[0], given.get("time"), basis) if shared else ([], [])


def _same_increments(table: Table, one: ColumnName, other: ColumnName) -> bool:
    """Return whether two columns are one clock in two units."""
    if one.unit is None or other.unit is None:
        return False
    first, second = (np.diff(table.values(c.text)) * UNITS["time"][str(c.unit)] for c in (one, other))
    return len(first) == len(second) and bool(np.allclose(first, second, rtol=1e-3, atol=1e-6))


def _clock(table: Table, key: str, name: ColumnName, given: object, basis: str) -> Found:
    """Return a time column with its unit."""
    given_unit = given.get("unit") if isinstance(given, Mapping) else None
    value: dict[str, Any] = {"name": name.text}
    if given_unit is not None or name.unit is not None:
        value["unit"] = given_unit or name.unit
        return [Assignment(key, value, "given" if given_unit else "high", f"{basis}; {value['unit']}")], []
    if name.unknown_unit is not None:
        text = f"unknown unit {name.unknown_unit!r} of {name.text}"
        return [Assignment(key, value, "medium", basis)], [
            Question(f"{key}.unit", text, tuple(UNITS["time"]))
        ]
    found = guess_time_unit(table.values(name.text))
    if found.unit is None:
        asked = Question(f"{key}.unit", f"{name.text}: {found.basis}", found.choices)
        return [Assignment(key, value, "medium", basis)], [asked]
    return [Assignment(key, {**value, "unit": found.unit}, "medium", f"{basis}; {found.basis}")], []
