"""The specification that is patched, with what the effects need to know about it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from trundle._native import TrundleError
from trundle.mechanism import JointEffect, Mechanism
from trundle.mechanism.locking import moving_bodies, name_bodies
from trundle.mechanism.meshes import remove_appearance, remove_meshes
from trundle.mechanism.source import compile_model, import_mujoco, read_specification

__all__ = ["Patch", "open_patch"]


@dataclass
class Patch:
    """A specification while it is patched.

    Attributes
    ----------
    spec : mujoco.MjSpec
    original : mujoco.MjModel
        The user's model, compiled.
    mechanism : Mechanism
        The user's model with its recorded joints.
    name : str
        Name of the source for messages.
    directory : Path
        Folder of the source, to which its paths of meshes are relative.
    chains : dict of str to list of str
        Joints whose positions add up to that of a recorded joint: the drive's, and its play or compliance.
    offsets : dict of str to float
        Offsets of encoders.
    stiffness : dict of str to float
        Stiffness of stops by their tendons.
    in_callback : list of dict
        Effects that the callback computes.
    notes : list of str
        What the user should know.
    """

    spec: Any
    original: Any
    mechanism: Mechanism
    name: str
    directory: Path
    chains: dict[str, list[str]]
    offsets: dict[str, float] = field(default_factory=dict)
    stiffness: dict[str, float] = field(default_factory=dict)
    in_callback: list[dict[str, Any]] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    def joint(self, effect: JointEffect) -> Any:
        """Return the joint of an effect."""
        return self.joint_named(effect.joint or "", effect.name)

    def joint_named(self, joint: str, wanted_by: str) -> Any:
        """Return a recorded joint.

        Raises
        ------
        TrundleError
            If there is none of that name.
        """
        if joint not in self.mechanism.joints:
            known = ", ".join(self.mechanism.joints)
            raise TrundleError(f"{wanted_by}: unknown joint {joint!r}; the recorded joints are {known}")
        return self.spec.joint(joint)

    def angle(self, joint: Any) -> float:
        """Return the factor from SI to the unit in which the specification holds positions of a joint."""
        hinge = joint.type == import_mujoco().mjtJoint.mjJNT_HINGE
        return 180.0 / math.pi if hinge and joint.compiler.degree else 1.0

    def compute(self, effect: JointEffect) -> None:
        """Leave an effect to the callback."""
        joint = effect.joint or ""
        self.in_callback.append(
            {
                "kind": effect.kind,
                "joint": joint,
                "chain": self.chains[joint],
                "offset": self.offsets.get(joint, 0.0),
                **effect.parameters,
            }
        )


def open_patch(source: Path, joints: Sequence[str]) -> Patch:
    """Read the model to patch.

    Parameters
    ----------
    source : Path
        The user's MJCF or URDF file.
    joints : sequence of str
        The recorded joints.
    """
    spec, name = read_specification(source)
    name_bodies(spec)
    mechanism = Mechanism.load(source, joints)
    notes = []
    textures = source.parent / spec.texturedir
    if any(one.file and not (textures / one.file).is_file() for one in spec.textures):
        remove_appearance(spec)
        notes.append("Materials are removed, because their textures are missing.")
    missing = remove_meshes(spec, name, moving_bodies(spec), only_missing=True)
    if missing:
        notes.append(f"Geoms of missing files are removed: {', '.join(missing)}.")
    original = compile_model(spec, name)
    chains = {joint: [joint] for joint in joints}
    return Patch(spec, original, mechanism, name, source.parent, chains, notes=notes)
