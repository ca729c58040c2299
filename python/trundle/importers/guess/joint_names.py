"""The joint and the stream that the name of a column of a joint log states."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from trundle.importers.guess.names import TRAILING_UNIT, split_words
from trundle.importers.guess.vocabulary import words
from trundle.importers.joints.columns import UNITS_OF, Kind
from trundle.importers.units import unit_in

__all__ = ["JointColumn", "parse_joint_name", "words_of"]


STREAM_WORDS: dict[Kind, frozenset[str]] = {
    "q": words("q qpos pos position positions angle angles theta enc encoder"),
    "v": words("v qd dq qvel vel velocity velocities speed speeds omega qdot"),
    "effort": words(
        "effort efforts torque torques tau trq moment moments force forces current currents qfrc"
    ),
    "known": words("known"),
    "on": words("on enabled"),
    "load": words("load"),
}
CURRENT_WORDS = words("current currents")
CURRENT_UNITS = ("A", "mA")
"""Efforts in units that need a gain."""
COMMAND_WORDS = words(
    "target targets cmd command commands commanded des desired ref reference setpoint goal action"
)
NEUTRAL_WORDS = words("actual act measured meas state states observation joint joints motor axis data msg")
"""Words that distinguish no streams."""
OTHER_WORDS = words(
    "acc accel acceleration qdd ddq qddot qacc err error std sigma var "
    "temp temperature voltage status mode id"
)
"""Words of quantities that are not streams of a recording."""
KNOWN_WORDS = COMMAND_WORDS | NEUTRAL_WORDS | OTHER_WORDS | frozenset().union(*STREAM_WORDS.values())
SPEED_UNITS = {unit: unit for unit in UNITS_OF["v"]}


@dataclass(frozen=True)
class JointColumn:
    """What the name of a column states.

    Attributes
    ----------
    text : str
        The name in the file.
    kind : str or None
        Stream of a recording; None if the name states none.
    joint : str or None
        A known joint that the name contains.
    index : int or None
        A number at the end of a name without a joint.
    commanded : bool
        Whether an effort is commanded, not measured.
    is_current : bool
        Whether an effort is a current.
    unit : str or None
    unknown : tuple of str
        Words that state nothing known.
    is_other : bool
        Whether the name states a quantity that is not a stream of a recording.
    """

    text: str
    kind: Kind | None = None
    joint: str | None = None
    index: int | None = None
    commanded: bool = False
    is_current: bool = False
    unit: str | None = None
    unknown: tuple[str, ...] = ()
    is_other: bool = False


def words_of(text: str) -> list[str]:
    """Return the words of a name in lower case; numbers are words."""
    return [word.lower() for word in split_words(text)]


def parse_joint_name(text: str, joints: Sequence[str], unit_text: str | None = None) -> JointColumn:
    """Parse the name of a column of a log of joints; `unit_text` is its cell in a row of units.

    Names as in a recording, such as "q_elbow", are exact, whatever words and letters the joint's name has.
    """
    kind, _, exact = text.strip().partition("_")
    if unit_text is None and kind in UNITS_OF and exact in joints:
        return JointColumn(text, kind, exact)
    rest, stated = text.strip(), unit_text
    bracket = TRAILING_UNIT.search(rest)
    if bracket and not bracket[1].strip().isdigit():
        rest, stated = rest[: bracket.start()], bracket[1]
    found = words_of(rest)
    joint = _joint_in(found, joints)
    if joint is not None:
        found = _without(found, words_of(joint))
    stated = (stated or "").strip("- ")
    unit = _unit(stated)
    if not stated:
        unit, found = _strip_unit(found, is_alone=joint is not None)
    index, numbers = None, [word for word in found if word.isdigit()]
    if joint is None and len(numbers) == 1:
        index, found = int(numbers[0]), [word for word in found if not word.isdigit()]
    column = _stream(JointColumn(text, joint=joint, index=index, unit=unit), found)
    if column.kind == "effort" and stated in CURRENT_UNITS:
        return replace(column, is_current=True)
    if stated and unit is None and not column.is_current:
        return replace(column, kind=None, unknown=(*column.unknown, stated))
    return column


def _unit(text: str) -> str | None:
    return SPEED_UNITS.get(text.strip().lower()) or unit_in(text.strip())


def _strip_unit(found: list[str], *, is_alone: bool) -> tuple[str | None, list[str]]:
    """Return the unit at the end of a name, such as "_deg" or "_rad_s", and the words before it."""
    for length in (2, 1):
        unit = _unit("/".join(found[-length:]))
        if len(found) >= length + (not is_alone) and len(found[-length]) > 1 and unit is not None:
            return unit, found[:-length]
    return None, found


def _joint_in(found: Sequence[str], joints: Sequence[str]) -> str | None:
    """Return the joint with the longest name whose words the name of a column contains in order."""
    named = [joint for joint in joints if words_of(joint)]  # others have no letters that are recognised
    inside = [joint for joint in named if _place(found, words_of(joint)) is not None]
    return max(inside, key=lambda joint: len(words_of(joint)), default=None)


def _place(found: Sequence[str], part: Sequence[str]) -> int | None:
    starts = range(len(found) - len(part) + 1)
    # The last one: in "q_q" the first word is the stream.
    return next((k for k in reversed(starts) if list(found[k : k + len(part)]) == list(part)), None)


def _without(found: list[str], part: Sequence[str]) -> list[str]:
    start = _place(found, part)
    assert start is not None
    return found[:start] + found[start + len(part) :]


def _stream(column: JointColumn, found: Sequence[str]) -> JointColumn:
    """Return the column with the stream that the words besides the joint state."""
    there = set(found)
    unknown = tuple(word for word in found if word not in KNOWN_WORDS)
    kinds = [kind for kind, named in STREAM_WORDS.items() if named & there]
    kind: Kind | None = kinds[0] if len(kinds) == 1 else None
    if (not kinds and not unknown and found != []) or (column.joint and found == []):
        kind = "q"
    commanded = bool(COMMAND_WORDS & there)
    if commanded and kind == "q":
        kind = "target"
    is_other = bool(OTHER_WORDS & there) or (commanded and kind in ("v", "known", "on", "load"))
    if is_other or (kind and column.unit and column.unit not in UNITS_OF[kind]):
        return replace(column, unknown=unknown, is_other=is_other)
    is_effort = kind == "effort"
    is_current = is_effort and bool(CURRENT_WORDS & there)
    return replace(
        column, kind=kind, commanded=commanded and is_effort, is_current=is_current, unknown=unknown
    )
