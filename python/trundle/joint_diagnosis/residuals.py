"""Efforts of a mechanism along the recorded motion: recorded, required, and those of the fitted laws."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trundle._native import JointRecording, _JointOutcome
from trundle._types import JointMotion
from trundle.joint_diagnosis.drives import FittedDrive
from trundle.joint_diagnosis.signals import JointSignals, read_signals
from trundle.joint_diagnosis.under_test import COMPLIANT, MechanismUnderTest

__all__ = ["JointEfforts", "joint_efforts"]

Floats = NDArray[np.float64]

FILTER_SHARE = 0.1325
"""Standard deviation of a Gaussian filter, s, times its bandwidth, Hz, at half of the amplitude."""


@dataclass(frozen=True)
class JointEfforts:
    """Low-pass filtered series of a joint in an episode, (T,) each.

    Attributes
    ----------
    t, q, v : arrays
        Times and the smoothed motion.
    load : array
        The covariate, or the transmitted load.
    recorded : array
        Effort of the drive; zero without one.
    before, after : array
        Effort that the drive would need with either model; NaN where the laws have no closed form.
    law : array
        Effort of the fitted laws on the joint, dry friction included.
    """

    t: Floats
    q: Floats
    v: Floats
    load: Floats
    recorded: Floats
    before: Floats
    after: Floats
    law: Floats


def joint_efforts(
    recording: JointRecording,
    episode: str,
    motion: JointMotion,
    outcome: _JointOutcome,
    mechanisms: MechanismUnderTest | None,
    largest: Floats,
) -> list[JointEfforts]:
    """Return the efforts of every joint in an episode."""
    own = motion["episodes"][episode]
    rows = np.flatnonzero(own["a"].any(axis=1))
    inner = slice(int(rows[0]), int(rows[-1]) + 1) if len(rows) else slice(0, 0)
    t = own["t"]
    signals = [read_signals(recording, episode, joint, t) for joint in motion["joints"]]
    known = np.stack([one.known for one in signals], axis=1)
    drives, needs, laws, loads = [], [], [], []
    for side, model in zip(("before", "after"), outcome.models, strict=True):
        drive = _drive(FittedDrive(t, signals, motion["joints"], model, largest), signals, own)
        needed, inertial = _needed(recording, motion, own, model, mechanisms, episode)
        load = np.where([one.drive is not None for one in signals], drive, 0.0) - known + needed - inertial
        drives.append(drive)
        needs.append(needed - known)
        loads.append(load)
        laws.append(_laws(outcome, side, own, load, signals, needed - known - drive, mechanisms is not None))
    before = needs[0] - laws[0]
    after = needs[1] - laws[1] - (drives[1] - drives[0])
    if any(one["kind"] in COMPLIANT for one in outcome.models[1]["effects"]):
        after = np.full_like(after, np.nan)
    sd = FILTER_SHARE / motion["bandwidth"] / (t[1] - t[0])
    filtered = [_smooth(each, sd) for each in (drives[0], before, after, laws[1])]
    found = []
    for k, one in enumerate(signals):
        load = loads[1][:, k] if one.load is None else one.load
        series = (t, own["q"][:, k], own["v"][:, k], load, *(each[:, k] for each in filtered))
        found.append(JointEfforts(*(each[inner] for each in series)))
    return found


def _drive(drive: FittedDrive, signals: list[JointSignals], own: Any) -> Floats:
    """Return the effort of the drives at the measured positions, (T, n)."""
    raw = np.stack([one.raw for one in signals], axis=1)
    rows = []
    for time, q, v in zip(own["t"], raw, own["v"], strict=True):
        effort, damping = drive(float(time), q, v)
        rows.append(effort - damping * v)
    return np.array(rows)


def _needed(
    recording: JointRecording,
    motion: JointMotion,
    own: Any,
    model: Mapping[str, Any],
    mechanisms: MechanismUnderTest | None,
    episode: str,
) -> tuple[Floats, Floats]:
    """Return the effort that a model needs without its laws, and the part of the joint's own inertia."""
    offset = np.zeros(len(motion["joints"]))
    for one in model["effects"]:
        if one["kind"] == "encoder_offset":
            offset[motion["joints"].index(one["joint"])] = one["values"]["offset"]
    q, v, a = own["q"] - offset, own["v"], own["a"]
    if mechanisms is not None:
        effort, own_inertia = mechanisms.fitted(episode, model).needed(own["t"], q, v, a)
        return effort, own_inertia * a
    table, nominal = recording.metadata["mechanism"], model["nominal"]
    (joint,) = motion["joints"]
    sine = nominal.get(f"gravity_sin:{joint}", table.get("gravity_torque", 0.0))
    cosine = nominal.get(f"gravity_cos:{joint}", 0.0)
    inertia = nominal.get(f"inertia:{joint}", table.get("inertia", 1.0)) + nominal.get(
        f"armature:{joint}", 0.0
    )
    needed = inertia * a + sine * np.sin(q) + cosine * np.cos(q) + nominal.get(f"damping:{joint}", 0.0) * v
    return needed, inertia * a


def _laws(
    outcome: _JointOutcome,
    side: str,
    own: Any,
    load: Floats,
    signals: list[JointSignals],
    missing: Floats,
    has_model: bool,
) -> Floats:
    """Return the effort of a model's laws, (T, n); at rest friction exerts the missing effort."""
    out: Floats = np.zeros_like(own["q"])
    driven = [one.drive is not None for one in signals]
    for k, (q, v, a) in enumerate(zip(own["q"], own["v"], own["a"], strict=True)):
        drive = np.where(driven, load[k], np.nan).tolist()
        external = np.where(driven, 0.0, -load[k]).tolist()
        covariates = [None if one.load is None else float(one.load[k]) for one in signals]
        effort, dry, inertia = map(
            np.array, outcome.terms(side, q.tolist(), v.tolist(), drive, external, covariates)
        )
        friction = np.where(v == 0, np.clip(missing[k], -dry, dry), -dry * np.sign(v))
        # A fitted mechanism already has the armature that laws add; an axis does not.
        out[k] = effort + friction - (0.0 if has_model else inertia * a)
    return out


def _smooth(values: Floats, sd: float) -> Floats:
    """Return series, (T, n), after a Gaussian filter of a standard deviation in samples."""
    half = max(1, int(4 * sd))
    weights = np.exp(-0.5 * (np.arange(-half, half + 1) / max(sd, 1e-9)) ** 2)
    padded = np.pad(values, ((half, half), (0, 0)), mode="edge")
    columns = [np.convolve(column, weights / weights.sum(), mode="valid") for column in padded.T]
    return np.stack(columns, axis=1)
