"""Rules of recordings of joints (format version 2) that every import must keep."""

from __future__ import annotations

import re

import numpy as np

from trundle.importers import Imported

TABLES = {
    *("format", "name", "mechanism", "effort", "target", "encoder"),
    *("noise", "delay", "episode", "split", "start", "notes"),
}
KEYS = {
    "mechanism": {"model", "joints", "free", "axis", "imposed", "inertia", "gravity", "gravity_torque"},
    "effort": {"source", "gain", "signed"},
    "target": {"stiffness", "damping", "limit"},
    "noise": {"position", "position_step", "velocity", "effort"},
    "delay": {"q", "v", "effort", "target"},
    "split": {"held_out"},
    "start": {"at_rest"},
}
COLUMN = re.compile(r"(q|v|effort|target|known|on|load)_(.+)")


def check_joints(imported: Imported) -> None:
    """Check tables, columns and files of a recording of joints."""
    metadata = imported.metadata
    assert metadata["format"] == "trundle-recording/2"
    assert set(metadata) <= TABLES
    for table, keys in KEYS.items():
        assert set(metadata.get(table, {})) <= keys
    mechanism = metadata["mechanism"]
    assert ("model" in mechanism) != ("axis" in mechanism)
    models = [each["model"] for each in [mechanism, *metadata.get("episode", {}).values()] if "model" in each]
    assert set(models) <= set(imported.files)
    assert set(metadata.get("split", {}).get("held_out", [])) < set(imported.episodes)
    assert set(metadata.get("episode", {})) <= set(imported.episodes)
    for episode in imported.episodes.values():
        check_columns(episode, mechanism["joints"])


def check_columns(table: dict[str, np.ndarray], joints: list[str]) -> None:
    """Check the columns of an episode."""
    assert table["t"][0] == 0.0
    assert np.all(np.diff(table["t"]) > 0.0)
    names = [COLUMN.fullmatch(name) for name in table if name != "t"]
    assert {name[2] for name in names if name} == set(joints) and all(names)
    there = np.zeros(len(table["t"]), dtype=bool)
    for name in table:
        assert len(table[name]) == len(table["t"])
        there |= (name != "t") & np.isfinite(table[name])
    assert np.all(there), "a row without a sample"
    assert all(np.any(np.isfinite(table[f"q_{joint}"])) for joint in joints)
