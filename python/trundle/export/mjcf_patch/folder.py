"""The folder of a patched model: MJCF, callback, ranges and the model file."""

from __future__ import annotations

import json
import os
from pathlib import Path

import tomli_w

from trundle._native import TrundleError
from trundle.atomic import atomic_folder
from trundle.export.mjcf_patch.patching import apply_model, patch_text
from trundle.export.mjcf_patch.ranges import randomisation
from trundle.mechanism import MechanismModel

__all__ = ["MARKER", "write_mjcf_patch"]

MARKER = "robot.xml"
CALLBACK = "effects.py"


def write_mjcf_patch(
    model: MechanismModel | str | os.PathLike[str],
    folder: str | os.PathLike[str],
    *,
    mjcf: str | os.PathLike[str] | None = None,
) -> Path:
    """Write the user's MJCF or URDF with refitted values and missing effects, for plain MuJoCo.

    Parameters
    ----------
    model : MechanismModel or path
        A `model.toml` of a mechanism.
    folder : path
        Created, or replaced atomically if it contains an earlier export. It receives ``robot.xml`` (MJCF),
        ``randomisation.toml`` (95 % intervals of the posterior), ``model.toml``, and, if effects remain that
        MJCF cannot express, ``effects.py`` (a callback that needs MuJoCo and NumPy only) and
        ``effects.json``.
    mjcf : path, optional
        The file to patch; by default that of `[mechanism] model`, relative to `model.toml`.

    Returns
    -------
    Path
        The folder.

    Raises
    ------
    TrundleError
        If the model has no MJCF, or a value or effect of it does not fit the file.

    Examples
    --------
    >>> from pathlib import Path
    >>> import tempfile
    >>> from trundle.export import write_mjcf_patch
    >>> from trundle.mechanism import JointEffect, MechanismModel, MechanismTable
    >>> robot = '''<mujoco><worldbody><body name="arm"><joint name="elbow"/><geom size="0.1"/></body>
    ...   </worldbody></mujoco>'''
    >>> friction = JointEffect("joint_dry_friction", "elbow", parameters={"effort": 1.2})
    >>> model = MechanismModel(MechanismTable(["elbow"], "robot.xml"), {"damping:elbow": 0.8}, [friction])
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     written = Path(folder, "robot.xml").write_text(robot)
    ...     out = write_mjcf_patch(model, Path(folder, "patched"), mjcf=Path(folder, "robot.xml"))
    ...     text = (out / "robot.xml").read_text()
    >>> 'damping="0.8"' in text, 'frictionloss="1.2"' in text
    (True, True)
    """
    read = model if isinstance(model, MechanismModel) else MechanismModel.read(model)
    near = Path() if isinstance(model, MechanismModel) else Path(model).parent
    if read.mechanism.model is None:
        raise TrundleError("[mechanism] has no `model`: an axis without an MJCF file cannot be patched")
    source = near / read.mechanism.model if mjcf is None else Path(mjcf)
    if not source.is_file():
        raise TrundleError(f"{source}: no such file; give the MJCF or URDF file with --mjcf FILE")
    folder = Path(folder)
    patch = apply_model(read, source)
    written = {
        MARKER: patch_text(patch, folder),
        "model.toml": read.to_toml(),
        "randomisation.toml": tomli_w.dumps(randomisation(read)),
    }
    if patch.in_callback:
        written["effects.json"] = json.dumps(patch.in_callback, indent=2) + "\n"
        written[CALLBACK] = Path(__file__).with_name("callback.py").read_text(encoding="utf-8")
    with atomic_folder(folder, MARKER, "a patched model") as partial:
        for name, text in written.items():
            (partial / name).write_text(text, encoding="utf-8")
    return folder
