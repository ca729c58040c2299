"""Cards of the native classes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from trundle.display.card import Card, Table
from trundle.display.formatting import format_number, join_names
from trundle.episode import Episode
from trundle.episode_table import EpisodeTable

__all__ = ["joint_recording_card", "model_card", "recording_card"]


def recording_card(recording: Any) -> Card:
    """Return the card of a recording."""
    metadata, episodes = recording.metadata, recording.values()
    facts = [
        ("object", _object(metadata["object"])),
        *_split(episodes),
        ("streams", "; ".join(_streams(episodes)) or "none"),
        ("wrench", _wrench(metadata["wrench"])),
        ("noise", _noise(metadata.get("noise"))),
    ]
    return Card(f"trundle.Recording {recording.name!r}: {len(episodes)} episodes", facts)


def joint_recording_card(recording: Any) -> Card:
    """Return the card of a recording of joints."""
    mechanism, episodes = recording.metadata["mechanism"], recording.values()
    kind = "joints of a black-box simulator"
    if "model" in mechanism:
        kind = f"model {mechanism['model']}"
    elif "axis" in mechanism:
        kind = f"one {mechanism['axis']} axis, no model"
    facts = [("mechanism", kind), *_split(episodes)]
    streams = {joint: ", ".join(found) for joint, found in episodes[0].streams.items()}
    rows = [(joint, found) for joint, found in streams.items()]
    title = f"trundle.JointRecording {recording.name!r}: {len(episodes)} episodes"
    return Card(title, facts, Table(("joint", "streams"), rows))


def _split(episodes: Sequence[EpisodeTable]) -> list[tuple[str, str]]:
    """Return the facts on training, held-out episodes and durations."""
    held_out = [episode.name for episode in episodes if episode.held_out]
    training = [episode.name for episode in episodes if not episode.held_out]
    durations = [episode.duration for episode in episodes]
    return [
        ("training", f"{len(training)}: {join_names(training)}"),
        ("held out", f"{len(held_out)}: {join_names(held_out)}" if held_out else "none"),
        ("duration", f"{sum(durations):.1f} s in total, {_range(durations)} s per episode"),
    ]


def _object(found: dict[str, Any]) -> str:
    parts = []
    if "footprint" in found:
        low, high = np.min(found["footprint"], axis=0), np.max(found["footprint"], axis=0)
        parts.append(f"footprint {high[0] - low[0]:.3g} \N{MULTIPLICATION SIGN} {high[1] - low[1]:.3g} m")
    if "fixture" in found:
        parts.append(f"{len(found['fixture'])} fixtures")
    parts.append(f"mass {found['mass']:.4g} kg" if "mass" in found else "mass not stated")
    if "dof" in found:
        parts.append(f"moves along {', '.join(found['dof'])}")
    return ", ".join(parts)


def _range(values: list[float]) -> str:
    low, high = min(values), max(values)
    return f"{low:.2f}" if f"{low:.2f}" == f"{high:.2f}" else f"{low:.2f} to {high:.2f}"


def _streams(episodes: list[Episode]) -> list[str]:
    """Return the median rate of each stream over the episodes."""
    rates: dict[str, list[float]] = {}
    for episode in episodes:
        for name, stream in episode.streams.items():
            rates.setdefault(name, []).append(stream.rate)
    return [
        f"{name} {np.nanmedian(found):.4g} Hz" if np.isfinite(found).any() else name
        for name, found in rates.items()
    ]


def _wrench(found: dict[str, Any]) -> str:
    raw = "raw, to be tared" if found.get("raw") else "tared"
    return (
        f"{found.get('source', 'measured')}, {raw}, {found['frame']} axes, {found['sign'].replace('_', ' ')}"
    )


def _noise(found: dict[str, Any] | None) -> str:
    if found is None:
        return "not stated, estimated from the data"
    x, y, theta = found["pose"]
    return (
        f"{1e3 * max(x, y):.3g} mm, {1e3 * theta:.3g} mrad, {found['force']:.3g} N, {found['torque']:.3g} N·m"
    )


def model_card(model: Any) -> Card:
    """Return the card of a model."""
    parameters = model.parameters
    free = [parameter["name"] for parameter in parameters if parameter["value"] is None]
    effects = model.effects
    facts = [
        ("effects", join_names(effects) if effects else "none"),
        (
            "free",
            f"{len(free)} of {len(parameters)} parameters" if free else "none: all parameters have values",
        ),
    ]
    rows = [
        (
            parameter["name"],
            "free" if parameter["value"] is None else format_number(parameter["value"]),
            parameter["unit"],
        )
        for parameter in parameters
    ]
    return Card("trundle.Model", facts, Table(("parameter", "value", "unit"), rows))
