"""Rerun recordings (.rrd): the object, the wrenches and both simulations over time.

The module loads rerun-sdk (extra `rerun`) when a file is written.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import TypeAlias

from trundle import _native
from trundle.atomic import atomic_file
from trundle.diagnosis import Diagnosis
from trundle.recording import JointRecording, Recording, TrundleError

__all__ = ["view"]

PathLike: TypeAlias = "str | os.PathLike[str]"
SUFFIX = ".rrd"
MAGIC = b"RRF"
"""First bytes of every .rrd file."""


def view(
    source: Recording | Diagnosis | PathLike,
    out: PathLike | None = None,
    *,
    recording: Recording | PathLike | None = None,
) -> Path:
    """Write a recording, a diagnosis or a run for the Rerun viewer.

    The file shows the object from above with its feet, wheels and gripper, the measured and the missing
    wrench as arrows, both simulations, and curves and windows over time (docs/view.md).

    Parameters
    ----------
    source : Recording, Diagnosis or path
        The folder of a recording, of a diagnosis or of a run, or an object.
    out : path, optional
        Output file with the suffix `.rrd`, written atomically. By default the path of the source with this
        suffix; for an object its name, in the current folder.
    recording : Recording or path, optional
        The recording of a diagnosis. For a folder, trundle searches the folders near it and the current
        folder for the recording that the diagnosis names.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    TrundleError
        If rerun-sdk is not installed, a path holds none of the three, the recording of a diagnosis is
        missing or another one, or `out` is another file.

    Examples
    --------
    >>> import trundle
    >>> trundle.view("diagnosis/table", "table.rrd")  # doctest: +SKIP
    PosixPath('table.rrd')
    """
    from trundle.viewing.rrd import write_rrd
    from trundle.viewing.sources import load_scene

    if isinstance(source, JointRecording):
        source = _native._pushed(source)  # refused
    given = source if isinstance(source, Recording | Diagnosis) else Path(source)
    target = Path(out) if out is not None else default_target(given)
    check_target(target)
    known = recording if recording is None or isinstance(recording, Recording) else Path(recording)
    scene = load_scene(given, known)
    with atomic_file(target) as part:
        write_rrd(scene, part)
    return target


def default_target(source: Recording | Diagnosis | Path) -> Path:
    """Return the output file of a source."""
    if isinstance(source, Path):
        folder = source.resolve()
        return (
            folder.with_name(folder.name + SUFFIX)
            if source.name in ("", "..")
            else source.with_name(source.name + SUFFIX)
        )
    name = source.name if isinstance(source, Recording) else source.answer["recording"]
    return Path("".join(c if c.isalnum() or c in "-_." else "_" for c in name) + SUFFIX)


def check_target(path: Path) -> None:
    """Refuse a path without the suffix `.rrd`, and an existing file that is no Rerun recording."""
    if path.suffix != SUFFIX:
        raise TrundleError(f"{path}: the name must end in {SUFFIX}")
    if path.is_dir():
        raise TrundleError(f"{path}: is a folder; give another name with --out")
    if path.exists():
        with path.open("rb") as stream:
            if stream.read(len(MAGIC)) != MAGIC:
                raise TrundleError(
                    f"{path}: exists and is not a Rerun recording; give another name with --out"
                )
