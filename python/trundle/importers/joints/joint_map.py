"""Keys that the maps of all logs of joints share, and `recording.toml` from them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

import numpy as np

from trundle.importers.config import MapError
from trundle.importers.joints.columns import ANGULAR, HELD, HELD_SOURCES, Kind, known
from trundle.importers.layout import Floats, Imported, SourceError
from trundle.importers.takes import EpisodeMap, Take, assemble

__all__ = ["Angle", "JointMap", "assemble_joints", "is_joint_map", "mechanism_of", "merge"]

Angle = Literal["radians", "degrees"]
MAX_TURNS = 2
"""Maximum position of a joint, in turns, for which a log without `angle` is accepted as in radians."""
FORMAT = "trundle-recording/2"


@dataclass(frozen=True)
class JointMap:
    """Settings of a map file for logs of joints.

    Attributes
    ----------
    joints : list of str, or dict of str to str
        Joints to import; as a dictionary, the name in the log of each joint of the recording.
    angle : str, or dict of str to str
        Unit of positions, velocities and targets in the log, for all joints or by joint: "radians" or
        "degrees". Positions without it are in radians, and an error if they exceed two turns.
    name : str
        Name of the recording; by default that of the source.
    episode : list of EpisodeMap
        Intervals to cut; by default each take is an episode.
    recording : dict
        Tables that are copied to `recording.toml`.
    """

    joints: list[str] | dict[str, str] = field(default_factory=list)
    angle: Angle | dict[str, Angle] | None = None
    name: str | None = None
    episode: list[EpisodeMap] = field(default_factory=list)
    recording: dict[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if not self.joints:
            raise MapError("`joints` is empty; list the joints to import")
        for what, names in (("joints", list(self.joints)), ("names in the log", self.log_names)):
            twice = next((name for name in names if names.count(name) > 1), None)
            if twice is not None:
                raise MapError(f"`joints`: {twice!r} occurs twice; {what} must be unique")
        if isinstance(self.angle, dict):
            for joint in self.angle:
                if joint not in self.joints:
                    raise MapError(f"`angle.{joint}`: unknown joint; {known(self.joints)}")

    @property
    def names(self) -> list[str]:
        """The joints of the recording."""
        return list(self.joints)

    @property
    def log_names(self) -> list[str]:
        """The names of the joints in the log, in the order of `names`."""
        return list(self.joints.values()) if isinstance(self.joints, dict) else list(self.joints)

    def holds(self, kind: Kind, joint: str) -> bool:
        """Return whether a value of a column holds until the next sample, as commands do."""
        effort = self.recording.get("effort", {})
        source = effort.get("source") if isinstance(effort, Mapping) else None
        source = source.get(joint) if isinstance(source, Mapping) else source
        return kind in HELD or (kind == "effort" and source in HELD_SOURCES)

    def radians(self, source: Path, kind: Kind, joint: str, values: Floats) -> Floats:
        """Return values of a joint with angles in radians.

        Parameters
        ----------
        source : Path
            For messages.
        kind : str
            Kind of the column.
        joint : str
            A joint of the recording.
        values : (n,) array
            Values in the order of the log, NaN where there is no sample.
        """
        if kind not in ANGULAR or mechanism_of(self.recording).get("axis") == "slide":
            return values
        angle = self.angle.get(joint, "radians") if isinstance(self.angle, dict) else self.angle
        if angle == "degrees":
            return np.radians(values)
        large = np.flatnonzero(np.abs(values) > 2.0 * np.pi * MAX_TURNS)
        if angle is None and kind != "v" and len(large):
            raise SourceError(
                source,
                f"row {large[0] + 1}: {kind}_{joint} = {values[large[0]]:.6g} is more than {MAX_TURNS} turns "
                "in radians; end the name of the column with _deg, or with _rad if the joint does turn that "
                'far, or set `angle` = "degrees" or "radians" in the map',
            )
        return values


def is_joint_map(settings: Mapping[str, Any]) -> bool:
    """Return whether a map is for joints."""
    return "joints" in settings


def mechanism_of(recording: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return the table `mechanism` of the tables that a map adds to `recording.toml`."""
    mechanism = recording.get("mechanism", {})
    if not isinstance(mechanism, Mapping):
        raise MapError(f"`recording.mechanism` = {mechanism!r}: it is a table")
    return mechanism


def assemble_joints(takes: Sequence[Take], joint_map: JointMap, name: str) -> Imported:
    """Return a recording of joints from takes, with the metadata of the map.

    Raises
    ------
    MapError
        If the map has neither a model nor the kind of a single axis.
    """
    recording = joint_map.recording
    mechanism = mechanism_of(recording)
    if mechanism.get("joints", joint_map.names) != joint_map.names:
        raise MapError("`recording.mechanism.joints` differs from `joints`; remove it")
    if not {"model", "axis", "types"} & mechanism.keys():
        raise MapError(
            '`recording.mechanism.model` is missing: an MJCF or URDF file; without one set `axis` = "hinge" '
            'or "slide" in [recording.mechanism], for a single joint'
        )
    if "axis" in mechanism and len(joint_map.names) > 1:
        raise MapError(
            f"`recording.mechanism.axis` is for a single joint, and `joints` has {len(joint_map.names)}; "
            "name one of them, or give a `model` instead"
        )
    found = merge(recording, {"mechanism": {"joints": joint_map.names}})
    return assemble(takes, joint_map.episode, found, joint_map.name or name, FORMAT)


def merge(base: Mapping[str, Any], more: Mapping[str, Any]) -> dict[str, Any]:
    """Return the tables of `base`, with the values of `more` added or in their place."""
    merged = dict(base)
    for key, value in more.items():
        old = merged.get(key)
        merged[key] = merge(old, value) if isinstance(old, Mapping) and isinstance(value, Mapping) else value
    return merged
