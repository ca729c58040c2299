"""Removal of meshes, height fields and materials that are missing or do not affect the motion."""

from __future__ import annotations

import os
from collections.abc import Collection
from pathlib import Path
from typing import Any

from trundle._native import TrundleError
from trundle.mechanism.source import import_mujoco

__all__ = ["remove_appearance", "remove_meshes"]


def remove_appearance(spec: Any) -> None:
    """Remove materials, textures and skins, whose files need not exist."""
    for element in (*spec.geoms, *spec.sites, *spec.tendons):
        element.material = ""
    for element in (*spec.skins, *spec.materials, *spec.textures):
        spec.delete(element)


def remove_meshes(spec: Any, name: str, moving: Collection[str], *, only_missing: bool = False) -> list[str]:
    """Remove geoms with missing meshes or height fields, and geoms of meshes that only have an appearance.

    Parameters
    ----------
    spec : mujoco.MjSpec
    name : str
        Name of the model for messages.
    moving : collection of str
        Names of the bodies that move; the inertia of others does not matter.
    only_missing : bool
        Whether to keep geoms that only have an appearance.

    Returns
    -------
    list of str
        Files that are missing and whose geoms were removed.

    Raises
    ------
    TrundleError
        If the inertia of a moving body depends on a missing mesh.
    """
    files = {mesh.name or Path(mesh.file).stem: mesh for mesh in spec.meshes}
    missing_fields = {
        field.name or Path(field.file).stem: field.file
        for field in spec.hfields
        if field.file and not _exists(spec, field, field.file)
    }
    missing = []
    for geom in list(spec.geoms):
        if geom.hfieldname in missing_fields:
            missing.append(missing_fields[geom.hfieldname])
            spec.delete(geom)
        mesh = files.get(geom.meshname) if geom.meshname else None
        if mesh is None:
            continue
        body = geom.parent
        shapes_inertia = body.name in moving and _shapes_inertia(spec, body, geom)
        exists = not mesh.file or _exists(spec, mesh, mesh.file)
        if not exists and shapes_inertia:
            raise TrundleError(
                f"{name}: body {body.name!r}: its inertia comes from the mesh {mesh.file!r}, which is "
                "missing; put the file where the model expects it, or give the body an <inertial> element"
            )
        collides = bool(geom.contype or geom.conaffinity)
        if not exists or not (shapes_inertia or collides or only_missing):
            missing += [] if exists else [mesh.file]
            spec.delete(geom)
    _remove_unused_assets(spec)
    return sorted(set(missing))


def _shapes_inertia(spec: Any, body: Any, geom: Any) -> bool:
    """Return whether the compiler takes the inertia of a body from a geom."""
    mujoco = import_mujoco()
    rule = spec.compiler.inertiafromgeom
    if rule == mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_FALSE:
        return False
    if rule == mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_AUTO and body.explicitinertial:
        return False
    low, high = spec.compiler.inertiagrouprange
    has_mass = geom.mass > 0 if geom.mass == geom.mass else geom.density > 0
    return bool(low <= geom.group <= high and has_mass)


def _exists(spec: Any, asset: Any, file: str) -> bool:
    """Return whether the file of an asset exists in memory or on disk."""
    if spec.strippath:
        file = os.path.basename(file)
    folder = asset.compiler.meshdir or ""
    paths = (file, os.path.join(folder, file))
    if any(path in spec.assets for path in paths):
        return True
    return bool(spec.modelfiledir) and any((Path(spec.modelfiledir) / path).is_file() for path in paths)


def _remove_unused_assets(spec: Any) -> None:
    """Remove meshes and height fields that no geom uses any more."""
    meshes = {geom.meshname for geom in spec.geoms}
    fields = {geom.hfieldname for geom in spec.geoms}
    for mesh in list(spec.meshes):
        if (mesh.name or Path(mesh.file).stem) not in meshes:
            spec.delete(mesh)
    for field in list(spec.hfields):
        if (field.name or Path(field.file).stem) not in fields:
            spec.delete(field)
