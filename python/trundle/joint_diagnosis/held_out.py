"""Open-loop simulation of the held-out episodes of a mechanism with a model, and the errors of positions."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from trundle._native import JointRecording, _JointOutcome
from trundle._types import JointAnswer, JointMotion
from trundle.joint_diagnosis.drives import FittedDrive, FittedLaws
from trundle.joint_diagnosis.signals import JointSignals, read_signals, setting
from trundle.joint_diagnosis.under_test import MechanismUnderTest

__all__ = ["Path", "axis_paths", "fill_position_figures", "largest_commands", "mechanism_paths"]

Floats = NDArray[np.float64]
Side = Literal["before", "after"]

WINDOW_S = 1.0
"""Length of a prediction window, s."""
MAX_WINDOW_SHARE = 0.1
"""Longest window as a share of the episode."""
MIN_RANGE_SDS = 10.0
"""Range of a joint's positions, noise standard deviations, below which its relative errors make no sense."""


@dataclass(frozen=True)
class Path:
    """Positions in a held-out episode, as recorded and as simulated in open loop.

    Attributes
    ----------
    t : (T,) array
        Times from the first state, s.
    observed : (T, n) array
    before, after : (T, n) array or None
        None where a law cannot be simulated; NaN after a divergence.
    window_errors : dict
        By "before" and "after": errors within windows, (M, n), or None.
    """

    t: Floats
    observed: Floats
    before: Floats | None
    after: Floats | None
    window_errors: Mapping[str, Floats | None]


def axis_paths(predictions: Mapping[str, Mapping[str, Any]]) -> dict[str, Path]:
    """Return the simulations of an axis without a model, whose figures the native module computes."""
    return {
        name: Path(own["t"], own["observed"][:, None], _column(own["before"]), _column(own["after"]), {})
        for name, own in predictions.items()
    }


def _column(values: Floats | None) -> Floats | None:
    return None if values is None else values[:, None]


def mechanism_paths(
    recording: JointRecording,
    motion: JointMotion,
    mechanisms: MechanismUnderTest,
    outcome: _JointOutcome,
) -> dict[str, Path]:
    """Simulate every held-out episode before and after, whole and in windows."""
    held_out = [name for name, episode in recording.items() if episode.held_out]
    largest = largest_commands(recording, motion) if held_out else np.empty(0)
    found = {}
    for name in held_out:
        own = motion["episodes"][name]
        if len(own["t"]) < 4:
            continue
        signals = [read_signals(recording, name, joint, own["t"]) for joint in motion["joints"]]
        first = _first_compared(own["a"])
        raw = np.stack([one.raw for one in signals], axis=1)
        start, state = first, (own["q"][first], own["v"][first])
        if recording.metadata.get("start", {}).get("at_rest", False):
            start, state = 0, (raw[0], np.zeros(len(signals)))
        whole: dict[str, Floats | None] = {}
        windows: dict[str, Floats | None] = {}
        for side, model in zip(("before", "after"), outcome.models, strict=True):
            run = _Run(mechanisms, name, motion, model, signals, largest)
            if not run.mechanism.can_simulate:
                whole[side] = windows[side] = None
                continue
            laws = FittedLaws(outcome, side, own["t"], signals) if model["effects"] else None  # type: ignore[arg-type]
            whole[side] = run.simulate(slice(start, None), *state, laws)
            windows[side] = np.concatenate([np.empty((0, len(signals))), *run.window_errors(first, laws)])
        found[name] = Path(own["t"][start:], raw[start:], whole["before"], whole["after"], windows)
    return found


class _Run:
    """Simulations of one episode with one model."""

    def __init__(
        self,
        mechanisms: MechanismUnderTest,
        name: str,
        motion: JointMotion,
        model: Mapping[str, Any],
        signals: list[JointSignals],
        largest: Floats,
    ) -> None:
        joints = motion["joints"]
        self.own = motion["episodes"][name]
        self.t = self.own["t"]
        self.raw = np.stack([one.raw for one in signals], axis=1)
        self.mechanism = mechanisms.fitted(name, model)
        self.drive = FittedDrive(self.t, signals, joints, model, largest)
        known = np.stack([one.known for one in signals], axis=1)
        self.known = known if known.any() else None
        self.offset = np.zeros(len(joints))
        for one in model["effects"]:
            if one["kind"] == "encoder_offset":
                self.offset[joints.index(one["joint"])] = one["values"]["offset"]

    def simulate(self, rows: slice, q: Floats, v: Floats, laws: FittedLaws | None) -> Floats:
        """Return measured positions, (T, n), from a measured state."""
        from trundle.mechanism import EffortDrive

        known = None if self.known is None else EffortDrive(self.t, self.known)
        found = self.mechanism.simulate(self.t[rows], q - self.offset, v, self.drive, laws, known)
        return found + self.offset

    def window_errors(self, first: int, laws: FittedLaws | None) -> Iterator[Floats]:
        """Yield the errors of windows that begin with a state from earlier samples only."""
        duration, dt = self.t[-1] - self.t[0], self.t[1] - self.t[0]
        size = max(int(min(WINDOW_S, MAX_WINDOW_SHARE * duration) / dt), 2)
        for start in range(first, len(self.t) - size, size):
            rows = slice(start, start + size)
            q, v = self.own["causal_q"][start], self.own["causal_v"][start]
            yield self.simulate(rows, q, v, laws) - self.raw[rows]


def fill_position_figures(answer: JointAnswer, recording: JointRecording, paths: Mapping[str, Path]) -> None:
    """Fill the errors of positions in held-out episodes, in place."""
    pair = answer["fit"]["held_out"]
    if not pair or not paths:
        return
    joints = recording.joints
    spans = np.array(list(position_spans(recording).values()))
    for side in ("before", "after"):
        whole = [_difference(getattr(path, side), path.observed) for path in paths.values()]
        windows = [path.window_errors[side] for path in paths.values()]
        for errors, key, pooled in (
            (whole, "position_rmse", "relative_position_rmse"),
            (windows, "window_position_rmse", "relative_window_rmse"),
        ):
            known = [one for one in errors if one is not None and len(one)]
            if len(known) < len(errors):
                continue
            rms = np.sqrt(np.mean(np.concatenate(known) ** 2, axis=0))
            for joint, value in zip(joints, rms, strict=True):
                pair[side]["joints"][joint][key] = float(value) if np.isfinite(value) else None
            relative = (rms / spans)[np.isfinite(spans)]
            if len(relative) and np.isfinite(relative).all():
                pair[side][pooled] = float(np.sqrt(np.mean(relative**2)))


def _difference(simulated: Floats | None, observed: Floats) -> Floats | None:
    return None if simulated is None else simulated - observed


def position_spans(recording: JointRecording) -> dict[str, float]:
    """Return the range of each joint's training positions, rad or m; infinite if it is within the noise."""
    found = {}
    for joint in recording.joints:
        values = [one.stream("q", joint)[1] for one in recording.values() if not one.held_out]
        span = np.ptp(np.concatenate(values)) if values else np.inf
        sd = setting(recording.metadata, "", "noise", "position", joint, 0.0)
        found[joint] = float(span) if span > MIN_RANGE_SDS * sd and span > 0 else np.inf
    return found


def largest_commands(recording: JointRecording, motion: JointMotion) -> Floats:
    """Return the largest recorded effort, or error of the target, of the training episodes, (n,)."""
    found = []
    for joint in motion["joints"]:
        largest = 0.0
        for name, episode in recording.items():
            if episode.held_out:
                continue
            one = read_signals(recording, name, joint, motion["episodes"][name]["t"])
            error = one.command - (one.raw if one.drive == "target" else 0.0)
            largest = max(largest, float(np.abs(error).max(initial=0.0)))
        found.append(largest)
    return np.array(found)


def _first_compared(a: Floats) -> int:
    """Return the first sample whose acceleration is known: earlier ones are zero."""
    known = np.flatnonzero(a.any(axis=1))
    return int(known[0]) if len(known) else 0
