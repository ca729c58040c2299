"""MJCF and URDF files as specifications that can be edited before they are compiled."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from trundle._native import TrundleError
from trundle._optional import require

__all__ = ["compile_model", "import_mujoco", "joint_names", "read_specification", "silent_mujoco"]

MIN_VERSION = (3, 14)


def import_mujoco() -> Any:
    """Import MuJoCo, or name the extra that installs it.

    Raises
    ------
    TrundleError
        If it is missing or too old: earlier versions do not import mimic joints of a URDF.
    """
    mujoco = require("mujoco", "mujoco", "mechanisms with a model")
    if tuple(int(part) for part in mujoco.__version__.split(".")[:2]) < MIN_VERSION:
        wanted = ".".join(map(str, MIN_VERSION))
        raise TrundleError(
            f"mechanisms with a model need mujoco {wanted} or newer, not {mujoco.__version__}: "
            "pip install --upgrade mujoco"
        )
    return mujoco


@contextmanager
def silent_mujoco() -> Iterator[None]:
    """Suppress MuJoCo's warnings, which it prints and appends to MUJOCO_LOG.TXT in the current folder.

    A simulation that diverges returns NaN, which tells the caller enough.
    """
    mujoco = import_mujoco()
    previous = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda _: None)
    try:
        yield
    finally:
        mujoco.set_mju_user_warning(previous)


def read_specification(source: str | os.PathLike[str]) -> tuple[Any, str]:
    """Parse an MJCF or URDF model without compiling it, so that no mesh is read.

    Parameters
    ----------
    source : path or str
        A file, or the text of a model, which begins with "<".

    Returns
    -------
    specification : mujoco.MjSpec
    name : str
        Name of the source for messages.

    Raises
    ------
    TrundleError
        If the file does not exist or is not a model.
    """
    mujoco = import_mujoco()
    text = os.fspath(source)
    is_text = text.lstrip().startswith("<")
    name = "model text" if is_text else text
    if not is_text and not Path(text).is_file():
        raise TrundleError(f"{name}: no such file; give an MJCF or URDF file")
    try:
        spec = mujoco.MjSpec.from_string(text) if is_text else mujoco.MjSpec.from_file(text)
    except ValueError as error:
        raise TrundleError(f"{name}: not a model that MuJoCo can read: {_one_line(error)}") from error
    # Fixed links of a URDF keep their names, so that payloads and masses can refer to them.
    spec.compiler.fusestatic = False
    return spec, name


def joint_names(source: str | os.PathLike[str]) -> list[str]:
    """Return the named joints of an MJCF or URDF model, in its order.

    Parameters
    ----------
    source : path or str
        A file, or the text of a model.

    Raises
    ------
    TrundleError
        If the file does not exist or is not a model.
    """
    specification, _ = read_specification(source)
    return [joint.name for joint in specification.joints if joint.name]


def compile_model(spec: Any, name: str) -> Any:
    """Compile a specification.

    Raises
    ------
    TrundleError
        If MuJoCo refuses it; the message is MuJoCo's.
    """
    try:
        return spec.compile()
    except ValueError as error:
        message = _one_line(error)
        remedy = "; correct the mass and inertia of this body" if "inertia" in message else ""
        raise TrundleError(f"{name}: MuJoCo cannot compile the model: {message}{remedy}") from error


def _one_line(error: Exception) -> str:
    return ", ".join(line.strip() for line in str(error).splitlines() if line.strip())
