"""Drives and laws of a fitted mechanism in a forward simulation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from trundle._native import _JointOutcome
from trundle.held_samples import TIME_TOLERANCE
from trundle.joint_diagnosis.signals import JointSignals

__all__ = ["FittedDrive", "FittedLaws"]

Floats = NDArray[np.float64]


class FittedDrive:
    """The drives of all joints after the effects of delays, lags, gains, biases, droop and saturation.

    Parameters
    ----------
    t : (T,) array
        Uniform times, s.
    signals : sequence of JointSignals
        Of each joint.
    joints : sequence of str
    model : mapping
        Nominal values and effects.
    largest : (n,) array
        Largest command of the training episodes, in recorded units.
    """

    def __init__(
        self,
        t: Floats,
        signals: Sequence[JointSignals],
        joints: Sequence[str],
        model: Mapping[str, Any],
        largest: Floats,
    ) -> None:
        nominal = model["nominal"]
        self.start, self.dt = float(t[0]), float(t[1] - t[0])
        self.effects = [
            {one["kind"]: one["values"] for one in model["effects"] if one.get("joint") == joint}
            for joint in joints
        ]
        self.on = np.stack([one.on for one in signals], axis=1)
        self.held = np.array([one.is_held for one in signals])
        self.has_target = np.array([one.drive == "target" for one in signals])
        self.limit = np.array([one.limit for one in signals])
        stiffness = [
            _value(one.gain, nominal, "drive_stiffness" if one.drive == "target" else "gain", joint, 1.0)
            for one, joint in zip(signals, joints, strict=True)
        ]
        self.stiffness = np.where(self.has_target, stiffness, 0.0)
        self.back_emf = np.array([nominal.get(f"back_emf:{joint}", 0.0) for joint in joints])
        self.damping = self.back_emf + [
            _value(one.damping, nominal, "drive_damping", joint, 0.0) if one.drive == "target" else 0.0
            for one, joint in zip(signals, joints, strict=True)
        ]
        self.largest = np.maximum(largest * np.abs(stiffness), np.finfo(float).tiny)
        columns = []
        for k, one in enumerate(signals):
            command = late_command(one.command, self.effects[k], self.dt)
            if one.drive == "effort":
                command = self._act(k, _corrected(command * stiffness[k], self.effects[k]))
            columns.append(command)
        self.commands = np.stack(columns, axis=1)
        self.any_target = bool(self.has_target.any())

    def __call__(self, t: float, q: Floats, v: Floats) -> tuple[Floats, Floats]:
        """Return effort and damping, (n,) each."""
        place = (t - self.start) / self.dt
        k = min(max(int(place + TIME_TOLERANCE), 0), len(self.commands) - 1)
        following = min(k + 1, len(self.commands) - 1)
        share = np.where(self.held, 0.0, min(max(place - k, 0.0), 1.0))
        command = self.commands[k] + share * (self.commands[following] - self.commands[k])
        on = self.on[k]
        if not self.any_target:
            return command * on, self.back_emf * on
        effort = np.where(self.has_target, self.stiffness * (command - q), command)
        damping = self.damping.copy()
        for j in np.flatnonzero(self.has_target).tolist():
            wanted = effort[j] - damping[j] * v[j]
            acting = float(np.clip(self._act(j, np.array(wanted)), -self.limit[j], self.limit[j]))
            if acting == wanted:
                continue
            effort[j], damping[j] = acting, 0.0
        return effort * on, damping * on

    def _act(self, j: int, effort: Floats) -> Floats:
        """Return the effort of a drive whose effect is droop or saturation."""
        effects = self.effects[j]
        if "drive_gain_droop" in effects:
            effort = effort * (1 - effects["drive_gain_droop"]["droop"] * np.abs(effort) / self.largest[j])
        if "effort_saturation" in effects:
            limit = effects["effort_saturation"]["limit"]
            effort = np.clip(effort, -limit, limit)
        return effort


class FittedLaws:
    """Laws at the joints of a fitted mechanism: see `trundle.mechanism.simulation.JointLaws`.

    Parameters
    ----------
    outcome : _JointOutcome
    which : {"before", "after"}
    t : (T,) array
        Uniform times, s.
    signals : sequence of JointSignals
        Of each joint.
    """

    def __init__(
        self,
        outcome: _JointOutcome,
        which: Literal["before", "after"],
        t: Floats,
        signals: Sequence[JointSignals],
    ) -> None:
        self.outcome, self.which = outcome, which
        self.start, self.dt, self.last = float(t[0]), float(t[1] - t[0]), len(t) - 1
        self.driven = np.array([one.drive is not None for one in signals])
        self.loads = [one.load for one in signals]
        self.zero = np.zeros(len(signals))

    def __call__(self, t: float, q: Floats, v: Floats, load: Floats) -> tuple[Floats, Floats, Floats]:
        """Return effort, dry friction and damping, (n,) each."""
        k = min(max(int((t - self.start) / self.dt + TIME_TOLERANCE), 0), self.last)
        covariates = [None if one is None else float(one[k]) for one in self.loads]
        drive = np.where(self.driven, load, np.nan)
        external = np.where(self.driven, 0.0, -load)
        effort, dry, _ = self.outcome.terms(
            self.which, q.tolist(), v.tolist(), drive.tolist(), external.tolist(), covariates
        )
        return np.array(effort), np.array(dry), self.zero


def _value(given: float | str, nominal: Mapping[str, float], key: str, joint: str, default: float) -> float:
    """Return a given number, or the fitted value of one that is free."""
    return nominal.get(f"{key}:{joint}", default) if given == "free" else float(given)


def _corrected(reading: Floats, effects: Mapping[str, Mapping[str, float]]) -> Floats:
    """Return the true effort for a reading with a wrong gain or bias."""
    if "effort_gain" in effects:
        reading = reading / effects["effort_gain"]["gain"]
    if "effort_bias" in effects:
        reading = reading - effects["effort_bias"]["bias"]
    return reading


def late_command(command: Floats, effects: Mapping[str, Mapping[str, float]], dt: float) -> Floats:
    """Return a command after the delays and lags of the drive and of its reading."""
    drive, reading = (effects.get(kind, {}).get("delay", 0.0) for kind in ("drive_delay", "effort_delay"))
    command = delayed(command, drive - reading, dt)
    for kind, sign in (("drive_lag", 1.0), ("effort_lag", -1.0)):
        if kind in effects:
            command = lagged(command, sign * effects[kind]["time_constant"], dt)
    return command


def delayed(samples: Floats, delay: float, dt: float) -> Floats:
    """Return uniform samples at times that are earlier by `delay` seconds, by linear interpolation."""
    place = np.arange(len(samples), dtype=float)
    return np.interp(place - delay / dt, place, samples)


def lagged(samples: Floats, lag: float, dt: float) -> Floats:
    """Return samples after a first-order lag; a negative time constant inverts the lag of a reading."""
    if lag <= dt:
        return samples - lag * np.gradient(samples, dt)
    share = 1.0 - float(np.exp(-dt / lag))
    out = np.empty_like(samples)
    state = previous = samples[0]
    for k, sample in enumerate(samples):
        state += share * ((previous + sample) / 2 - state)
        previous = sample
        out[k] = state
    return out
