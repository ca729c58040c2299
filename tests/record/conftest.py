"""A minimal recording with all features."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import trundle

Tables = dict[str, dict[str, Any]]


@pytest.fixture
def metadata() -> dict[str, Any]:
    return {
        "format": "trundle-recording/1",
        "name": "a table",
        "object": {"footprint": [[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]]},
        "wrench": {"frame": "object", "sign": "on_object"},
    }


@pytest.fixture
def tables() -> Tables:
    """Poses at every other reading; one note."""
    t = np.arange(9) / 10
    pose = np.where(np.arange(9) % 2 == 0, t / 3, np.nan)
    names = ["object_x", "object_y", "object_theta"]
    force = np.sqrt(t)
    wrench = {"force_x": force, "force_y": -force, "torque_z": force / 7}
    notes = ["", 'a, "b"', "line\nbreak", "ü", " spaces ", "nan", "", "7", "end"]
    return {"episode_00": {"t": t, **dict.fromkeys(names, pose), **wrench, "note_remark": notes}}


@pytest.fixture
def recording(metadata: dict[str, Any], tables: Tables) -> trundle.Recording:
    return trundle.Recording(metadata, tables)


@pytest.fixture
def folder(recording: trundle.Recording, tmp_path: Path) -> Path:
    """A folder with valid metadata; the test writes the table."""
    recording.write(tmp_path / "run")
    (tmp_path / "run" / "episode_00.csv").unlink()
    return tmp_path / "run"
