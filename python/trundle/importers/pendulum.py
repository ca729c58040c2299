"""Decay of a one-link and a two-link pendulum that swing freely, 1 kHz.

K. Kaheman et al., "The experimental multi-arm pendulum on a cart", arXiv 2205.06231; GitHub
`dynamicslab/MultiArm-Pendulum`, `ParameterEstimation/`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from trundle.importers.config import typed
from trundle.importers.joints.joint_map import FORMAT, mechanism_of, merge
from trundle.importers.layout import Columns, Floats, Imported, ShowProgress, SourceError
from trundle.importers.matfile import MatFile

__all__ = ["NEEDS_MAP", "PendulumMap", "read"]

NEEDS_MAP = False

SETS = {"id": "Y_id", "vad": "Y_vad"}
"""Cell arrays of the training and the validation pieces, by the suffix of their times."""
LINKS_BY_ROWS = {2: ["arm"], 4: ["upper", "lower"]}
"""Joints by the number of rows of a piece, which has an angle and an angular velocity for each link."""
LENGTH_M = 0.1727
"""Distance of the bearings of the upper link, m."""
MODEL = "double_pendulum.xml"
# The lengths, masses and the damping are those of the authors' simulation of the same arms
# (`TriplePendulumSimWithX0.m`). Its inertias refer to the bearings. They and the centre of the upper link are
# here least-squares estimates from the training pieces, 3 to 18 % from the authors' values. The scale of all
# masses and inertias is arbitrary, because no force was measured.
MODEL_TEXT = f"""<mujoco model="double pendulum">
  <option gravity="0 0 -9.81"/>
  <worldbody>
    <body name="upper_link">
      <joint name="upper" type="hinge" axis="0 1 0" damping="1e-4"/>
      <inertial pos="0 0 -0.1030" mass="0.11" diaginertia="5.94e-4 5.94e-4 1e-6"/>
      <body name="lower_link" pos="0 0 -{LENGTH_M}">
        <joint name="lower" type="hinge" axis="0 1 0" damping="1e-4"/>
        <inertial pos="0 0 -0.127" mass="0.12" diaginertia="1.048e-3 1.048e-3 1e-6"/>
      </body>
    </body>
  </worldbody>
</mujoco>
"""


@dataclass(frozen=True)
class PendulumMap:
    """Settings of the import; all are optional.

    Attributes
    ----------
    name : str
        Name of the recording.
    recording : dict
        Tables that are added to `recording.toml`, or replace its values, such as another `mechanism.model`.
    """

    name: str | None = None
    recording: dict[str, Any] = field(default_factory=dict)


def read(source: Path, settings: Mapping[str, Any], say: ShowProgress) -> Imported:
    """Read `single.mat` or `double.mat`; each piece of the decay is an episode.

    The validation pieces are held out. Only the angles are read, because the velocities were smoothed.
    """
    options = typed(PendulumMap, settings)
    if source.is_dir():
        raise SourceError(source, "is a folder; give single.mat or double.mat in it, one recording each")
    say(source.name)
    file = MatFile(source)
    episodes: dict[str, Columns] = {}
    held_out: list[str] = []
    for suffix, variable in SETS.items():
        times = file.cell(f"Time_{suffix}")
        pieces = file.cell(variable)
        if len(times) != len(pieces):
            raise SourceError(
                source, f"`{variable}` has {len(pieces)} pieces and `Time_{suffix}` {len(times)} times"
            )
        for number, (t, piece) in enumerate(zip(times, pieces, strict=True), 1):
            name = f"piece_{len(episodes):02}"
            episodes[name] = _episode(source, f"{variable}{{{number}}}", t.ravel(), piece)
            if suffix == "vad":
                held_out.append(name)
    joints = {tuple(name for name in table if name != "t") for table in episodes.values()}
    if len(joints) != 1:
        raise SourceError(source, "pieces of one link and of two; a file must contain pieces of one pendulum")
    links = len(next(iter(joints)))
    metadata = merge(
        _metadata(options.name or f"free pendulum, {source.stem}", links, held_out), options.recording
    )
    files = {MODEL: MODEL_TEXT} if mechanism_of(metadata).get("model") == MODEL else {}
    return Imported(metadata, episodes, [], files)


def _episode(source: Path, where: str, t: Floats, piece: Floats) -> Columns:
    """Return the columns of a piece."""
    joints = LINKS_BY_ROWS.get(len(piece))
    if joints is None or piece.shape[1] != len(t) or len(t) < 2:
        raise SourceError(
            source,
            f"`{where}` of the shape {piece.shape} with {len(t)} times: must have 2 rows for one link, or 4 "
            "for two, and a column for each time",
        )
    wrong = np.flatnonzero(~np.isfinite(t) | ~np.all(np.isfinite(piece), axis=0))
    if len(wrong):
        raise SourceError(source, f"`{where}`, column {wrong[0] + 1}: an angle or a time is not a number")
    late = np.flatnonzero(np.diff(t) <= 0.0)
    if len(late):
        raise SourceError(
            source,
            f"`{where}`, column {late[0] + 2}: time {t[late[0] + 1]:.9g} s is not after the one before",
        )
    q = joint_angles(piece[: len(joints)])
    return {"t": np.round(t - t[0], 9)} | {f"q_{joint}": q[k] for k, joint in enumerate(joints)}


def joint_angles(from_upright: Floats) -> Floats:
    """Return the angles of the joints, which are zero where the pendulum hangs down.

    Parameters
    ----------
    from_upright : (k, n) array
        Absolute angles of the k links from upright, rad; π hangs down.

    Returns
    -------
    (k, n) array
        Angle of the first link from hanging down, and of each further link relative to the one before, rad.
    """
    return np.diff(from_upright - np.pi, axis=0, prepend=0.0)


def _metadata(name: str, links: int, held_out: list[str]) -> dict[str, Any]:
    """Return the content of `recording.toml`."""
    single: dict[str, Any] = {"axis": "hinge", "joints": LINKS_BY_ROWS[2], "gravity": True}
    double: dict[str, Any] = {"model": MODEL, "joints": LINKS_BY_ROWS[4]}
    published = {
        "published": "viscous friction 2.24e-4 N·m·s, mass 0.1476 kg, lever arm 0.1478 m, inertia about the "
        "mass centre 1.09e-4 kg·m²: damping of 0.0672 1/s per unit inertia"
    }
    return {
        "format": FORMAT,
        "name": name,
        "mechanism": single if links == 1 else double,
        "start": {"at_rest": False},
        "split": {"held_out": held_out},
        "notes": {
            "origin": "github.com/dynamicslab/MultiArm-Pendulum, ParameterEstimation; arXiv 2205.06231",
            "licence": "MIT",
            "angles": "0 hangs down; of two links the second angle is relative to the first",
            "episodes": "pieces of one decay: the held-out pieces have the smallest amplitudes",
            **(published if links == 1 else {}),
        },
    }
