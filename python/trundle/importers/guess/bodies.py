"""Which group of columns is the object, which the gripper, and which the wrench."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from trundle.importers.guess.groups import Group, group_columns
from trundle.importers.guess.names import ColumnName
from trundle.importers.guess.result import Confidence, Question

__all__ = ["Bodies", "find_bodies"]


@dataclass
class Bodies:
    """Groups by their role in the recording.

    Attributes
    ----------
    columns : dict of str to ColumnName
        Column of the file by column of the recording.
    bases : dict of str to (confidence, basis)
        What the choice of a body rests on, by role: "object", "gripper", "wrench".
    questions : list of Question
        Roles that several groups may have, and missing columns.
    on_rail : bool
        Whether there is one position and one force only.
    others : dict of str to str
        Columns of other poses and wrenches, with a remark.
    """

    columns: dict[str, ColumnName] = field(default_factory=dict)
    bases: dict[str, tuple[Confidence, str]] = field(default_factory=dict)
    questions: list[Question] = field(default_factory=list)
    on_rail: bool = False
    others: dict[str, str] = field(default_factory=dict)

    def take(self, role: str, group: Group, basis: tuple[Confidence, str]) -> None:
        """Use a group for a role, and ask about parts that several columns claim."""
        self.bases[role] = basis
        for part, column in selected_parts(group).items():
            self.columns[column_of(role, part)] = column
        for part, doubles in group.doubles.items():
            names = tuple(column.text for column in doubles)
            key = f"columns.{column_of(role, part)}"
            self.questions.append(Question(key, f"{' and '.join(names)} may both be this", names))


def column_of(role: str, part: str) -> str:
    """Return the column of a recording for a part of a role."""
    return part if role == "wrench" else f"{role}_{part}"


def find_bodies(names: list[ColumnName], given: Mapping[str, Any]) -> Bodies:
    """Assign the groups of columns to roles.

    Parameters
    ----------
    names : list of ColumnName
        Columns of the file with usable values.
    given : mapping
        Column of the file by column of the recording, as far as the caller has given them. One column
        decides the role of its whole group.
    """
    poses, wrenches = group_columns(names)
    found = Bodies()
    forced = {
        role: _forced_group(groups, role, given) for role, groups in (("object", poses), ("gripper", poses))
    }
    whole = [group for group in poses if group.is_pose]
    _find_rail(found, names, whole, wrenches)
    if found.on_rail:
        return found
    _choose_object(found, whole, forced["object"], forced["gripper"])
    _choose_gripper(found, whole, forced["gripper"])
    _choose_wrench(found, wrenches, _forced_group(wrenches, "wrench", given))
    _ask_missing(found, poses, given)
    for group in whole:
        text = f"a pose of {group.label}; map columns.gripper_x to use it as that of the sensor"
        found.others |= {column.text: text for column in group.parts.values()}
    return found


def selected_parts(group: Group) -> dict[str, ColumnName]:
    """Return the parts to import: a quaternion rather than a heading; the height only with a quaternion."""
    parts = dict(group.parts)
    if all(f"q{axis}" in parts for axis in "wxyz"):
        parts.pop("theta", None)
    elif "theta" in parts:
        parts = {part: column for part, column in parts.items() if part in ("x", "y", "theta")}
    return parts


def _forced_group(groups: list[Group], role: str, given: Mapping[str, Any]) -> Group | None:
    prefixes = ("force_", "torque_") if role == "wrench" else (f"{role}_",)
    named = [name for column, name in given.items() if column.startswith(prefixes)]
    return next((group for group in groups if any(group.holds(name) for name in named)), None)


def _find_rail(found: Bodies, names: list[ColumnName], poses: list[Group], wrenches: list[Group]) -> None:
    """Recognise an object on a rail: one position and one force, of x or without an axis."""
    positions = [name for name in names if name.quantity == "position"]
    forces = [name for name in names if name.quantity in ("force", "torque")]
    if len(positions) == len(forces) == 1 and not poses:
        position, force = positions[0], forces[0]
        if position.axis in ("", "x") and force.axis in ("", "x") and force.quantity == "force":
            found.on_rail = True
            found.columns |= {"object_x": position, "force_x": force}
            basis = "the only position and the only force: an object on a rail"
            found.bases |= {"object": ("medium", basis), "wrench": ("medium", basis)}


def _choose_object(found: Bodies, poses: list[Group], forced: Group | None, gripper: Group | None) -> None:
    named = [group for group in poses if group.is_object and group is not gripper]
    others = [group for group in poses if not group.is_gripper and group is not gripper]
    if forced is not None:
        found.take("object", forced, ("given", "given"))
    elif len(named) == 1:
        found.take("object", named[0], ("high", f"the name says {named[0].label}"))
    elif len(others) == 1:
        group = others[0]
        known = "the only pose" if len(poses) == 1 else "the only pose that is not the gripper's"
        found.take("object", group, ("medium", f"{known}: {group.label}"))
    elif len(named or others) > 1:
        found.questions.append(_which("object", named or others))
    else:
        found.questions.append(
            Question(
                "columns.object_x",
                "no pose of the object (x, y and a heading); for a log of joints give their model with "
                "--set recording.mechanism.model=FILE",
                (),
                "NAME",
            )
        )


def _choose_gripper(found: Bodies, poses: list[Group], forced: Group | None) -> None:
    used = [column.text for column in found.columns.values()]
    named = [group for group in poses if group.is_gripper and not any(map(group.holds, used))]
    if forced is not None:
        found.take("gripper", forced, ("given", "given"))
    elif len(named) == 1:
        found.take("gripper", named[0], ("high", f"the name says {named[0].label}"))
    elif len(named) > 1:
        found.questions.append(_which("gripper", named))


def _choose_wrench(found: Bodies, wrenches: list[Group], forced: Group | None) -> None:
    candidates = [
        group for group in wrenches if {"force_x", "force_y"} & (group.parts.keys() | group.doubles.keys())
    ]
    if forced is not None:
        found.take("wrench", forced, ("given", "given"))
    elif len(candidates) == 1:
        found.take("wrench", candidates[0], ("high", "the only force"))
    elif candidates:
        found.questions.append(_which("wrench", candidates, "force_x"))
    else:
        found.questions.append(Question("columns.force_x", "no force (x and y)", (), "NAME"))


def _which(role: str, groups: list[Group], part: str = "x") -> Question:
    columns = tuple(group.parts.get(part, group.columns[-1]).text for group in groups)
    labels = ", ".join(group.label for group in groups)
    return Question(
        f"columns.{column_of(role, part)}", f"several columns may be the {role}: {labels}", columns
    )


def _ask_missing(found: Bodies, poses: list[Group], given: Mapping[str, Any]) -> None:
    """Ask for columns that complete a pose or a wrench."""
    asked = {question.key for question in found.questions}
    if "columns.object_x" in asked and not any(group.is_pose for group in poses) and poses:
        lacking = ", ".join(f"{group.label} has {', '.join(group.parts)}" for group in poses[:4])
        found.questions = [
            Question(q.key, f"{q.text}; incomplete: {lacking}", (), "NAME")
            if q.key == "columns.object_x"
            else q
            for q in found.questions
        ]
    if "wrench" in found.bases:
        for column in ("force_x", "force_y"):
            if column not in found.columns and f"columns.{column}" not in asked and column not in given:
                found.questions.append(Question(f"columns.{column}", "no such force", (), "NAME"))
