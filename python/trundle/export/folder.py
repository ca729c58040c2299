"""Export of a model to MuJoCo."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from pathlib import Path
from typing import TypeAlias

from trundle._native import Model, effects
from trundle.atomic import atomic_folder
from trundle.export.mjcf import mjcf, parse_model
from trundle.export.randomise import ranges

__all__ = ["to_mujoco"]

PathLike: TypeAlias = "str | os.PathLike[str]"
CALLBACK_FILE = "effects.py"
SCENE_FILE = "object.xml"


def to_mujoco(
    model: Model | PathLike, folder: PathLike, *, footprint: Sequence[Sequence[float]] | None = None
) -> Path:
    """Write a model for MuJoCo.

    Parameters
    ----------
    model : Model or path
        Must contain a value for every parameter, as a diagnosis or a fit writes it.
    folder : path
        Created, or replaced atomically if it contains an earlier export. It receives ``object.xml`` (MJCF),
        ``effects.py`` (the callback), ``model.toml`` (input of the callback) and ``ranges.json`` (95 %
        intervals of the posterior, and the names of instrument effects, which do not act as forces).
    footprint : sequence of (x, y), optional
        Corners, m, for a model without a footprint.

    Returns
    -------
    Path
        The folder.

    Raises
    ------
    TrundleError
        If a parameter has no value, there is no footprint, or the folder contains anything else.

    Examples
    --------
    >>> import tempfile
    >>> import trundle
    >>> table = trundle.objects.read("configs/objects/office_table.toml").models["locked"]
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     exported = trundle.export.to_mujoco(table, f"{folder}/mjcf")
    ...     sorted(path.name for path in exported.iterdir())
    ['effects.py', 'model.toml', 'object.xml', 'ranges.json']
    """
    read = model if isinstance(model, Model) else Model.read(model)
    folder = Path(folder)
    written = {
        SCENE_FILE: mjcf(read, footprint),
        "model.toml": read.to_toml(),
        "ranges.json": json.dumps(summary(read), indent=2, ensure_ascii=False) + "\n",
        CALLBACK_FILE: Path(__file__).with_name("callback.py").read_text(encoding="utf-8"),
    }
    with atomic_folder(folder, SCENE_FILE, "an export") as partial:
        for name, text in written.items():
            (partial / name).write_text(text, encoding="utf-8")
    return folder


def summary(model: Model) -> dict[str, object]:
    """Return the content of `ranges.json`."""
    acting = {effect["kind"]: effect["acting"] for effect in effects()}
    text = parse_model(model)
    instruments = [e["kind"] for e in text.get("effect", []) if acting[e["kind"]] == "instrument"]
    if text.get("unnamed", {}).get("axes") == "reading":
        instruments.append("unnamed")
    return {"parameters": ranges(model), "instruments": instruments}
