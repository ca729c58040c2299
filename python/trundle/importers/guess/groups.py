"""Columns grouped by body: poses of the object and the gripper, and the wrench."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable
from dataclasses import dataclass, field, replace

from trundle.importers.guess.names import ColumnName
from trundle.importers.guess.vocabulary import (
    GRIPPER_WORDS,
    OBJECT_WORDS,
    TORQUE_OR_TRANSLATION,
    Quantity,
)

__all__ = ["Group", "group_columns"]

Body = tuple[str, ...]


@dataclass
class Group:
    """Columns of one body.

    Attributes
    ----------
    body : tuple of str
        Words that name the body or the instrument; empty if the names have none.
    parts : dict of str to ColumnName
        Columns by part: x, y, z, theta, qw, qx, qy, qz of a pose; force_x … torque_z of a wrench.
    doubles : dict of str to list of ColumnName
        Parts that several columns claim.
    """

    body: Body
    parts: dict[str, ColumnName] = field(default_factory=dict)
    doubles: dict[str, list[ColumnName]] = field(default_factory=dict)

    def add(self, part: str, column: ColumnName) -> None:
        """Add a column; two columns of one part are both removed to `doubles`."""
        if part in self.doubles:
            self.doubles[part].append(column)
        elif part in self.parts:
            self.doubles[part] = [self.parts.pop(part), column]
        else:
            self.parts[part] = column

    @property
    def label(self) -> str:
        """Return the words of the body."""
        return " ".join(self.body) or "without a body's name"

    @property
    def is_object(self) -> bool:
        """Whether the words name the pushed object and not the gripper."""
        return bool(OBJECT_WORDS & set(self.body)) and not GRIPPER_WORDS & set(self.body)

    @property
    def is_gripper(self) -> bool:
        """Whether the words name the gripper or its sensor and not the object."""
        return bool(GRIPPER_WORDS & set(self.body)) and not OBJECT_WORDS & set(self.body)

    @property
    def is_pose(self) -> bool:
        """Whether the columns are a planar or a spatial pose."""
        turned = "theta" in self.parts or all(f"q{axis}" in self.parts for axis in "wxyz")
        return {"x", "y"} <= self.parts.keys() and turned

    @property
    def columns(self) -> list[ColumnName]:
        """All columns, those of `doubles` included."""
        return [*self.parts.values(), *(column for columns in self.doubles.values() for column in columns)]

    @property
    def claimed(self) -> set[str]:
        """Parts that at least one column claims."""
        return self.parts.keys() | self.doubles.keys()

    def holds(self, name: str) -> bool:
        """Return whether a column of the file is in this group."""
        return name in [column.text for column in self.columns]


def group_columns(names: list[ColumnName]) -> tuple[list[Group], list[Group]]:
    """Return the groups of poses and of wrenches, each in the order of the file."""
    names = decide_torques(names)
    poses, wrenches = _collect(names, _pose_part), _collect(names, _wrench_part)
    return _join_lone(poses, {"x", "y"}, {"theta"}), _join_lone(wrenches, {"force_x"}, {"torque_z"})


def decide_torques(names: list[ColumnName]) -> list[ColumnName]:
    """Decide whether t_x, t_y, t_z are torques or translations, from the other columns of the body."""
    kinds: dict[Body, set[Quantity]] = defaultdict(set)
    for name in names:
        if name.quantity:
            kinds[name.body].add(name.quantity)
    return [
        replace(name, quantity=_torque_or_position(kinds[name.body]))
        if name.reason == TORQUE_OR_TRANSLATION
        else name
        for name in names
    ]


def _torque_or_position(kinds: set[Quantity]) -> Quantity | None:
    turns = {"heading", "quaternion"} & kinds
    if "force" in kinds and "torque" not in kinds and ("position" in kinds or not turns):
        return "torque"
    return "position" if turns and not {"force", "position"} & kinds else None


def _pose_part(name: ColumnName) -> str | None:
    if name.quantity == "position" and name.axis:
        return name.axis
    if name.quantity == "heading" or (name.quantity == "quaternion" and name.axis):
        return "theta" if name.quantity == "heading" else f"q{name.axis}"
    return None


def _wrench_part(name: ColumnName) -> str | None:
    return f"{name.quantity}_{name.axis}" if name.quantity in ("force", "torque") and name.axis else None


def _collect(names: list[ColumnName], part_of: Callable[[ColumnName], str | None]) -> list[Group]:
    groups: dict[Body, Group] = {}
    for name in names:
        part = part_of(name)
        if part is not None:
            groups.setdefault(name.body, Group(name.body)).add(part, name)
    return list(groups.values())


def _join_lone(groups: list[Group], main: set[str], lone: set[str]) -> list[Group]:
    """Join the only group that has `lone` alone to the only group that has `main` without it."""
    without = [group for group in groups if main <= group.parts.keys() and not lone & group.claimed]
    alone = [group for group in groups if lone <= group.parts.keys() and not main & group.claimed]
    if len(without) != 1 or len(alone) != 1 or len([g for g in groups if main <= g.claimed]) != 1:
        return groups
    if without[0].is_gripper != alone[0].is_gripper:
        return groups
    for part, column in alone[0].parts.items():
        without[0].add(part, column)
    return [group for group in groups if group is not alone[0]]
