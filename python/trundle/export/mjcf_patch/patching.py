"""The refitted values and effects of a model, applied to a specification."""

from __future__ import annotations

import os
import xml.etree.ElementTree as ET
from pathlib import Path

from trundle._native import TrundleError
from trundle.export.mjcf_patch.actuators import ACTUATOR_EFFECTS, set_target_drive
from trundle.export.mjcf_patch.bodies import BODY_EFFECTS, scale_mass
from trundle.export.mjcf_patch.joints import JOINT_EFFECTS, finish_stops
from trundle.export.mjcf_patch.specification import Patch, open_patch
from trundle.mechanism import JointEffect, MechanismModel
from trundle.mechanism.source import compile_model

__all__ = ["apply_model", "patch_text"]

TARGET_VALUES = ("target_stiffness", "target_damping", "target_limit")


def compute(patch: Patch, effect: JointEffect) -> None:
    """Leave an effect to the callback."""
    patch.joint(effect)
    patch.compute(effect)


EFFECTS = {
    **JOINT_EFFECTS,
    **BODY_EFFECTS,
    **ACTUATOR_EFFECTS,
    "joint_directional_friction": compute,
    "joint_cogging": compute,
}
"""Functions by the kind of the effect, in the order in which they are applied."""


def apply_model(model: MechanismModel, source: str | os.PathLike[str]) -> Patch:
    """Apply a model to an MJCF or URDF file.

    Parameters
    ----------
    model : MechanismModel
    source : path
        The file that the model refers to.

    Raises
    ------
    TrundleError
        If a value or effect is unknown, or a parameter is missing.
    """
    patch = open_patch(Path(source), model.mechanism.joints)
    targets: dict[str, dict[str, float]] = {}
    for key, value in model.nominal.items():
        kind, _, name = key.partition(":")
        if kind in ("armature", "damping"):
            joint = patch.joint_named(name, key)
            if kind == "armature":
                joint.armature = value
            else:
                joint.damping[0] = value
        elif kind == "mass":
            scale_mass(patch, name, value)
        elif kind in TARGET_VALUES:
            patch.joint_named(name, key)
            targets.setdefault(name, {})[kind] = value
        else:
            known = ", ".join(("armature", "damping", "mass", *TARGET_VALUES))
            raise TrundleError(f"[nominal] {key!r}: unknown value; known are {known}, each with :NAME")
    for joint, values in targets.items():
        set_target_drive(patch, joint, values)
    unknown = [effect.kind for effect in model.effect if effect.kind not in EFFECTS]
    if unknown:
        raise TrundleError(f"[[effect]] kind = {unknown[0]!r}: unknown; known are {', '.join(EFFECTS)}")
    order = list(EFFECTS)
    for effect in sorted(model.effect, key=lambda one: order.index(one.kind)):
        try:
            EFFECTS[effect.kind](patch, effect)
        except KeyError as error:
            raise TrundleError(f"[[effect]] {effect.name}: `{error.args[0]}` is missing") from error
    return patch


def patch_text(patch: Patch, folder: Path) -> str:
    """Return the MJCF text of a patched specification, with its notes at the top.

    Parameters
    ----------
    patch : Patch
    folder : Path
        Where the text will be stored: paths of meshes and textures are relative to it.
    """
    compiled = compile_model(patch.spec, patch.name)
    if patch.stiffness:
        finish_stops(patch, compiled)
        compile_model(patch.spec, patch.name)
    lines = ["Patched by trundle export. Comments of the original file are not kept."]
    computed = sorted({f"{entry['kind']}:{entry['joint']}" for entry in patch.in_callback})
    if computed:
        lines.append(f"effects.py computes {', '.join(computed)}.")
    text = "\n".join(line.replace("--", "-") for line in [*lines, *patch.notes])
    return f"<!--\n{text}\n-->\n{relocated(patch, folder)}"


def relocated(patch: Patch, folder: Path) -> str:
    """Return the MJCF text with directories of meshes and textures relative to another folder."""
    root = ET.fromstring(patch.spec.to_xml())
    compiler = root.find("compiler")
    if compiler is None:
        compiler = ET.Element("compiler")
        root.insert(0, compiler)
    used = {"meshdir": (*patch.spec.meshes, *patch.spec.hfields), "texturedir": patch.spec.textures}
    for kind, assets in used.items():
        if any(asset.file for asset in assets):
            directory = (patch.directory / getattr(patch.spec, kind)).resolve()
            compiler.set(kind, Path(os.path.relpath(directory, folder.resolve())).as_posix())
    return ET.tostring(root, encoding="unicode") + "\n"
