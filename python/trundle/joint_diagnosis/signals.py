"""The recorded streams of an episode at the times of its smoothed motion."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trundle._native import JointRecording
from trundle.held_samples import held_means

__all__ = ["JointSignals", "read_signals", "setting"]

Floats = NDArray[np.float64]

HELD_SOURCES = ("commanded", "voltage")
"""Sources of efforts that are held until the next sample."""


@dataclass(frozen=True)
class JointSignals:
    """Streams of a joint at T times; angles in rad.

    Attributes
    ----------
    drive : {"effort", "target"} or None
        What drives the joint.
    raw : (T,) array
        Measured position.
    command : (T,) array
        Recorded effort, or target. Held commands are means over the interval that begins at each time.
    known : (T,) array
        Known further effort.
    on : (T,) array
        Share of the interval in which the drive is switched on.
    load : (T,) array or None
        Covariate of the friction.
    is_held : bool
        Whether commands are held until the next sample.
    gain : float or "free"
        Of the effort, or the stiffness of a target drive.
    damping : float or "free"
        Of a target drive.
    limit : float
        Of a target drive.
    """

    drive: str | None
    raw: Floats
    command: Floats
    known: Floats
    on: Floats
    load: Floats | None
    is_held: bool
    gain: float | str
    damping: float | str
    limit: float


def setting(
    metadata: Mapping[str, Any], episode: str, section: str, key: str, joint: str, default: Any
) -> Any:
    """Return a value of a section such as `[effort]`; an episode may replace efforts and targets."""
    own = metadata.get("episode", {}).get(episode, {})
    value = metadata.get(section, {}).get(key, default)
    if section in ("effort", "target"):
        value = own.get(section, {}).get(key, own.get(key, value))
    return value.get(joint, default) if isinstance(value, Mapping) else value


def read_signals(recording: JointRecording, episode: str, joint: str, t: Floats) -> JointSignals:
    """Return the streams of a joint at uniform times."""
    metadata, own = recording.metadata, recording[episode]

    def value(section: str, key: str, default: Any) -> Any:
        return setting(metadata, episode, section, key, joint, default)

    def sampled(prefix: str, default: float | None, *, hold: bool = False) -> Floats | None:
        if f"{prefix}_{joint}" not in own:
            return None if default is None else np.full(len(t), default)
        times, values = own.stream(prefix, joint)
        times = times - value("delay", prefix, 0.0)
        return held_means(times, values, t) if hold else np.interp(t, times, values)

    has_effort = f"effort_{joint}" in own and value("effort", "signed", True)
    has_target = f"target_{joint}" in own
    drive = "effort" if has_effort else "target" if has_target else None
    is_held = drive == "target" or value("effort", "source", "measured") in HELD_SOURCES
    command = np.zeros(len(t)) if drive is None else sampled(drive, 0.0, hold=is_held)
    key = ("target", "stiffness", "free") if drive == "target" else ("effort", "gain", 1.0)
    raw, known, on = sampled("q", 0.0), sampled("known", 0.0), sampled("on", 1.0, hold=True)
    assert raw is not None and command is not None and known is not None and on is not None
    return JointSignals(
        drive=drive,
        raw=raw,
        command=command,
        known=known,
        on=on,
        load=sampled("load", None),
        is_held=is_held,
        gain=value(*key),
        damping=value("target", "damping", "free"),
        limit=float(value("target", "limit", np.inf)) if drive == "target" else np.inf,
    )
