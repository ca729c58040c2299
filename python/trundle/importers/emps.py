"""The EMPS benchmark: a motor drives an axis through a ball screw, sampled at 1 kHz.

Janot, Gautier and Brunot, "Data set and reference models of EMPS", Workshop on Nonlinear System
Identification Benchmarks, 2019.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

import numpy as np

from trundle.importers.config import typed
from trundle.importers.layout import Columns, Floats, Imported, ShowProgress, SourceError
from trundle.importers.matfile import MatFile
from trundle.importers.streams import Stream, join

__all__ = ["NEEDS_MAP", "EmpsMap", "read"]

NEEDS_MAP = False

EPISODE_FILES = {"episode_00": "DATA_EMPS.mat", "episode_01": "DATA_EMPS_PULSES.mat"}

NAMES = {1: ("t", "qm", "vir"), 2: ("t", "qm", "vir", "qg")}
"""Signals by format version: time, measured position, voltage and commanded position."""


@dataclass(frozen=True)
class EmpsMap:
    """Settings of the import; all are optional.

    Attributes
    ----------
    name : str
        Name of the recording.
    format : int
        Version of the recording's format: 1 for an object on a rail, 2 for a slide joint, whose effort is in
        volts with the published gain.
    held_out : list of str
        Held-out episodes. `episode_00` is the estimation file, `episode_01` the file with pulses.
    """

    name: str = "EMPS: electro-mechanical positioning system"
    format: Literal[1, 2] = 1
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
    gains: list[float] = []
    for episode, file in EPISODE_FILES.items():
        say(file)
        signals, gain = _signals(MatFile(source / file), NAMES[options.format])
        episodes[episode] = _rail(signals, gain) if options.format == 1 else _joint(signals)
        gains.append(gain)
    if len(set(gains)) > 1:
        raise SourceError(source, f"`gtau` differs between the files: {gains}; are they of one benchmark?")
    shared = {
        "name": options.name,
        "split": {"held_out": options.held_out},
        "notes": {
            "origin": "EMPS benchmark, Janot, Gautier and Brunot 2019, nonlinearbenchmark.org",
            "force": "gtau * vir, the drive's command in N, any pulses included",
            "files": dict(EPISODE_FILES),
        },
    }
    special = RAIL if options.format == 1 else joint_metadata(gains[0])
    return Imported({**special, **shared}, episodes, [])


RAIL: dict[str, Any] = {
    "format": "trundle-recording/1",
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
}


def joint_metadata(gain: float) -> dict[str, Any]:
    """Return the metadata of a slide joint with a drive of `gain`, N/V."""
    return {
        "format": "trundle-recording/2",
        "mechanism": {"axis": "slide", "joints": ["load"]},
        # The voltage is the reference of a current loop, not that of the motor's winding.
        "effort": {"source": "commanded", "gain": gain},
        "start": {"at_rest": False},
    }


def _signals(file: MatFile, names: Sequence[str]) -> tuple[dict[str, Floats], float]:
    """Return some signals by name, and the gain of the drive, N/V."""
    found = {name: file.vector(name) for name in names}
    gain = file.vector("gtau")
    if len(gain) != 1 or len({len(values) for values in found.values()}) > 1:
        sizes = ", ".join(str(len(values)) for values in found.values())
        raise SourceError(
            file.path,
            f"{', '.join(f'`{name}`' for name in names)} have {sizes} samples and `gtau` {len(gain)}; "
            "the first must be equally long and `gtau` one number; is this a file of the benchmark?",
        )
    return found, float(gain[0])


def _rail(signals: dict[str, Floats], gain: float) -> Columns:
    values = np.column_stack([signals["qm"], gain * signals["vir"]])
    return join([Stream(["object_x", "force_x"], signals["t"], values)])


def _joint(signals: dict[str, Floats]) -> Columns:
    names = {"q_load": "qm", "effort_load": "vir", "target_load": "qg"}
    values = np.column_stack([signals[name] for name in names.values()])
    return join([Stream(list(names), signals["t"], values)])
