"""The EMPS benchmark: a motor drives an axis through a ball screw, sampled at 1 kHz.

Janot, Gautier and Brunot, "Data set and reference models of EMPS", Workshop on Nonlinear System
Identification Benchmarks, 2019.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from trundle.importers.config import typed
from trundle.importers.layout import Columns, Imported, ShowProgress, SourceError
from trundle.importers.matfile import MatFile
from trundle.importers.streams import Stream, join

__all__ = ["NEEDS_MAP", "EmpsMap", "read"]

NEEDS_MAP = False

EPISODE_FILES = {"episode_00": "DATA_EMPS.mat", "episode_01": "DATA_EMPS_PULSES.mat"}


@dataclass(frozen=True)
class EmpsMap:
    """Settings of the import; all are optional.

    Attributes
    ----------
    name : str
        Name of the recording.
    held_out : list of str
        Held-out episodes. `episode_00` is the estimation file, `episode_01` the file with pulses.
    """

    name: str = "EMPS: electro-mechanical positioning system"
    held_out: list[str] = field(default_factory=lambda: ["episode_01"])


def read(source: Path, settings: Mapping[str, Any], say: ShowProgress) -> Imported:
    """Read the folder that contains both files.

    The force is that of the drive: gain times voltage. The voltage of the validation file already includes
    the pulses: it jumps by 5 V at each of their edges, and the position loop settles 5 V/(kp kv) away.
    Therefore `pulses_N`, which is in volts despite its name, is not added.
    """
    options = typed(EmpsMap, settings)
    if not source.is_dir():
        raise SourceError(
            source, f"not a folder; give the folder that contains {' and '.join(EPISODE_FILES.values())}"
        )
    episodes: dict[str, Columns] = {}
    for episode, file in EPISODE_FILES.items():
        say(file)
        episodes[episode] = _episode(MatFile(source / file))
    metadata = {
        "format": "trundle-recording/1",
        "name": options.name,
        # The axis moves at 7 mm/s in the first sample: both files begin inside the reference motion.
        "at_rest": False,
        "object": {"dof": ["x"]},
        "wrench": {
            "frame": "object",
            "reference": "object",
            "sign": "on_object",
            "raw": False,
            "contact": "grasp",
            "source": "commanded",
        },
        "split": {"held_out": options.held_out},
        "notes": {
            "origin": "EMPS benchmark, Janot, Gautier and Brunot 2019, nonlinearbenchmark.org",
            "force": "gtau * vir, the drive's command in N, any pulses included",
            "files": dict(EPISODE_FILES),
        },
    }
    return Imported(metadata, episodes, [])


def _episode(file: MatFile) -> Columns:
    t, x, volts, gain = (file.vector(name) for name in ("t", "qm", "vir", "gtau"))
    if len(gain) != 1 or not len(t) == len(x) == len(volts):
        raise SourceError(
            file.path,
            f"`t`, `qm`, `vir` have {len(t)}, {len(x)}, {len(volts)} samples and `gtau` {len(gain)}; "
            "the first three must be equally long and `gtau` one number; is this a file of the benchmark?",
        )
    force = gain[0] * volts
    return join([Stream(["object_x", "force_x"], t, np.column_stack([x, force]))])
