"""The quantity, axis, unit and body that the name of a column states."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace

from trundle.importers.guess.vocabulary import (
    CLOCK_WORDS,
    GRIPPER_WORDS,
    NEUTRAL_WORDS,
    OBJECT_WORDS,
    QUANTITY_WORDS,
    REASONS,
    TORQUE_OR_TRANSLATION,
    Quantity,
)
from trundle.importers.units import UNITS, unit_in

__all__ = ["DIMENSIONS", "ColumnName", "parse_name"]


DIMENSIONS: dict[Quantity, str] = {
    "position": "length",
    "heading": "angle",
    "quaternion": "ratio",
    "force": "force",
    "torque": "torque",
    "time": "time",
}
"""Dimension of the units of each quantity."""

RATE = re.compile(r"/|\^|(^|_)(m|mm|rad|deg)_s2?$|mps$|rpm$")
TRAILING_UNIT = re.compile(r"[\s_]*[\[({]([^\[\](){}]*)[\])}]\s*$")


@dataclass(frozen=True)
class ColumnName:
    """What the name of a column states.

    Attributes
    ----------
    text : str
        The name in the file.
    quantity : str or None
        None if the name states no quantity of a recording.
    axis : str
        "x", "y", "z" or "w"; empty for a heading or a time, or if the name states none.
    unit : str or None
        As in `trundle.importers.units`; None if the name has none.
    unknown_unit : str or None
        A unit in brackets that is not known, or not one of the quantity.
    body : tuple of str
        The other words in lower case, which name the body or the instrument.
    reason : str
        Why the column is not used; empty if `quantity` is given.
    """

    text: str
    quantity: Quantity | None = None
    axis: str = ""
    unit: str | None = None
    unknown_unit: str | None = None
    body: tuple[str, ...] = ()
    reason: str = ""


def parse_name(text: str, unit_text: str | None = None) -> ColumnName:
    """Parse the name of a column; `unit_text` is its cell in a row of units."""
    rest, stated = text.strip(), unit_text
    bracket = TRAILING_UNIT.search(rest)
    if bracket and not bracket[1].strip().isdigit():
        rest, stated = rest[: bracket.start()], bracket[1]
    if RATE.search(stated or "") or (stated is None and RATE.search(rest.rstrip("/").split("/")[-1])):
        return ColumnName(text, reason="a velocity or an acceleration")
    words = split_words(rest)
    unit = None if stated is None else unit_in(stated.strip())
    if stated is None and len(words) > 1:
        unit, words = strip_unit(rest, words)
    lower = [word.lower() for word in words]
    for word in lower:
        if word in REASONS:
            return ColumnName(text, reason=REASONS[word])
    found = find_quantity(text, lower, unit)
    unknown = stated.strip() if stated and stated.strip("- ") and unit is None else None
    if found.quantity and found.unit and found.unit not in UNITS[DIMENSIONS[found.quantity]]:
        return replace(found, unit=None, unknown_unit=found.unit)
    return replace(found, unknown_unit=None if found.quantity == "quaternion" else unknown)


def split_words(text: str) -> list[str]:
    """Split a name at signs, at capitals and before axes: "objPosX" is obj, Pos, X."""
    found = re.findall(r"[A-Z]{2,}(?=[xyzw]\b)|[A-Z]?[a-z]+|[A-Z]+(?![a-z])|\d+", text.replace("_", " "))
    return [part for word in found for part in split_axis(word)]


def split_axis(word: str) -> list[str]:
    """Split an axis from the end of a known word: "posx" is pos, x, and "fz" is f, z."""
    stem, axis = word[:-1].lower(), word[-1].lower()
    if axis not in "xyzw" or not stem or word.lower() in REASONS:
        return [word]
    if stem in QUANTITY_WORDS or stem in OBJECT_WORDS | GRIPPER_WORDS or stem in ("m", "wrench"):
        return [word[:-1], word[-1]]
    return [word]


def strip_unit(text: str, words: list[str]) -> tuple[str | None, list[str]]:
    """Return the unit at the end of a name, such as "_mm", "_N_m" or "Deg", and the words before it."""
    chunks = re.split(r"[\s_./]+", text)
    if len(chunks) > 2 and unit_in(chunks[-2]) == "N" and chunks[-1] in ("m", "mm", "cm"):
        return unit_in(chunks[-2] + chunks[-1]), words[:-2]
    unit = unit_in(chunks[-1]) if len(chunks) > 1 else None
    if unit is not None:
        return unit, words[: len(words) - len(split_words(chunks[-1]))]
    unit = unit_in(words[-1])
    return (unit, words[:-1]) if unit is not None and len(words[-1]) > 1 else (None, words)


def find_quantity(text: str, words: list[str], unit: str | None) -> ColumnName:
    """Return the quantity, axis and body of the words of a name."""
    axes = [word for word in words if word in tuple("xyzw")]
    others = [word for word in words if word not in axes]
    kinds = {QUANTITY_WORDS[word] for word in others if word in QUANTITY_WORDS}
    body = tuple(word for word in others if word not in QUANTITY_WORDS and word not in NEUTRAL_WORDS)
    if len(axes) > 1:
        return ColumnName(text, reason="the name states several axes")
    if axes:
        return _with_axis(ColumnName(text, axis=axes[0], unit=unit, body=body), others, kinds)
    if "time" in kinds:
        return ColumnName(text, "time", "", unit, None, _clock_of(others))
    for quantity in ("heading", "position", "force"):
        if kinds == {quantity}:
            return ColumnName(text, quantity, "", unit, None, body)
    spelled = unit_in(others[-1]) if others and len(others[-1]) > 1 else None
    if spelled in UNITS["time"] and not kinds:
        return ColumnName(text, "time", "", spelled, None, _clock_of(others[:-1]))
    return ColumnName(text, reason="the name states no quantity of a recording")


def _clock_of(words: list[str]) -> tuple[str, ...]:
    """Return the words that name the instrument of a time column."""
    return tuple(word for word in words if QUANTITY_WORDS.get(word) != "time" and word not in CLOCK_WORDS)


def _with_axis(found: ColumnName, others: list[str], kinds: set[Quantity]) -> ColumnName:
    """Return the quantity of a name with an axis."""
    if "m" in others and not kinds:
        return replace(found, quantity="torque", body=tuple(word for word in found.body if word != "m"))
    if "t" in others and kinds <= {"time"}:
        return replace(found, reason=TORQUE_OR_TRANSLATION)
    if len(kinds) > 1 or "time" in kinds:
        return ColumnName(found.text, reason="the name states several quantities")
    quantity: Quantity = kinds.pop() if kinds else "position"
    if quantity == "heading" or (found.axis == "w" and quantity != "quaternion"):
        return ColumnName(found.text, reason="the name states no quantity of a recording")
    return replace(found, quantity=quantity)
